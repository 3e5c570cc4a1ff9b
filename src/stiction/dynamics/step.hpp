#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "stiction/cone/solver.hpp"
#include "stiction/contact/contact.hpp"
#include "stiction/core/status.hpp"
#include "stiction/world/model.hpp"

namespace stiction::dynamics {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// Local model of the contact dynamics: exact (2.6) or smoothed by a log barrier (2.27).
struct Exact {};
struct Analytic {
  double kappa = 100.0;  ///< barrier weight [1/J]; larger is closer to Exact
  double self_sharpness =
      10;  ///< κ of contacts among robot parts and fixed bodies is this times kappa: they bound motion, they do not push
  double limit_sharpness = 10;  ///< the same for joint limits
};
using Smoothing = std::variant<Exact, Analytic>;

/// Friction of spatial models; planar ones have two rays, which is exact.
struct SecondOrderCone {};  ///< φ + J_n δq ≥ μ‖J_t δq‖
/// φ + J_n δq ≥ μ d_kᵀJ_t δq for rays d_k = (cos 2πk/n, sin 2πk/n) in (t1, t2): the force lies in the pyramid spanned by n + μ d_k,
/// inside the cone.
struct PolyhedralCone {
  int rays = 4;  ///< n_d, in [3, 64]
};
using FrictionCone = std::variant<SecondOrderCone, PolyhedralCone>;

/// Regularisation ε M_u / h of the objects in (2.6c).
struct ByRule {
  double ratio = 0.1;  ///< λ_max(ε M_u/h) = ratio · λ_min(h K_a), see docs/theory/step.md; > 0
};
struct FixedEpsilon {
  double epsilon = 1.0;  ///< 1 = true mass (quasi-dynamic); > 0
};
using Regularisation = std::variant<ByRule, FixedEpsilon>;

/// What a sliding contact does.
enum class FrictionLaw {
  Anitescu,  ///< it opens by μ‖J_t δq‖, the gap of the convex relaxation (2.3.4)
  /// It stays closed: φ + J_n δq ≥ 0 instead, De Saxcé's fixed point (docs/theory/step.md, S.14), of exact steps of spatial models with
  /// second-order cones. Where that is not found to within 0.003 L the step is Anitescu's. Every step is solved cold, so that it follows from its
  /// input alone.
  Coulomb
};

struct StepOptions {
  double h = 0.1;  ///< time step [s], > 0
  Smoothing smoothing = Exact{};
  Regularisation regularisation = ByRule{};
  FrictionCone friction_cone = SecondOrderCone{};
  FrictionLaw friction_law = FrictionLaw::Anitescu;  ///< of exact steps; smoothed ones and local models have Anitescu's
  double friction_scale = 1.0;                       ///< multiplies every μ, ≥ 0
  double contact_margin = 0.0;                       ///< added to the model's contact distance [m], ≥ 0
  bool with_B = false;                               ///< also D_qnext_u
  bool with_A = false;                               ///< also D_qnext_q
  bool with_force_derivatives = false;               ///< also D_lambda_q with A, D_lambda_u with B; needs one of them
  bool joint_limits = true;
  bool effort_limits = false;  ///< robot joints push with world::Model::effort at most (S.15); off, springs have no limit
  bool contacts_within_reach =
      false;  ///< of exact steps: contacts of meshes and flat sides are listed only where the step may reach them (S.22)
  bool warm_start = true;
  double tol_complementarity = 1e-10;  ///< worst |vᵀλ|/(5 L·F·h) if exact (world::Scales) [-], 1e-8 or more with A or B; in [1e-12, 1e-2]
  void validate() const;               ///< @throws InvalidInput naming the field
};

struct StepInput {
  VectorRef q;                               ///< configuration (n_q)
  VectorRef u;                               ///< commanded joint positions (n_a) [rad or m]
  const Eigen::VectorXd* tau_ext = nullptr;  ///< external generalised force (n_v) besides gravity [N, N·m]; may be null
  const Eigen::VectorXd* damping = nullptr;  ///< viscous force −damping·δq/h per coordinate (n_v), ≥ 0 [N·s/m, N·m·s/rad]; may be null
  const Eigen::VectorXd* friction = nullptr;  ///< factors of μ, besides friction_scale (pairs of the model), ≥ 0; may be null
};

/// One contact of a step with its impulse.
struct ContactImpulse {
  contact::Contact contact;                                ///< geometry at q, before the step
  Eigen::Vector3d lambda = Eigen::Vector3d::Zero();        ///< (n, t1, t2) acting on A [N·s]
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< J_c δq, of A relative to B in (n, t1, t2) [m]; 0 where out of reach
  double gap = 0;       ///< slack of the row: φ + J_n δq − μ‖J_t δq‖ ≥ 0 for a cone of Anitescu's [m]
  bool active = false;  ///< carries more than world::share::kActive of F of its pair

  double slide() const { return displacement.tail<2>().norm(); }
  /// Distance at which the force acts after the step, φ + J_n δq: μ·slide() at a sliding contact of Anitescu's law, his gap [m].
  double anitescu_gap() const { return contact.phi + displacement[0]; }
};

/// Force on A and its moment about the world origin (force; moment) in W [N, N·m]; on B the opposite. h: step [s].
Eigen::Matrix<double, 6, 1> calc_wrench(const ContactImpulse& contact, double h);

/// Derivatives of the contact impulses, 3 × n for each contact, rows (n, t1, t2) in the frame of the contact, which turns with q.
class ImpulseDerivatives {
 public:
  using Matrix = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
  using Block = Eigen::Map<Matrix>;
  using ConstBlock = Eigen::Map<const Matrix>;
  void resize(std::size_t contacts, Eigen::Index columns) {
    columns_ = columns;
    values_.resize(3 * contacts * static_cast<std::size_t>(columns));
  }
  std::size_t size() const { return columns_ == 0 ? 0 : values_.size() / (3 * static_cast<std::size_t>(columns_)); }
  Block operator[](std::size_t contact) { return {values_.data() + offset(contact), 3, columns_}; }
  ConstBlock operator[](std::size_t contact) const { return {values_.data() + offset(contact), 3, columns_}; }

 private:
  std::size_t offset(std::size_t contact) const { return 3 * contact * static_cast<std::size_t>(columns_); }
  std::vector<double> values_;
  Eigen::Index columns_ = 0;
};

struct StepResult {
  core::Status status = core::Status::NumericalFailure;
  Eigen::VectorXd q_next;  ///< (n_q); for a smoothed step this is c of (3.3)
  Eigen::VectorXd delta;   ///< δq (n_v)
  std::vector<ContactImpulse> contacts;
  Eigen::VectorXd torque;       ///< of the springs (n_a), clamp(K_a(u − q⁺)) at Model::effort with effort_limits [N·m, N]
  std::vector<char> saturated;  ///< per robot joint (n_a): its motor gives all it has; 0 without effort_limits
  /// Of hinges and sliders on their coordinates (n_vu), within world::Dof::friction (S.19), 0 of all others; empty in a scene without [N·m, N].
  Eigen::VectorXd joint_friction;
  Eigen::MatrixXd B;  ///< D_qnext_u (n_v × n_a) in tangent coordinates, when asked for
  /// D_qnext_q (n_v × n_v): from the tangent space at q to the one at q_next, when asked for. At a kink (a contact that starts to carry,
  /// to slide or to leave its feature) one of the one-sided derivatives, or one between them.
  Eigen::MatrixXd A;
  ImpulseDerivatives D_lambda_q;  ///< per contact, 3 × n_v [N·s/m, N·s/rad], when asked for
  ImpulseDerivatives D_lambda_u;  ///< per contact, 3 × n_a
  Eigen::VectorXd epsilon;        ///< regularisation used per object
  cone::Residuals residuals;
  int iterations = 0;
  int growths = 0;  ///< buffers that this call had to enlarge: 0 again once the workspace has seen as many contacts
};

/// Scratch, warm starts and kinematics; one per thread.
class StepWorkspace {
 public:
  explicit StepWorkspace(std::shared_ptr<const world::Model> model);
  ~StepWorkspace();
  StepWorkspace(StepWorkspace&&) noexcept;
  void forget();  ///< drops warm starts, so that the next step depends on its input alone
  const world::Model& model() const;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// One quasi-static step:  δq = argmin ½δqᵀQδq + bᵀδq  s.t.  J_c δq + φ e₁ ∈ K*_c,  Q = blkdiag(εM_u/h, hK_a),
/// b = −h (τ_u ; K_a(u − qᵃ) + τ_a); planar models and polyhedral cones use half-lines (2.10); joint limits are rows; damping D adds
/// D to Q; a hinge or slider with dry friction sticks until it is loaded with more than that (S.19), which the step takes away from it. With effort_limits K_a saturates: ½hK_a e² of e = u − qᵃ − δqᵃ goes on linearly where K_a|e| > effort (S.15), exact steps and
/// smoothed ones alike.
/// Analytic: the central path at σ = θ h/κ, θ = 2 per cone and 1 per half-line (2.27).
///
/// @returns Solved | MaxIterations | Infeasible | NumericalFailure; unless Solved, q_next = q and A = B = 0
/// @throws  InvalidInput: wrong size, q or u not finite, options out of range
core::Status step(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace& work, StepResult& out);

}  // namespace stiction::dynamics
