#pragma once

#include <cstdint>
#include <memory>
#include <numbers>
#include <string_view>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/core/status.hpp"
#include "stiction/planning/plan.hpp"

// Bounds of the object's pose when a plan is carried out without feedback in a world that differs from the model. docs/theory/tube.md

namespace stiction::execution {

/// Bounds of the errors of a model.
struct ErrorSets {
  double position = 2e-3;                     ///< error of object positions at the start [m], ≥ 0
  double angle = 2 * std::numbers::pi / 180;  ///< error of object orientations at the start [rad], ≥ 0
  double friction = 0.3;                      ///< largest relative error of every μ, the same for all, in [0, 1)
  double mass = 0.3;                          ///< largest relative error of the masses of all objects, the same for all, in [0, 1)
  double contact = 0.005;                     ///< error of the gap of a contact [L of the object of the goal], ≥ 0
  void validate() const;                      ///< @throws core::InvalidInput naming the field
};

/// One world with errors within these bounds.
struct WorldError {
  Eigen::VectorXd start;  ///< displacement of the objects at the start, in their tangent (n_vu) [m, rad]
  double friction = 1;    ///< factor of every μ
  double mass = 1;        ///< factor of every mass and inertia
};

/// Draws a random world: friction, mass and the pose of each object are uniform in their sets. A free object under gravity rests on something, so its error
/// is a horizontal displacement and a rotation about the vertical. No object is off by more than the sets allow, even if several hang on each other.
/// @param q            configuration with the known poses of the objects (n_q)
/// @param seed, index  the same seed gives the same worlds, each index another one
/// @throws core::InvalidInput: invalid sets or q
WorldError draw_world(const world::Model& model, dynamics::VectorRef q, const ErrorSets& sets, std::uint64_t seed, std::uint64_t index);

/// Factors by which a tube is wider than its bundle of scenarios.
struct TubeFactors {
  double position = 1, angle = 1;  ///< > 0
};
/// Conformal quantiles of runs in MuJoCo, at least 1 (docs/theory/tube.md), and the command that determined them.
inline constexpr TubeFactors kTubeFactors{.position = 1.0, .angle = 1.0};
inline constexpr std::string_view kTubeFactorsMadeBy = "bench/tube.py --seeds 14 --runs 20 planar_pushing planar_hand iiwa_bimanual_planar";

/// The friction error of the worlds in a bundle is this factor times its set: with inertia a contact slips earlier than in a quasi-static step.
inline constexpr double kFrictionReserve = 1.25;

struct TubeOptions {
  ErrorSets errors{};
  TubeFactors factors = kTubeFactors;
  int scenarios = 16;  ///< number of worlds besides the known one, ≥ 1
  std::uint64_t seed = 0;
  int threads = 1;        ///< 0 = all cores; the result does not depend on it
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// The object of the goal at the end of a push or a regrasp.
struct TubeRest {
  planning::SegmentKind kind = planning::SegmentKind::Contact;
  int last_segment = 0;                  ///< segment of the plan that ends here
  world::Pose centre;                    ///< mean of the bundle
  planning::GoalError offset;            ///< distance of the centre from the planned pose
  double position = 0;                   ///< radius of the tube: largest distance of the object from the centre [m]
  double angle = 0;                      ///< largest rotation from the centre [rad]; both are infinite if a scenario was lost
  std::vector<world::Pose> scenarios{};  ///< poses of the bundle, the known world first, without lost scenarios
};

struct TubeResult {
  core::Status status = core::Status::NumericalFailure;
  std::vector<TubeRest> rests;
  planning::GoalError goal;  ///< bound of the distance from the goal at the end
  /// Simulated runs stay inside as often as the factors promise. True for planar scenes; in other scenes they often do not (docs/theory/tube.md).
  bool calibrated = false;
  bool inside = false;  ///< the bound is calibrated and within the tolerances of the goal
  int lost = 0;         ///< number of scenarios in which a step had no solution
  long steps = 0;
  double wall_s = 0;
};

/// Computes the tube of a plan: rolls out worlds drawn from the sets along the commands of the plan by exact steps. At every rest, the object is bounded by the
/// farthest world, times factors that were calibrated on runs of the second-order simulation.                                         (B.1)–(B.5)
/// @returns Solved; MaxIterations (deadline), Cancelled: `out` has no rests
/// @throws  core::InvalidInput: invalid options, or a plan that does not fit the model or has no object
/// Tests: tests/execution/tube_test.cpp
[[nodiscard]] core::Status calc_tube(const std::shared_ptr<const world::Model>& model, const planning::Plan& plan,
                                     const TubeOptions& options, const core::RunControl& control, TubeResult& out);

}  // namespace stiction::execution
