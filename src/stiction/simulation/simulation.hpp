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

// Second-order simulation of a scene, independent of the quasi-static model. docs/theory/simulation.md describes the models.

namespace stiction::simulation {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// Contacts are stiff, critically damped springs, solved implicitly, with exact friction cones. The defaults are tuned together for the
/// default timestep; docs/theory/simulation.md states the effect of each and the measurements.
struct ContactOptions {
  double time_constant = 2e-3;  ///< of the normal direction [s], at least 2 timesteps; with 10 a box on four points does not chatter
  double friction_time_constant = 2e-2;  ///< in which a slip below ~ μ a · this / 2 dies out [s]; if short, sliding bodies hop
  double impedance = 0.95;               ///< [-] in (0, 0.9999]; 1 would be rigid
  double friction_stiffening = 100;      ///< stiffness relative to the normal direction [-], ≥ 1; divides the creep of sticking contacts
  int noslip_iterations = 0;             ///< solver sweeps that remove the remaining creep
  double friction_scale = 1.0;           ///< factor on every μ and every friction moment about a normal, ≥ 0
  /// Factor on both time constants for objects on fixed geometry, ≥ 1. At 1, a standing can rolls around its rim for ever.
  double ground_softness = 2.5;
  void validate(double timestep) const;
};

/// Options of Plant::make(), fixed once the plant is made.
struct PlantOptions {
  double timestep = 2e-4;      ///< [s]
  double damping_ratio = 1.0;  ///< ζ of the joint springs with the inertia that the joint moves in the present posture [-], ≥ 0
  /// True: damping acts on u̇ − q̇, as in a joint impedance controller with velocity commands. False: damping acts on −q̇, so each joint
  /// lags behind its command by D/K times the speed.
  bool velocity_reference = false;
  bool effort_limits = false;  ///< true: the motor torque K_a(u − q) + D(u̇ − q̇) saturates at world::Model::effort; false: it is unbounded
  bool joint_friction =
      false;  ///< true: robot joints have the friction and damping of world::Dof; false: the damping, which servos overcome (M.5). DrivenPlant: none
  double armature = 0.0;  ///< least inertia of every motor, reflected to its joint [kg or kg m²], ≥ 0; world::JointMotor may state more
  double spring_resolution =
      1;  ///< largest phase of a joint spring per timestep [rad]: armature is raised to at least K_a (timestep / this)²
  /// Time in which objects on a planar joint, a hinge or a slider come to rest [s], > 0: their support is not part of the scene, so their
  /// joints are damped with M_ii / this. Infinite: no damping.
  double rest_time = std::numeric_limits<double>::infinity();
  double mass_scale = 1.0;  ///< factor on mass and inertia of every object, > 0; Plant::model() keeps the nominal values
  ContactOptions contact;
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// The MuJoCo model of a scene, immutable and shared by threads. Kinematics, shapes, inertias, pairs and limits come from the world::Model.
class Plant {
 public:
  /// @throws core::InvalidInput: options out of range, or MuJoCo refuses the scene (with its message)
  static std::shared_ptr<const Plant> make(std::shared_ptr<const world::Model> model, const PlantOptions& options = {});
  ~Plant();
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  const world::Model& model() const;
  const PlantOptions& options() const;
  const Eigen::VectorXd& damping() const;   ///< damping of the joint springs at neutral() (n_a) [N s/m or N m s/rad]
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
  VectorRef times;                      ///< times of the knots, increasing from 0 [s]; the simulation ends at the last one
  Eigen::Ref<const Eigen::MatrixXd> u;  ///< (n_a × knots) commanded joint positions [rad or m]
  const Eigen::VectorXd* v0 = nullptr;  ///< (n_v) starting velocity in tangent coordinates; null = at rest
};

struct SimulationOptions {
  double record_interval = 0.01;  ///< time between samples of the result [s], rounded to timesteps; > 0
  const core::RunControl* control = nullptr;
  std::function<bool(double t, VectorRef q)>
      stop;  ///< called at every sample; the run ends with status Solved at the first sample for which it returns true
  void validate() const;
};

/// Contact force of one pair, summed over its contact points.
struct PairForce {
  int pair = -1;                                         ///< index into Model::pairs()
  double normal = 0;                                     ///< sum of the normal forces [N], ≥ 0
  double tangential = 0;                                 ///< length of the sum of the friction forces [N]
  Eigen::Vector3d force_W = Eigen::Vector3d::Zero();     ///< total force on A [N]
  Eigen::Vector3d friction_W = Eigen::Vector3d::Zero();  ///< friction part of force_W [N]
  Eigen::Vector3d p_WC = Eigen::Vector3d::Zero();        ///< mean contact point, weighted by normal force [m]
  double depth = 0;                                      ///< deepest penetration [m], ≥ 0
};

struct SimulationResult {
  core::Status status = core::Status::NumericalFailure;
  std::string message;                         ///< message of MuJoCo if not Solved
  std::vector<double> times;                   ///< times of the samples [s], from 0 to the end
  Eigen::MatrixXd q;                           ///< (n_q × samples), as in Model
  Eigen::MatrixXd v;                           ///< (n_v × samples)
  std::vector<std::vector<PairForce>> forces;  ///< per sample, by pair index; only pairs that touch
  Eigen::MatrixXd torque;                      ///< (n_a × samples) largest torque of each motor since the last sample [N m or N]
  double max_depth = 0;                        ///< deepest penetration over all steps [m], ≥ 0
  long steps = 0;
  double wall_s = 0;
};

/// Scratch of simulate(); belongs to one thread and one Plant. A run does not depend on earlier runs: equal inputs give bitwise equal
/// results.
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
/// @returns Solved; NumericalFailure: MuJoCo warned (numbers out of range, too many contacts), `out.message` has the warning;
///          Cancelled, MaxIterations (deadline). Samples recorded until then stay in `out`.
/// @throws  core::InvalidInput: sizes, q0 or knots that are not finite, times that do not increase, a workspace of another plant
/// Tests: tests/simulation
core::Status simulate(const Plant& plant, const SimulationInput& input, const SimulationOptions& options, Workspace& work,
                      SimulationResult& out);

}  // namespace stiction::simulation
