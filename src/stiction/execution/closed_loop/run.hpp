#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/execution/closed_loop/driver.hpp"
#include "stiction/execution/open_loop/run_speed.hpp"
#include "stiction/planning/planner.hpp"

// Closed-loop execution: a plan is carried out, watched, and planned anew from where things are. docs/theory/execution.md

namespace stiction::execution {

enum class RunState {
  Hold,     ///< commands rest: something settles, or the goal has to hold
  Push,     ///< the robot pushes
  Regrasp,  ///< the robot moves to new contacts
  Replan,   ///< commands rest while the planner works
};

enum class RunEnd {
  Reached,    ///< the goal held
  Dropped,    ///< an object fell
  NoPlan,     ///< the planner found none, or refused the start
  Replans,    ///< used up
  TimeUp,     ///< RunOptions::duration
  Deadline,   ///< of the RunControl
  Cancelled,  ///< by the RunControl
  Silent,     ///< the plant does not answer any more, or its objects are not seen any more
  Unfelt,     ///< guarded moves before it did not end as they should (tasks/touch_first.hpp): run() itself never ends so
};
std::string_view to_string(RunState state);
std::string_view to_string(RunEnd end);

/// What is seen and decided at one moment.
struct RunSample {
  double time = 0;  ///< since the start of the run [s]
  RunState state = RunState::Hold;
  const Eigen::VectorXd& q;       ///< measured (n_q)
  const Eigen::VectorXd& q_plan;  ///< as planned for this moment (n_q); where nothing is planned as measured
  const Eigen::VectorXd& u;       ///< commands (n_a)
  int piece = -1;                 ///< index into RunResult::pieces; −1: before the first
  int plans = 0;                  ///< so far
  double goal_share = 0;          ///< how far the object is from the goal, in its tolerances
  int goal = 0;                   ///< which one of those in a row
};

struct RunOptions {
  double tick = 1e-3;            ///< between two commands [s], > 0
  double watch_interval = 0.02;  ///< between two looks at the objects, in whole ticks [s], ≥ tick
  double off_on_the_way = 2;     ///< a piece is given up where the object is this many tolerances of the goal off its planned path, > 0 …
  double off_at_the_end = 1;     ///< … or this many off its end once it rests there, > 0
  double settle_time = 0.1;      ///< of looks that have to show no motion [s], > 0; longer where objects trail their plan (E.14)
  double hold =
      1;  ///< the goal counts once the object was within its tolerances for so long [s], ≥ 0; 0: as soon as it is seen there, on its way as well
  double plan_fraction = 0.5;  ///< plans go to this share of the tolerances of the goal: the rest is left to execution, in (0, 1]
  double friction = 0.7;       ///< every μ of the plans times this, in (0, 1]: what slips in the world then slips in the plan as well
  double plan_timeout = 20;    ///< for one plan [s], > 0
  /// … or this much time of all cores of the process [s], > 0, which other work on the machine does not shorten; nothing: plan_timeout alone.
  std::optional<double> plan_processor_time;
  /// Seconds of one core that the planner works within a second of the plant's clock, which goes on meanwhile, ≥ 0; 0: it stands still.   (E.20)
  double planning_rate = 1;
  /// Each step that the planner computes is charged like this [s], > 0, so that a run is the same on every machine; nothing: the processor time that it took.
  std::optional<double> plan_step_time;
  bool join = true;  ///< before the planner searches, the plan before is gone on with, where that leads to the goal
  /// The fingers of a hand keep a free object where it is, while nothing is carried out (E.21); false: commands rest. Off, since cubes are not reached more
  /// often with it, and later where poses are noisy (docs/lab/caught.md).
  bool active_hold = false;
  /// An object that would roll out of an open hand is turned to a goal that is near in place by its fingers, one of which at a time goes back (E.23), and planned
  /// for where that does not lead there; false: every object is planned for.
  bool finger_gait = true;
  int refusals = 5;                                        ///< plans in a row that may fail before the run ends, ≥ 1
  int replans = 60;                                        ///< plans after the first one of a goal, whatever calls for them, ≥ 0
  double duration = 600;                                   ///< of the run, by the clock of the plant [s], > 0
  double silence = 0.5;                                    ///< objects that were not seen for so long are away: the robot holds [s], > 0
  double absence = 30;                                     ///< … and the run ends after so long [s], ≥ silence
  std::optional<RunSpeeds> speed;                          ///< nothing: calc_run_speeds of the object of the goal, with …
  double speed_factor = 1;                                 ///< … this factor, > 0
  std::function<void(const RunSample& sample)> on_sample;  ///< at every look, from the thread of the run
  void validate() const;                                   ///< @throws core::InvalidInput naming the field
};

/// What was carried out of a piece of a plan.
struct RunPiece {
  planning::SegmentKind kind = planning::SegmentKind::Contact;
  int plan = 0;                   ///< number of its plan; −1: that which was given, or none was needed yet
  double begin_s = 0, end_s = 0;  ///< since the start of the run
  double off = 0;                 ///< how far the object was off its planned path at the end, in tolerances of the goal
  bool given_up = false;          ///< it was too far off
};

/// One call of the planner.
struct RunPlan {
  double time = 0;         ///< of the run, when it was asked [s]
  double wall_s = 0;       ///< that it took
  double processor_s = 0;  ///< … of all cores of the process
  double clock_s = 0;      ///< … and of the clock of the plant
  core::Status status = core::Status::NumericalFailure;
  std::string cause;    ///< why it was asked
  std::string reason;   ///< what the planner said, where it found nothing
  bool joined = false;  ///< the plan before was gone on with, and nothing was searched
};

/// One goal of a run.
struct RunGoal {
  bool reached = false;
  double begin_s = 0;         ///< since the start of the run, when it was the next one to be reached
  double end_s = 0;           ///< … when it had been held for as long as asked, or the run ended
  int replans = 0;            ///< plans after the first one for it
  planning::GoalError error;  ///< at its end, as measured
};

struct RunResult {
  core::Status status = core::Status::NumericalFailure;
  RunEnd end = RunEnd::Silent;
  std::string message;        ///< why the run ended, where it was not Reached
  planning::GoalError error;  ///< of the object at the end, as measured
  double duration_s = 0;      ///< of the clock of the plant
  double planning_s = 0;      ///< wall time of all plans
  double wall_s = 0;
  std::vector<RunPlan> plans;
  int replans = 0;  ///< of them, those after the first of a goal; a plan that is asked for again because it was refused counts once
  std::vector<RunPiece> pieces;
  std::vector<RunGoal> goals;                      ///< those that were begun
  std::optional<int> dropped;                      ///< object that fell
  std::optional<planning::PlanResult> first_plan;  ///< of the planner
  std::vector<double> times;                       ///< of the looks
  Eigen::MatrixXd q, q_plan;                       ///< (n_q × looks) measured, planned
  Eigen::MatrixXd u;                               ///< (n_a × looks)
  std::vector<int> piece;                          ///< per look, −1 before the first

  bool reached() const { return end == RunEnd::Reached; }  ///< all goals
  long goals_reached() const;
  long count(planning::SegmentKind kind) const;  ///< pieces carried out
};

/// Brings the object of the goal there: plans from where things are, carries the pieces out at real speed, and plans anew where the object leaves its path,
/// misses the end of a piece or of the plan. Commands are those of the plan, ahead of the joints by no more than the motors can pull (E.15).
/// The robot holds its last command while the planner works and when the run ends, whatever ended it.
///
/// @param problem  the model, the goal; where things are at the start is read from the plant
/// @param options  of the planner; its seed is that of the first plan, later ones follow from it
/// @param first    a plan to begin with, where it starts from what is measured; null: none
/// @returns Solved: Reached; Cancelled; NumericalFailure: Silent; MaxIterations: anything else. `out` holds what was done
/// @throws  core::InvalidInput: options, problem, a plan that does not fit the model
/// Tests: tests/execution/run_test.cpp, tests/python/test_run.py
[[nodiscard]] core::Status run(Driver& plant, const planning::PlanningProblem& problem, const planning::PlannerOptions& options,
                               const RunOptions& how, const core::RunControl& control, RunResult& out,
                               const planning::Plan* first = nullptr);

/// … to goals in a row: each once the one before was held. The plant, its clock and all budgets but RunOptions::replans go on from one to the next, and a goal
/// that is not reached ends the run. In RunResult::error and at the end of a run that stops early the goal is the one that it was on its way to.
/// @param goals  of the same model, at least one; their q_start are not looked at
/// @param first  a plan to the first of them
[[nodiscard]] core::Status run(Driver& plant, std::span<const planning::PlanningProblem> goals, const planning::PlannerOptions& options,
                               const RunOptions& how, const core::RunControl& control, RunResult& out,
                               const planning::Plan* first = nullptr);

}  // namespace stiction::execution
