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
  /// Factor on kappa for contacts among robot parts and fixed bodies. Such contacts bound the motion; they should not push.
  double self_sharpness = 10;
  double limit_sharpness = 10;  ///< factor on kappa for joint limits
};
using Smoothing = std::variant<Exact, Analytic>;

/// Friction cone of spatial models. Planar models have two rays, which is exact.
struct SecondOrderCone {};  ///< φ + J_n δq ≥ μ‖J_t δq‖
/// φ + J_n δq ≥ μ d_kᵀJ_t δq for rays d_k = (cos 2πk/n, sin 2πk/n) in (t1, t2). The force lies in the pyramid spanned by n + μ d_k,
/// which is inside the friction cone.
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

/// Friction law of a sliding contact.
enum class FrictionLaw {
  Anitescu,  ///< a sliding contact opens by μ‖J_t δq‖, the gap of the convex relaxation (2.3.4)
  /// A sliding contact stays closed: φ + J_n δq ≥ 0, by De Saxcé's fixed point (docs/theory/step.md, S.14). This law holds for exact steps
  /// of spatial models with second-order cones. If the fixed point is not found to within 0.003 L, the step uses Anitescu's law. Every step
  /// is solved cold, so that its result depends on its input alone.
  Coulomb
};

struct StepOptions {
  double h = 0.1;  ///< time step [s], > 0
  Smoothing smoothing = Exact{};
  Regularisation regularisation = ByRule{};
  FrictionCone friction_cone = SecondOrderCone{};
  FrictionLaw friction_law = FrictionLaw::Anitescu;  ///< for exact steps; smoothed steps and local models always use Anitescu
  double friction_scale = 1.0;                       ///< multiplies every μ, ≥ 0
  double contact_margin = 0.0;                       ///< added to the model's contact distance [m], ≥ 0
  bool with_B = false;                               ///< also compute D_qnext_u
  bool with_A = false;                               ///< also compute D_qnext_q
  bool with_force_derivatives = false;               ///< also compute D_lambda_q (with A) and D_lambda_u (with B); needs A or B
  bool joint_limits = true;
  bool effort_limits = false;  ///< limit joint torques to world::Model::effort (S.15); if off, the joint springs do not saturate
  /// For exact steps: list contacts of meshes and flat faces only if the step may reach them (S.22).
  bool contacts_within_reach = false;
  bool warm_start = true;
  /// Largest |vᵀλ|/(5 L·F·h) of an exact step (world::Scales) [-], in [1e-12, 1e-2]. With A or B, at least 1e-8 is used.
  double tol_complementarity = 1e-10;
  void validate() const;  ///< @throws InvalidInput naming the field
};

struct StepInput {
  VectorRef q;                               ///< configuration (n_q)
  VectorRef u;                               ///< commanded joint positions (n_a) [rad or m]
  const Eigen::VectorXd* tau_ext = nullptr;  ///< external generalised force (n_v) besides gravity [N, N·m]; may be null
  const Eigen::VectorXd* damping = nullptr;  ///< viscous force −damping·δq/h per coordinate (n_v), ≥ 0 [N·s/m, N·m·s/rad]; may be null
  const Eigen::VectorXd* friction = nullptr;  ///< factors on μ, on top of friction_scale (one per pair of the model), ≥ 0; may be null
};

/// One contact of a step with its impulse.
struct ContactImpulse {
  contact::Contact contact;                                ///< geometry at q, before the step
  Eigen::Vector3d lambda = Eigen::Vector3d::Zero();        ///< (n, t1, t2) acting on A [N·s]
  Eigen::Vector3d displacement = Eigen::Vector3d::Zero();  ///< J_c δq of A relative to B in (n, t1, t2) [m]; 0 if out of reach
  double gap = 0;       ///< slack of the row [m]; with Anitescu's cone φ + J_n δq − μ‖J_t δq‖ ≥ 0
  bool active = false;  ///< closed, and carries a force above world::share::kActive times F of its pair

  double slide() const { return displacement.tail<2>().norm(); }
  /// Distance across which the force acts after the step, φ + J_n δq [m]. It is μ·slide() at a sliding contact with Anitescu's law.
  double anitescu_gap() const { return contact.phi + displacement[0]; }
};

/// Force on A and its moment about the world origin (force; moment) in W [N, N·m]; on B the opposite. h: step [s].
Eigen::Matrix<double, 6, 1> calc_wrench(const ContactImpulse& contact, double h);

/// Derivatives of the contact impulses: one 3 × n matrix per contact, with rows (n, t1, t2) in the contact frame, which turns with q.
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
  Eigen::VectorXd torque;  ///< torques of the joint springs K_a(u − q⁺) (n_a), clamped at Model::effort with effort_limits [N·m, N]
  std::vector<char> saturated;  ///< per robot joint (n_a): true if its motor is at its effort limit; 0 without effort_limits
  /// Dry friction of hinges and sliders on their coordinates (n_vu) [N·m, N], within ±world::Dof::friction (S.19); 0 for all other
  /// coordinates. Empty in a scene without dry joint friction.
  Eigen::VectorXd joint_friction;
  Eigen::MatrixXd B;  ///< D_qnext_u (n_v × n_a) in tangent coordinates, when asked for
  /// D_qnext_q (n_v × n_v), from the tangent space at q to the tangent space at q_next, when asked for. At a kink (a contact starts to
  /// carry load, to slide or to leave its feature) A is one of the one-sided derivatives, or lies between them.
  Eigen::MatrixXd A;
  ImpulseDerivatives D_lambda_q;  ///< per contact, 3 × n_v [N·s/m, N·s/rad], when asked for
  ImpulseDerivatives D_lambda_u;  ///< per contact, 3 × n_a
  Eigen::VectorXd epsilon;        ///< regularisation used per object
  cone::Residuals residuals;
  int iterations = 0;
  int growths = 0;  ///< buffers that this call had to enlarge; 0 once the workspace has seen as many contacts before
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
/// b = −h (τ_u ; K_a(u − qᵃ) + τ_a).
///
/// Planar models and polyhedral cones use half-lines (2.10). Joint limits are rows. Damping D_v adds D_v to Q. A hinge or slider with dry
/// friction sticks until its load exceeds the friction, and the step subtracts the friction from the load (S.19). With effort_limits the
/// joint springs saturate: the energy ½hK_a e² of e = u − qᵃ − δqᵃ continues linearly beyond K_a|e| = effort (S.15), in exact and smoothed
/// steps. Analytic smoothing stops on the central path at σ = θ h/κ, with θ = 2 per cone and 1 per half-line (2.27).
///
/// If no motion ends all overlaps, those within the contact tolerance of their pair may stay, and only deeper ones make the step infeasible.
///
/// @returns Solved | MaxIterations | Infeasible | NumericalFailure; unless Solved, q_next = q and A = B = 0
/// @throws  InvalidInput: wrong size, q or u not finite, options out of range
core::Status step(const world::Model& model, const StepInput& in, const StepOptions& options, StepWorkspace& work, StepResult& out);

}  // namespace stiction::dynamics
