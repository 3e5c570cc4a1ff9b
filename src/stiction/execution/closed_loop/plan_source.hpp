#pragma once

#include <limits>
#include <optional>

#include "stiction/execution/closed_loop/run.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"

namespace stiction::execution {

/// From where a plan is wanted, and how.
struct Question {
  Eigen::VectorXd q{}, u{};  ///< the state and the commands in force (n_q), (n_a)
  std::size_t number = 0;    ///< of plans that were asked for before: later seeds follow from it
  double friction = 1;       ///< every μ of the plan times this; a plan that one has is gone on with where it has this friction
  bool is_short = false;     ///< the search ends after twice as many extensions as the one before took
  double time_left =
      std::numeric_limits<double>::infinity();  ///< of a run whose clock waits for the planner: what takes longer is of no use [s]
};

/// What the planner gave for one state, and what that took.
struct Answer {
  planning::PlanResult result;
  std::optional<Trajectory> trajectory;  ///< of its plan, where it is worth carrying out
  double processor_s = 0;                ///< of all cores of the process
  bool joined = false;                   ///< the plan before goes on, and nothing was searched
  bool slips = false;                    ///< the object does not rest at the start with the friction of the plan, and nothing was searched
  long join_steps = 0;                   ///< that trying to go on took
  bool late = false;                     ///< things are no more where the plan begins
  double charge_s = 0;                   ///< for which the clock of the plant goes on meanwhile
};

/// Asks the planner on the way of a run. It knows the plant by what was measured alone, so that it may work beside the loop that commands the plant.
class PlanSource {
 public:
  PlanSource(const planning::PlanningProblem& problem, const planning::PlannerOptions& options, const RunOptions& how,
             const RunSpeeds& speed);

  /// @param control  of the run; a plan has the budget of the RunOptions besides
  Answer ask(const Question& question, const core::RunControl& control);
  int found() const { return found_; }  ///< plans that were found by a search

  /// The problem has another goal: the plan that one has does not lead there.
  void forget_plan();

  /// The timing of a plan, which is kept to be gone on with.
  Trajectory take(const planning::Plan& plan);
  /// A share of the tolerances at which a plan counts as at the goal.
  double fraction() const { return options_.tolerance_fraction; }

 private:
  bool join(const Question& from, Answer& out);
  void judge(const Question& from, Answer& out);
  bool came_nearer(const Eigen::VectorXd& q);
  double share(const Eigen::VectorXd& q) const;
  double expected_time(const Eigen::VectorXd& q) const;
  void search(const Question& from, const core::RunControl& run, planning::PlanResult& out) const;

  const planning::PlanningProblem& problem_;
  planning::PlannerOptions options_;
  const RunOptions& how_;
  const RunSpeeds& speed_;
  DragFeedforward lead_;
  std::optional<planning::Plan> last_;  ///< that is carried out
  double durations_ = 0, shares_ = 0;   ///< of plans that were found: sums of their durations [s] and of their ways [tolerances]
  double thought_ = 0;                  ///< what searches took of the clock [s]
  int searches_ = 0, found_ = 0;
  long usual_ = 0;  ///< extensions of the last search that found a plan
  double nearest_ =
      std::numeric_limits<double>::infinity();  ///< to the goal, of the states from which the plan was gone on with [tolerances]
  int in_vain_ = 0;                             ///< how often it was since then
};

}  // namespace stiction::execution
