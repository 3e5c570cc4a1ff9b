#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/core/status.hpp"
#include "stiction/world/model.hpp"

// Second-order simulation of a scene, independent of the quasi-static model. What is modelled how: docs/theory/simulation.md.

namespace stiction::simulation {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// Contacts are stiff, critically damped springs, solved implicitly, with exact friction cones. The defaults belong together and to the default
/// timestep: docs/theory/simulation.md says what follows from each and what was measured.
struct ContactOptions {
  double time_constant = 2e-3;  ///< of the normal direction [s], at least 2 timesteps; 10 keep four points of a box from chattering
  double friction_time_constant = 2e-2;  ///< in which a slip below ~ μ a · this / 2 dies out [s]; the shorter, the more a sliding body hops
  double impedance = 0.95;               ///< [-] in (0, 0.9999]; 1 would be rigid
  double friction_stiffening = 100;      ///< of friction against the normal direction [-], ≥ 1; divides the creep of what should stick
  int noslip_iterations = 0;             ///< sweeps that remove the rest of the creep
  double friction_scale = 1.0;           ///< multiplies every μ and every moment about a normal, ≥ 0
  /// Objects on fixed geometry: both time constants times this, ≥ 1. At 1 a can that stands there rolls round its rim for ever.
  double ground_softness = 2.5;
  void validate(double timestep) const;
};

/// What is fixed when the simulated model is made.
struct PlantOptions {
  double timestep = 2e-4;      ///< [s]
  double damping_ratio = 1.0;  ///< of a joint spring with the inertia that its joint moves at the moment, ≥ 0
  /// Damping acts on u̇ − q̇, as in a joint impedance controller that is told velocities; false: on −q̇, so that joints lag behind their commands by D/K of the
  /// speed, each by its own.
  bool velocity_reference = false;
  bool effort_limits =
      false;  ///< motors give world::Model::effort at most, K_a(u − q) + D(u̇ − q̇) is cut off there; false: whatever that is
  bool joint_friction =
      false;  ///< robot joints have world::Dof::friction and damping, as their files state them; false: their servos overcome it. Objects always do
  double armature = 0.0;  ///< inertia of every motor as its joint sees it [kg or kg m²], ≥ 0
  double spring_resolution =
      1;  ///< armature is raised to K_a (timestep / this)²: then no joint spring turns faster than this per step [rad]
  /// Objects on a planar joint, a hinge or a slider rest on something that is not in the scene, which brings them to rest in this time:
  /// their joints are damped with M_ii / this [s], > 0. Infinite: not at all.
  double rest_time = std::numeric_limits<double>::infinity();
  double mass_scale = 1.0;  ///< mass and inertia of every object times this, > 0; Plant::model() stays as it is known
  ContactOptions contact;
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// A scene as MuJoCo simulates it, immutable and shared by threads. Made of the same Model: kinematics, shapes, inertias, pairs, limits.
class Plant {
 public:
  /// @throws core::InvalidInput: options out of range, or what MuJoCo says against the scene
  static std::shared_ptr<const Plant> make(std::shared_ptr<const world::Model> model, const PlantOptions& options = {});
  ~Plant();
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  const world::Model& model() const;
  const PlantOptions& options() const;
  const Eigen::VectorXd& damping() const;   ///< of the joint springs at neutral() (n_a) [N s/m or N m s/rad]
  const Eigen::VectorXd& armature() const;  ///< (n_a) [kg or kg m²]

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  explicit Plant(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Commands u(t) are piecewise linear through the knots, constant after the last one.
struct SimulationInput {
  VectorRef q0;                         ///< (n_q)
  VectorRef times;                      ///< of the knots, increasing, the first one 0 [s]; the last one is where the simulation ends
  Eigen::Ref<const Eigen::MatrixXd> u;  ///< (n_a × knots) commanded joint positions [rad or m]
  const Eigen::VectorXd* v0 = nullptr;  ///< (n_v) starting velocity in tangent coordinates; null = at rest
};

struct SimulationOptions {
  double record_interval = 0.01;  ///< of the samples in the result [s], rounded to timesteps; > 0
  const core::RunControl* control = nullptr;
  std::function<bool(double t, VectorRef q)>
      stop;  ///< asked at every sample; the run ends, Solved, with the first one for which it says yes
  void validate() const;
};

/// Force of one pair, its contact points together.
struct PairForce {
  int pair = -1;                                         ///< index into Model::pairs()
  double normal = 0;                                     ///< sum over the points [N], ≥ 0
  double tangential = 0;                                 ///< length of the sum of the friction forces [N]
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();     ///< sum, acting on A [N]
  Eigen::Vector3d friction_W = Eigen::Vector3d::Zero();  ///< its part across the normals [N]
  Eigen::Vector3d p_WC = Eigen::Vector3d::Zero();        ///< mean of the points, weighted by their normal forces [m]
  double depth = 0;                                      ///< deepest penetration of the points [m], ≥ 0
};

struct SimulationResult {
  core::Status status = core::Status::NumericalFailure;
  std::string message;                         ///< what MuJoCo said, where it is not Solved
  std::vector<double> times;                   ///< of the samples [s], the first 0, the last the end
  Eigen::MatrixXd q;                           ///< (n_q × samples), as in Model
  Eigen::MatrixXd v;                           ///< (n_v × samples)
  std::vector<std::vector<PairForce>> forces;  ///< per sample, by pair index; only pairs that touch
  Eigen::MatrixXd torque;                      ///< (n_a × samples) of the motors, of each the largest since the sample before [N m or N]
  double max_depth = 0;                        ///< deepest penetration over all steps [m], ≥ 0
  long steps = 0;
  double wall_s = 0;
};

/// State of a run; belongs to one thread and one Plant. Nothing of an earlier run is left in it: equal inputs give equal bits.
class Workspace {
 public:
  explicit Workspace(std::shared_ptr<const Plant> plant);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Simulates the commands from q0 to the last knot, in whole timesteps.
///
/// M(q) v̇ + c(q, v) = τ_gravity (objects only) + K_a (u(t) − qᵃ) − D(q) v + Σ J_cᵀ f_c ,  f_c in its friction cone.
///
/// @returns Solved; NumericalFailure: MuJoCo warned (numbers out of range, contacts that did not fit), `out.message` says what;
///          Cancelled, MaxIterations (deadline). What was recorded until then stays in `out`.
/// @throws  core::InvalidInput: sizes, q0 or knots that are not finite, times that do not increase, a workspace of another plant
/// Tests: tests/simulation
core::Status simulate(const Plant& plant, const SimulationInput& input, const SimulationOptions& options, Workspace& work,
                      SimulationResult& out);

}  // namespace stiction::simulation
