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

/// Rejection sampling (4.9): the accepted samples as they are. Clusters are led back to the surface by their best sample.
struct RejectionSampling {};

using Method = std::variant<RejectionSampling, SteepestDescent, GaussNewton>;

struct SenseOptions {
  FrictionCone cone{1, 4};
  double noise = 0.1;  ///< standard deviation of each torque [N·m], > 0; `torques` may have one for each joint
  std::optional<double>
      threshold{};  ///< contacts are looked for where max |τ_j| is at least this [N·m], > 0; nullopt: TorqueModel::deviations times the noise of joint j
  /// Samples with l up to this are accepted [(N·m)²]; nullopt: accept_share ‖τ‖², or what noise may make if that is more. δ of RSGD (4.10)
  /// and ε of rejection sampling (4.9), in the units of (4.5): twice those of the thesis's figures.
  std::optional<double> accept{};
  double accept_share = 0.05;     ///< [-]
  double tolerance = 0.01;        ///< [-] of ‖τ‖ that an explanation may leave where there is no noise
  Method method = GaussNewton{};  ///< SteepestDescent: RSGD as published
  double merge = 3;               ///< points nearer than this many sample spacings are one candidate
  double thin = 2;  ///< Gauss–Newton leaves out starts within so many sample spacings of an earlier start or of an end, ≥ 0
  /// Most descents from samples in a call, the best samples first, beside those from the last cycle; ≥ 1. nullopt: from all that are accepted.
  std::optional<int> max_descents{};
  /// F of the ranking [N], > 0: candidates that explain are ordered by l + (noise/F)² ‖f‖² (Y.14); nullopt: calc_plausible_force() of the arm.
  std::optional<double> plausible_force{};
  /// Share by which the true μ may exceed that of the cone, in [0, 1): where nothing explains, contacts are looked for with μ/(1 − friction_error).
  double friction_error = 0;
  /// Rest, sign, noise of each joint, joints without a sensor. With such noise residuals and all that follows from them are those of torques in whose coordinates
  /// each has the same noise (Y.17).
  TorqueModel torques{};
  /// Probabilities as well, by which candidates that explain are then ordered: first by link, then by place. Their forces have the standard deviation
  /// `plausible_force`, or one that is not known: 4 N, what the weakest joint holds at its full reach (30 N at least), or their geometric mean.
  bool posterior = false;
  double touch_prior = 0.5;  ///< p of Posterior, in (0, 1)
  void validate() const;     ///< @throws core::InvalidInput naming the field
};

/// What three standard deviations of ‖ε‖² leave, ε with n independent normal components: a χ² distribution of mean n and variance 2n [noise²].
double calc_noise_bound(double noise, Eigen::Index n);

/// F, the deviation of forces before torques are seen: what the weakest joint holds at its full reach, min τ_max/reach [N]; nullopt where no effort is stated.
std::optional<double> calc_plausible_force(const world::Model& model);

/// ρ = σ²/F² of (Y.2) [m²]. @param force  F [N]; nullopt: calc_plausible_force(), and where no effort is stated the force that makes the torques at a
/// hundredth of the size of the smallest link  @param noise  σ [N·m]  @param tau  length of the torques [N·m]
double calc_prior(const Sensor& sensor, double noise, double tau, std::optional<double> force = {});

enum class Verdict {
  BelowThreshold,  ///< no contact, or one that these torques do not show
  Explained,       ///< at least one candidate makes the torques, as far as noise and tolerance tell
  Unexplained      ///< a single contact on the sensed links does not: several contacts, another link, or a wrong μ
};
std::string_view to_string(Verdict verdict) noexcept;

/// A cluster of points that explain the torques alike. A valley is one candidate with its extent.
struct Candidate {
  ContactPoint best;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero(), n_W = Eigen::Vector3d::Zero(), f_W = Eigen::Vector3d::Zero();
  bool explains = false;
  double objective = 0;  ///< min l + ρ ‖f‖² (Y.14) at the best point [(N·m)²]: (l + ρ ‖f‖²)/noise² is −2 ln of a posterior
  int rank = 0;          ///< of J_C: below 3 the force is not unique
  double extent = 0;     ///< largest distance of its points from the best one, of those as good as noise and tolerance tell [m]
  double force_spread = 0;   ///< largest distance of their forces from f, in W [N]
  double probability = 0;    ///< of the places on its link that are nearest to it, where probabilities were asked for
  int first = 0, count = 0;  ///< its points in SenseResult::points, by residual
};

struct BaseWrench;

struct SenseInput {
  VectorRef q;                                      ///< (n_q)
  VectorRef tau;                                    ///< (n_a) external torques, in the order of u [N·m; N]
  const std::vector<ContactPoint>* last = nullptr;  ///< best points of the last cycle, from which descents start as well
  /// What a sensor under the base measures at the same time, of which every residual then has six rows more (Y.9a). Without probabilities; nullptr: none.
  const BaseWrench* base = nullptr;
};

struct SenseResult {
  Verdict verdict = Verdict::BelowThreshold;
  std::vector<Candidate> candidates;  ///< those that explain, by objective; then the others, by residual
  std::vector<ContactPoint> points;   ///< where descents ended, by candidate
  double explained = 0;               ///< l up to which torques count as explained [(N·m)²]
  WhitenedTorques::Largest largest;   ///< of the torques against its noise, less rest
  double threshold = 0;               ///< from which that joint would have shown a contact [N·m; N]
  double noise = 0;                   ///< of each torque in the coordinates of residuals: l/noise² has no unit [N·m]
  Posterior posterior;                ///< where it was asked for; else without links
  double friction = 0;                ///< μ with which they were looked for: that of the cone, or more where that explained nothing
  int samples = 0, accepted = 0, descents = 0, converged = 0;

  std::vector<ContactPoint> best_points() const;  ///< of the candidates, for SenseInput::last
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

/// Every single contact on the sensed links that makes the torques: samples (4.9) or (4.10), descents (4.11), clusters. No heap use once
/// workspace and result have met as many points.
/// @throws core::InvalidInput: q or tau of the wrong size or not finite, options, points of the last cycle that are not on this sensor,
/// a wrench at the base together with probabilities
void sense(const Sensor& sensor, const SenseInput& input, const SenseOptions& options, SenseWorkspace& work, SenseResult& out);

/// Several moments of one touch: the same place on the same link, with another force at each moment. Candidates are those of the moment whose torques are largest against
/// their noise; probabilities are products of the evidence of all moments to the power 1/(1 + (m − 1) ρ), the share of m moments that is new where their errors
/// correlate by ρ, as they do with one error of the rest. Probabilities are always asked for.
/// @param q (n_q × m)  @param tau (n_a × m)  @param correlation  ρ, in [0, 1]  @throws core::InvalidInput: as sense(), no moment
void sense_touch(const Sensor& sensor, const Eigen::MatrixXd& q, const Eigen::MatrixXd& tau, double correlation,
                 const SenseOptions& options, SenseWorkspace& work, SenseResult& out);

/// The torques (n_a) of a force on a link at q: f_L at p_L in the link's frame (Y.1).
Eigen::VectorXd calc_contact_torque(const world::Model& model, VectorRef q, int body, const Eigen::Vector3d& p_L,
                                    const Eigen::Vector3d& f_L);

}  // namespace stiction::sensing
