#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/execution/contact_control/control_run.hpp"
#include "stiction/execution/touch/touch_map.hpp"
#include "stiction/execution/touch/touch_scenario.hpp"

namespace stiction::execution {

struct TouchRunOptions {
  std::uint64_t seed = 0;                      ///< seed of torque noise, of the places of unknown bodies, and of random paths
  double settle = ControlRunOptions{}.settle;  ///< time after a contact begins from which its force is judged [s], ≥ 0
  core::RunControl control;
  void validate() const;
};

enum class TouchOutcome {
  Reached,
  NoRoute,         ///< there is no path to the goal; the arm holds its position
  TooManyTouches,  ///< max_touches is reached; the arm holds its position
  Missed           ///< the arm ended its path away from the goal, and feels nothing
};
std::string_view to_string(TouchOutcome outcome) noexcept;

/// A contact that was felt long enough to be reported.
struct Touch {
  double time = 0;  ///< when it was reported [s]
  int body = -1;    ///< touched link
  TouchedPlace place;
  double force = 0;      ///< mean of the force estimates [N]
  double radius = 0;     ///< radius ρ of its ball (G.2) [m]
  bool doubted = false;  ///< the arm has already been where the ball is; the ball has the least radius
  double error = 0;      ///< distance from the nearest simulated contact, only for evaluation [m]; infinite if there is none
};

/// A route and the time of its search.
struct PlannedRoute {
  double time = 0;  ///< time of the search in the run [s]
  Route route;
  double wall_s = 0;  ///< wall time of the search [s]
};

struct TouchRunResult {
  core::Status status = core::Status::NumericalFailure;
  TouchOutcome outcome = TouchOutcome::Missed;
  std::string reason;  ///< why the goal was not reached, or the message of the simulation
  std::vector<Touch> touches;
  std::vector<PlannedRoute> routes;  ///< the first route from before the motion, then one after each touch; the last may be NotFound
  double goal_error = 0;             ///< largest joint error at the end [rad, L of the robots]
  ControlRunResult run;              ///< samples and forces of the whole run
  std::shared_ptr<const world::Model> world;  ///< the simulated model
  std::shared_ptr<const world::Model> map;    ///< the arm's map at the end
};

/// Moves an arm to its goal among unknown obstacles. The arm plans a path in its map and follows it under the contact-aware controller. When it feels a
/// contact, from joint torques alone, it presses until the place is known, adds the place to its map (G.2), goes back the way it came, and plans again.
/// @returns Solved: the run has an outcome | NumericalFailure: the simulation stopped | Cancelled | MaxIterations (deadline)
/// @throws core::InvalidInput: options out of range, a start in contact
/// Tests: tests/execution/touch_test.cpp
[[nodiscard]] core::Status run_touch(const TouchScenario& scenario, const TouchRunOptions& options, TouchRunResult& out);

}  // namespace stiction::execution
