#pragma once

#include <cstdint>
#include <memory>
#include <numbers>
#include <string_view>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/core/status.hpp"
#include "stiction/planning/plan.hpp"

// Where the object of a plan may be when the plan is carried out without feedback and the world is not quite the model. docs/theory/tube.md

namespace stiction::execution {

/// Sets in which the errors of a model lie.
struct ErrorSets {
  double position = 2e-3;                     ///< of objects at the start [m], ≥ 0
  double angle = 2 * std::numbers::pi / 180;  ///< of objects at the start [rad], ≥ 0
  double friction = 0.3;                      ///< every μ is off by this share at most, all of them alike, in [0, 1)
  double mass = 0.3;                          ///< the same of the masses of all objects, in [0, 1)
  double contact = 0.005;                     ///< of the gap of a contact [L of the object of the goal], ≥ 0
  void validate() const;                      ///< @throws core::InvalidInput naming the field
};

/// One world in these sets.
struct WorldError {
  Eigen::VectorXd start;  ///< of the objects, in their tangent (n_vu) [m, rad]
  double friction = 1;    ///< factor of every μ
  double mass = 1;        ///< factor of every mass and inertia
};

/// A random world; friction, mass and the pose of each object are uniform in their sets. A free object under gravity rests on something: it is off across
/// gravity and about it alone. No object is off by more than the sets say, also where several hang on each other.
/// @param q            where the objects are known to be (n_q)
/// @param seed, index  the same worlds for the same seed, another one for each index
/// @throws core::InvalidInput: sets, q
WorldError draw_world(const world::Model& model, dynamics::VectorRef q, const ErrorSets& sets, std::uint64_t seed, std::uint64_t index);

/// By what a tube is wider than the bundle of scenarios that it is made of.
struct TubeFactors {
  double position = 1, angle = 1;  ///< > 0
};
/// Conformal quantiles of runs in MuJoCo, no less than 1 (docs/theory/tube.md), and the command that found them.
inline constexpr TubeFactors kTubeFactors{.position = 1.0, .angle = 1.0};
inline constexpr std::string_view kTubeFactorsMadeBy = "bench/tube.py --seeds 14 --runs 20 planar_pushing planar_hand iiwa_bimanual_planar";

/// Friction of the worlds of a bundle is off by this times its set: with inertia a contact slips before it does in a quasi-static step.
inline constexpr double kFrictionReserve = 1.25;

struct TubeOptions {
  ErrorSets errors{};
  TubeFactors factors = kTubeFactors;
  int scenarios = 16;  ///< worlds besides the known one, ≥ 1
  std::uint64_t seed = 0;
  int threads = 1;        ///< 0 = all cores; the result does not depend on it
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// The object of the goal at the end of a push or a regrasp.
struct TubeRest {
  planning::SegmentKind kind = planning::SegmentKind::Contact;
  int last_segment = 0;                  ///< of the plan, which ends here
  world::Pose centre;                    ///< mean of the bundle
  planning::GoalError offset;            ///< of the centre from where the plan has the object
  double position = 0;                   ///< radius: the object is within this of the centre [m] …
  double angle = 0;                      ///< … and turned by this at most [rad]; infinite where a scenario was lost
  std::vector<world::Pose> scenarios{};  ///< the bundle, the known world first; without those that were lost
};

struct TubeResult {
  core::Status status = core::Status::NumericalFailure;
  std::vector<TubeRest> rests;
  planning::GoalError goal;  ///< bound of the distance from the goal at the end
  /// Runs in the simulation stay inside as often as the factors promise: in planar scenes. In others they often do not (docs/theory/tube.md).
  bool calibrated = false;
  bool inside = false;  ///< the bound is within the tolerances of the goal, and calibrated
  int lost = 0;         ///< scenarios in which a step had no solution
  long steps = 0;
  double wall_s = 0;
};

/// Rolls worlds that were drawn from the sets out along the commands of a plan by exact steps, and bounds the object of the goal at every rest by the farthest of
/// them, times factors that were calibrated on runs of the second-order simulation.                                                  (B.1)–(B.5)
/// @returns Solved; MaxIterations (deadline), Cancelled: `out` has no rests
/// @throws  core::InvalidInput: options, a plan that does not fit the model or has no object
/// Tests: tests/execution/tube_test.cpp
[[nodiscard]] core::Status calc_tube(const std::shared_ptr<const world::Model>& model, const planning::Plan& plan,
                                     const TubeOptions& options, const core::RunControl& control, TubeResult& out);

}  // namespace stiction::execution
