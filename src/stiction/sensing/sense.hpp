#pragma once

#include <memory>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "stiction/sensing/descent.hpp"
#include "stiction/sensing/posterior.hpp"
#include "stiction/sensing/torque_noise.hpp"

namespace stiction::sensing {

/// Rejection sampling (4.9): uses the accepted samples without descents. The best sample represents its cluster.
struct RejectionSampling {};

using Method = std::variant<RejectionSampling, SteepestDescent, GaussNewton>;

struct SenseOptions {
  FrictionCone cone{1, 4};
  double noise = 0.1;  ///< standard deviation of each torque [N·m], > 0; `torques` may give each joint its own
  std::optional<double>
      threshold{};  ///< smallest max |τ_j| for which contacts are sought [N·m], > 0; nullopt: TorqueModel::deviations times the noise of joint j
  /// Largest l of an accepted sample [(N·m)²]; nullopt: accept_share ‖τ‖², or calc_noise_bound() if that is larger. This is δ of RSGD
  /// (4.10) and ε of rejection sampling (4.9), in the units of (4.5): twice those of the thesis's figures.
  std::optional<double> accept{};
  double accept_share = 0.05;     ///< [-]
  double tolerance = 0.01;        ///< share of ‖τ‖ that an explanation may leave unexplained without noise [-]
  Method method = GaussNewton{};  ///< SteepestDescent: RSGD as published
  double merge = 3;               ///< points nearer than this many sample spacings form one candidate
  double thin = 2;                ///< Gauss–Newton skips starts within this many sample spacings of an earlier start or end, ≥ 0
  /// Largest number of descents from samples in a call, best samples first, in addition to the descents from the last cycle; ≥ 1. nullopt:
  /// all accepted samples.
  std::optional<int> max_descents{};
  /// F of the ranking [N], > 0: candidates that explain are ordered by l + (noise/F)² ‖f‖² (Y.14); nullopt: calc_plausible_force() of the arm.
  std::optional<double> plausible_force{};
  /// Share by which the true μ may exceed the μ of the cone, in [0, 1). If no candidate explains the torques, the search uses
  /// μ/(1 − friction_error).
  double friction_error = 0;
  /// Rest, sign and noise of each joint, and joints without a sensor. If joints differ in noise, residuals and all derived quantities refer
  /// to the whitened torques (Y.17), which all have the same noise.
  TorqueModel torques{};
  /// Whether to compute probabilities. They then order the candidates that explain the torques, first by link, then by place. Forces have
  /// the standard deviation `plausible_force`. Without it, three deviations are averaged: 4 N, the force that the weakest joint holds at
  /// its full reach (at least 30 N), and their geometric mean.
  bool posterior = false;
  double touch_prior = 0.5;  ///< p of Posterior, in (0, 1)
  void validate() const;     ///< @throws core::InvalidInput naming the field
};

/// Upper bound on ‖ε‖² for torque noise ε with n independent normal components: mean plus three standard deviations of a χ² distribution,
/// whose mean is n and whose variance is 2n [noise²].
double calc_noise_bound(double noise, Eigen::Index n);

/// F, the prior standard deviation of forces: the force that the weakest joint holds at its full reach, min τ_max/reach [N]; nullopt if no
/// effort is stated.
std::optional<double> calc_plausible_force(const world::Model& model);

/// ρ = σ²/F² of (Y.2) [m²]. @param force  F [N]; nullopt: calc_plausible_force(); if no effort is stated, the force that causes the torques
/// with a lever of a hundredth of the size of the smallest link  @param noise  σ [N·m]  @param tau  length of the torques [N·m]
double calc_prior(const Sensor& sensor, double noise, double tau, std::optional<double> force = {});

enum class Verdict {
  BelowThreshold,  ///< no contact, or a contact too weak for these torques to show
  Explained,       ///< at least one candidate explains the torques within noise and tolerance
  Unexplained      ///< no single contact on the sensed links explains them: several contacts, another link, or a wrong μ
};
std::string_view to_string(Verdict verdict) noexcept;

/// A cluster of points that explain the torques equally well. A valley of l is one candidate with an extent.
struct Candidate {
  ContactPoint best;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero(), n_W = Eigen::Vector3d::Zero(), f_W = Eigen::Vector3d::Zero();
  bool explains = false;
  double objective = 0;  ///< min l + ρ ‖f‖² (Y.14) at the best point [(N·m)²]: (l + ρ ‖f‖²)/noise² is −2 ln of a posterior
  int rank = 0;          ///< rank of J_C: below 3 the force is not unique
  double extent = 0;     ///< largest distance from the best point to a point that is as good within noise and tolerance [m]
  double force_spread = 0;   ///< largest difference of the forces of these points from the best force, in W [N]
  double probability = 0;    ///< sum over the places on its link that are nearest to it, if probabilities were requested
  int first = 0, count = 0;  ///< range of its points in SenseResult::points, ordered by residual
};

struct BaseWrench;

struct SenseInput {
  VectorRef q;                                      ///< (n_q)
  VectorRef tau;                                    ///< (n_a) external torques, in the order of u [N·m; N]
  const std::vector<ContactPoint>* last = nullptr;  ///< best points of the last cycle, which are further starts of descents
  /// Wrench of a sensor under the base at the same time; it adds six rows to every residual (Y.9a). Not together with probabilities;
  /// nullptr: none.
  const BaseWrench* base = nullptr;
};

struct SenseResult {
  Verdict verdict = Verdict::BelowThreshold;
  std::vector<Candidate> candidates;  ///< candidates that explain the torques, by objective; then the others, by residual
  std::vector<ContactPoint> points;   ///< ends of descents, by candidate
  double explained = 0;               ///< largest l at which torques count as explained [(N·m)²]
  WhitenedTorques::Largest largest;   ///< the torque minus rest that is largest relative to its noise
  double threshold = 0;               ///< smallest torque of that joint that shows a contact [N·m; N]
  double noise = 0;                   ///< noise of each torque in the coordinates of residuals [N·m]; l/noise² has no unit
  Posterior posterior;                ///< if requested; otherwise without links
  double friction = 0;                ///< μ of the search: that of the cone, or a larger one if that explained nothing
  int samples = 0, accepted = 0, descents = 0, converged = 0;

  std::vector<ContactPoint> best_points() const;  ///< best points of the candidates, for SenseInput::last
};

/// Scratch of sense(); one per thread.
class SenseWorkspace {
 public:
  explicit SenseWorkspace(std::shared_ptr<const Sensor> sensor);
  ~SenseWorkspace();
  SenseWorkspace(SenseWorkspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Finds every single contact on the sensed links that explains the torques: samples (4.9) or (4.10), descents (4.11), clusters. No heap
/// use once workspace and result have held as many points.
/// @throws core::InvalidInput: q or tau of the wrong size or not finite, options, points of the last cycle that are not on this sensor,
/// a wrench at the base together with probabilities
void sense(const Sensor& sensor, const SenseInput& input, const SenseOptions& options, SenseWorkspace& work, SenseResult& out);

/// Evaluates several moments of one touch: the same place on the same link, with another force at each moment. The candidates are those of
/// the moment whose torques are largest relative to their noise. Probabilities follow from the product of the evidence of all m moments to
/// the power 1/(1 + (m − 1) ρ). This power is the share of independent information if errors correlate by ρ, for example because of one
/// error of the rest. Probabilities are always computed.
/// @param q (n_q × m)  @param tau (n_a × m)  @param correlation  ρ, in [0, 1]  @throws core::InvalidInput: as sense(), no moment
void sense_touch(const Sensor& sensor, const Eigen::MatrixXd& q, const Eigen::MatrixXd& tau, double correlation,
                 const SenseOptions& options, SenseWorkspace& work, SenseResult& out);

/// Computes the torques (n_a) of a force on a link at q: f_L at p_L in the link's frame (Y.1).
Eigen::VectorXd calc_contact_torque(const world::Model& model, VectorRef q, int body, const Eigen::Vector3d& p_L,
                                    const Eigen::Vector3d& f_L);

}  // namespace stiction::sensing
