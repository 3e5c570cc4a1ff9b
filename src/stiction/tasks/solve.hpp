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
  double friction = 1;  ///< every μ of the scene times this
  core::Status status = core::Status::NumericalFailure;
  bool reached = false;       ///< the goal, within its tolerances
  bool dropped = false;       ///< an object fell
  bool lost = false;          ///< the object left the plan behind, see SolveOptions::lost_factor
  double duration_s = 0;      ///< simulated
  planning::GoalError error;  ///< at the end of the run
};

/// What became of one seed.
struct SolveTry {
  std::uint64_t seed = 0;
  planning::PlanResult result;  ///< of the search, with the refined plan where there is one
  bool accepted = false;        ///< by check_plan
  std::vector<SolveRun> runs;   ///< the first alone where it misses the goal, else one per friction
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
  std::uint64_t seed = 0;              ///< of the first try; the next ones count up
  int tries = 20;                      ///< ≥ 1
  std::vector<double> friction = {1};  ///< the goal has to be reached with every μ times each of these, each ≥ 0, at least one
  /// Of the runs, and of the commands that are written: times the full timing (E.13), > 0; above 1 of pushes alone.
  double speed = execution::kOpenLoopSpeed;
  double lost_factor = 5;  ///< of the tolerances: an object that is farther from where the plan has it does not come back, > 0
  int threads = 0;         ///< 0 = all cores; the result does not depend on it
  /// Both are called from the threads of the run, one call at a time.
  std::function<void(std::uint64_t seed, SolveStage stage, const core::Progress& progress)> on_stage;
  std::function<void(const SolveTry& ended, bool best)> on_try;  ///< best: of those that have ended
  void validate() const;                                         ///< @throws core::InvalidInput naming the field
};

struct SolveResult {
  core::Status status = core::Status::NumericalFailure;
  SolveTry best;                ///< the first that holds, else the best one
  std::vector<SolveTry> tries;  ///< those that count, in the order of their seeds, without the trees of their searches
  double wall_s = 0;
};

/// Plans, refines, checks and simulates seeds side by side until one reaches its goal in the second-order simulation: the first in the order
/// of seeds that holds counts, whichever ended first. A search that says why it can find nothing ends the run; that is so for every seed.
///
/// @returns Solved: out.best holds; MaxIterations: none of the tries did, or the deadline came first; Cancelled
/// @throws  core::InvalidInput: options, or a task that planning::plan refuses
/// Source:  docs/theory/execution.md   Tests: tests/tasks/solve_test.cpp, tests/python/test_solve.py
[[nodiscard]] core::Status solve(const Task& task, const SolveOptions& options, const core::RunControl& control, SolveResult& out);

}  // namespace stiction::tasks
