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
  std::uint64_t seed = 0;                      ///< of torque noise, of where the unknown is, of random paths
  double settle = ControlRunOptions{}.settle;  ///< forces are judged from this long after a contact is made [s], ≥ 0
  core::RunControl control;
  void validate() const;
};

enum class TouchOutcome {
  Reached,
  NoRoute,         ///< the arm holds where it is
  TooManyTouches,  ///< the same
  Missed           ///< at the end of its path the arm is not at the goal, and feels nothing
};
std::string_view to_string(TouchOutcome outcome) noexcept;

/// A contact that was felt long enough to be told of.
struct Touch {
  double time = 0;  ///< when it was told [s]
  int body = -1;    ///< link
  TouchedPlace place;
  double force = 0;      ///< mean of the estimates [N]
  double radius = 0;     ///< ρ of its ball (G.2) [m]
  bool doubted = false;  ///< the arm has been where the ball is: it got the least radius all the same
  double error = 0;      ///< distance from the nearest contact of the simulation, for judging alone [m]; infinite where there is none
};

/// A route and when it was found.
struct PlannedRoute {
  double time = 0;  ///< [s]
  Route route;
  double wall_s = 0;  ///< that the search took
};

struct TouchRunResult {
  core::Status status = core::Status::NumericalFailure;
  TouchOutcome outcome = TouchOutcome::Missed;
  std::string reason;  ///< why the goal was not reached, or what the simulation said
  std::vector<Touch> touches;
  std::vector<PlannedRoute> routes;           ///< the first before the first motion, then one after each touch; the last one may be none
  double goal_error = 0;                      ///< of the largest joint at the end [rad, L of the robots]
  ControlRunResult run;                       ///< samples and forces of the whole run
  std::shared_ptr<const world::Model> world;  ///< what was simulated
  std::shared_ptr<const world::Model> map;    ///< what the arm knows at the end
};

/// The arm plans a path to its goal with what it knows and follows it under the contact-aware controller. Where it feels a contact, from joint torques alone, it
/// presses until it knows the place, takes it into its map (G.2), goes back the way it came, plans anew and goes on.
/// @returns Solved: the run came to its outcome | NumericalFailure: the simulation stopped | Cancelled | MaxIterations (deadline)
/// @throws core::InvalidInput: options out of range, a start in contact
/// Tests: tests/execution/touch_test.cpp
[[nodiscard]] core::Status run_touch(const TouchScenario& scenario, const TouchRunOptions& options, TouchRunResult& out);

}  // namespace stiction::execution
