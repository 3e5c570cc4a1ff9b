#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/execution/open_loop/run_speed.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::tasks {

/// One run of a plan in the second-order simulation.
struct SolveRun {
  double friction = 1;  ///< factor on every μ of the scene
  core::Status status = core::Status::NumericalFailure;
  bool reached = false;       ///< the goal was reached within its tolerances
  bool dropped = false;       ///< an object fell
  bool lost = false;          ///< the object deviated too far from the plan, see SolveOptions::lost_factor
  double duration_s = 0;      ///< simulated time [s]
  planning::GoalError error;  ///< distance to the goal at the end of the run
};

/// Result of one seed.
struct SolveTry {
  std::uint64_t seed = 0;
  planning::PlanResult result;  ///< result of the search, with the refined plan if there is one
  bool accepted = false;        ///< check_plan accepted the plan
  std::vector<SolveRun> runs;   ///< one run per friction factor; only the first if it misses the goal
  double plan_s = 0, refine_s = 0, simulate_s = 0;

  bool solved() const { return result.status == core::Status::Solved; }
  long reached() const;
  bool holds() const { return !runs.empty() && reached() == std::ssize(runs); }
  bool better_than(const SolveTry& other) const;  ///< solved, accepted, reached the goal more often, has the smaller seed: in this order
};

enum class SolveStage {
  Plan,
  Refine,
  Simulate
};

struct SolveOptions {
  std::uint64_t seed = 0;              ///< seed of the first try; later tries count up from it
  int tries = 20;                      ///< largest number of seeds, ≥ 1
  std::vector<double> friction = {1};  ///< factors on every μ, ≥ 0, at least one; the goal must be reached with each factor
  /// Speed of the runs and of the written commands, as a factor on the full speed (E.13), > 0; values above 1 apply to pushes alone.
  double speed = execution::kOpenLoopSpeed;
  double lost_factor = 5;  ///< deviation from the plan, in goal tolerances, beyond which the object counts as lost, > 0
  int threads = 0;         ///< 0 = all cores; the result does not depend on it
  /// Callbacks, called from the threads of the run, one call at a time.
  std::function<void(std::uint64_t seed, SolveStage stage, const core::Progress& progress)> on_stage;
  std::function<void(const SolveTry& ended, bool best)> on_try;  ///< best: it is the best of the tries that have ended
  void validate() const;                                         ///< @throws core::InvalidInput naming the field
};

struct SolveResult {
  core::Status status = core::Status::NumericalFailure;
  SolveTry best;                ///< the first try that holds, otherwise the best one
  std::vector<SolveTry> tries;  ///< tries that count, in the order of their seeds, without their search trees
  double wall_s = 0;
};

/// Plans, refines, checks and simulates several seeds in parallel until one plan reaches its goal in the second-order simulation. The plan
/// that holds with the smallest seed counts, whichever ended first. A search that gives a reason why it cannot find a plan ends the run,
/// because the reason is the same for every seed.
///
/// @returns Solved: out.best holds; MaxIterations: no try holds, or the deadline came first; Cancelled
/// @throws  core::InvalidInput: invalid options, or a task that planning::plan refuses
/// Source:  docs/theory/execution.md   Tests: tests/tasks/solve_test.cpp, tests/python/test_solve.py
[[nodiscard]] core::Status solve(const Task& task, const SolveOptions& options, const core::RunControl& control, SolveResult& out);

}  // namespace stiction::tasks
