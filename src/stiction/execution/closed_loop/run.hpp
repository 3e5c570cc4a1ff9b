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

// Closed-loop execution: carries out a plan, watches the objects, and plans again from the measured state. docs/theory/running.md

namespace stiction::execution {

enum class RunState {
  Hold,     ///< commands rest until the objects rest, or while the goal has to hold
  Push,     ///< the robot pushes
  Regrasp,  ///< the robot moves to new contacts
  Replan,   ///< commands rest while the planner works
};

enum class RunEnd {
  Reached,    ///< the goal held
  Dropped,    ///< an object fell
  NoPlan,     ///< the planner found no plan, or refused the start
  Replans,    ///< RunOptions::replans is used up
  TimeUp,     ///< RunOptions::duration is over
  Deadline,   ///< the deadline of the RunControl passed
  Cancelled,  ///< the RunControl cancelled the run
  Silent,     ///< the plant no longer answers, or its objects are no longer seen
  Unfelt,     ///< guarded moves before the run failed (tasks/touch_first.hpp); run() itself never returns this
};
std::string_view to_string(RunState state);
std::string_view to_string(RunEnd end);

/// Measured and planned state of a run at one look at the objects.
struct RunSample {
  double time = 0;  ///< since the start of the run [s]
  RunState state = RunState::Hold;
  const Eigen::VectorXd& q;       ///< measured (n_q)
  const Eigen::VectorXd& q_plan;  ///< planned configuration at this moment (n_q); equals q while no plan is carried out
  const Eigen::VectorXd& u;       ///< commands in force (n_a)
  int piece = -1;                 ///< index into RunResult::pieces; −1: before the first
  int plans = 0;                  ///< number of plans so far
  double goal_share = 0;          ///< distance of the object from the goal [tolerances of the goal]
  int goal = 0;                   ///< index of the current goal, for several goals in a row
};

struct RunOptions {
  double tick = 1e-3;            ///< time between two commands [s], > 0
  double watch_interval = 0.02;  ///< time between two looks at the objects, rounded to whole ticks [s], ≥ tick
  double off_on_the_way = 2;     ///< a piece ends early if the object is farther off its path [tolerances of pushes, share_off()], > 0 (E.16)
  double off_at_the_end = 1;     ///< the same at the end of a piece, once the object rests there [tolerances of pushes], > 0 (E.16)
  double settle_time = 0.1;      ///< length of the window of looks in which nothing may move [s], > 0; T_f is added (E.14)
  double hold = 1;  ///< how long the object must stay within the goal's tolerances [s], ≥ 0; 0: one look suffices, even on the way
  double plan_fraction = 0.5;  ///< the planner aims at this share of the goal's tolerances, in (0, 1]; the rest is left to execution errors
  double friction = 0.7;  ///< factor of every μ in the plans, in (0, 1]: below 1, an object that slips in the world also slips in the plan
  double plan_timeout = 20;  ///< wall time for one plan [s], > 0
  /// Processor time for one plan, over all cores of the process [s], > 0. Unlike plan_timeout it does not depend on other work on the machine. Empty:
  /// only plan_timeout applies.
  std::optional<double> plan_processor_time;
  /// Planning rate: processor seconds of the planner per second of the plant's clock, which goes on meanwhile, ≥ 0; 0: the clock stands still.   (E.20)
  double planning_rate = 1;
  /// Time charged for each step that the planner computes [s], > 0; makes a run the same on every machine. Empty: the processor time is charged.
  std::optional<double> plan_step_time;
  bool join = true;  ///< before a search, try to go on with the current plan (join_plan)
  /// While the run carries out no plan, the fingers of a hand keep a free object in place (E.21); false: commands rest. Off by default: it does not raise the
  /// success rate of the cube tasks, and runs take longer where poses are noisy (docs/lab/caught.md).
  bool active_hold = false;
  /// If the goal is near, the fingers turn an object that would roll out of an open hand in place and go back one at a time (E.23). The planner is asked only
  /// if that fails. False: the planner is asked for every object.
  bool finger_gait = true;
  int refusals = 5;                ///< number of plans in a row that may fail before the run ends, ≥ 1
  int replans = 60;                ///< largest number of plans after the first one of a goal, whatever their cause, ≥ 0
  double duration = 600;           ///< time limit of the run, by the clock of the plant [s], > 0
  double silence = 0.5;            ///< objects unseen for longer than this are away: the robot holds [s], > 0
  double absence = 30;             ///< the run ends when objects are away for longer than this [s], ≥ silence
  std::optional<RunSpeeds> speed;  ///< speed limits; empty: calc_run_speeds for the object of the goal and speed_factor
  double speed_factor = 1;         ///< factor for calc_run_speeds if `speed` is empty, > 0
  std::function<void(const RunSample& sample)> on_sample;  ///< called at every look, in the thread of the run
  void validate() const;                                   ///< @throws core::InvalidInput naming the field
};

/// Record of one piece of a plan that was carried out.
struct RunPiece {
  planning::SegmentKind kind = planning::SegmentKind::Contact;
  int plan = 0;                   ///< number of its plan; −1: the given plan, or no plan was needed yet
  double begin_s = 0, end_s = 0;  ///< since the start of the run
  double off = 0;                 ///< distance of the object from its planned path at the end [tolerances of the goal]
  bool given_up = false;          ///< the piece ended early because the object was too far off its path
};

/// One call of the planner.
struct RunPlan {
  double time = 0;         ///< time in the run at which the planner was asked [s]
  double wall_s = 0;       ///< wall time of the call [s]
  double processor_s = 0;  ///< processor time of all cores of the process [s]
  double clock_s = 0;      ///< time that passed on the clock of the plant [s]
  core::Status status = core::Status::NumericalFailure;
  std::string cause;    ///< why the planner was asked
  std::string reason;   ///< message of the planner if it found no plan
  bool joined = false;  ///< the run went on with the current plan, without a search
};

/// One goal of a run.
struct RunGoal {
  bool reached = false;
  double begin_s = 0;         ///< time since the start of the run at which this goal became the current one
  double end_s = 0;           ///< time at which it had been held for long enough, or the run ended
  int replans = 0;            ///< plans after the first one for this goal
  planning::GoalError error;  ///< measured error at end_s
};

struct RunResult {
  core::Status status = core::Status::NumericalFailure;
  RunEnd end = RunEnd::Silent;
  std::string message;        ///< why the run ended, if not Reached
  planning::GoalError error;  ///< measured error of the object at the end
  double duration_s = 0;      ///< duration of the run by the clock of the plant
  double planning_s = 0;      ///< wall time of all plans
  double wall_s = 0;
  std::vector<RunPlan> plans;
  int replans = 0;  ///< number of plans after the first one of each goal; a request that is repeated after a refusal counts once
  std::vector<RunPiece> pieces;
  std::vector<RunGoal> goals;                      ///< goals that were begun
  std::optional<int> dropped;                      ///< index of the object that fell
  std::optional<planning::PlanResult> first_plan;  ///< first result of the planner
  std::vector<double> times;                       ///< times of the looks [s]
  Eigen::MatrixXd q, q_plan;                       ///< measured and planned configurations (n_q × looks)
  Eigen::MatrixXd u;                               ///< commands (n_a × looks)
  std::vector<int> piece;                          ///< index into pieces for each look; −1 before the first piece

  bool reached() const { return end == RunEnd::Reached; }  ///< all goals were reached
  long goals_reached() const;
  long count(planning::SegmentKind kind) const;  ///< number of pieces of this kind that were carried out
};

/// Runs a task in closed loop: plans from the measured state, carries out the pieces of the plan at real speed, and plans again if the object leaves its path
/// or misses the end of a piece or of the plan. Commands are those of the plan, ahead of the joints by no more than the motors can pull (E.15).
/// The robot holds its last command while the planner works, and after the end of the run for any reason.
///
/// @param problem  model and goal; the start is read from the plant, not from here
/// @param options  options of the planner; its seed is used for the first plan, and the seeds of later plans follow from it
/// @param first    plan to begin with, used if it starts from the measured state; null: none
/// @returns Solved: Reached; Cancelled; NumericalFailure: Silent; MaxIterations: any other end. `out` holds the record of the run
/// @throws  core::InvalidInput: invalid options or problem, or a plan that does not fit the model
/// Tests: tests/execution/run_test.cpp, tests/python/test_run.py
[[nodiscard]] core::Status run(Driver& plant, const planning::PlanningProblem& problem, const planning::PlannerOptions& options,
                               const RunOptions& how, const core::RunControl& control, RunResult& out,
                               const planning::Plan* first = nullptr);

/// Runs to several goals in a row; the next goal begins after the one before was held. The plant, its clock and all budgets but RunOptions::replans are
/// shared by the goals. A goal that is not reached ends the run. If the run stops early, RunResult::error refers to the goal that was current then.
/// @param goals  problems of the same model, at least one; their q_start are ignored
/// @param first  plan to the first goal; null: none
[[nodiscard]] core::Status run(Driver& plant, std::span<const planning::PlanningProblem> goals, const planning::PlannerOptions& options,
                               const RunOptions& how, const core::RunControl& control, RunResult& out,
                               const planning::Plan* first = nullptr);

}  // namespace stiction::execution
