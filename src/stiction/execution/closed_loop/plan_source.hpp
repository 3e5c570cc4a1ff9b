#pragma once

#include <limits>
#include <optional>

#include "stiction/execution/closed_loop/run.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"

namespace stiction::execution {

/// Request for a plan from one state.
struct Question {
  Eigen::VectorXd q{}, u{};  ///< state (n_q) and commands in force (n_a)
  std::size_t number = 0;    ///< number of plans requested before; the seeds of later plans follow from it
  double friction = 1;       ///< factor of every μ in the plan; the current plan is only continued if it has the same factor
  bool is_short = false;     ///< end the search after twice as many extensions as the last successful one took
  /// Time left in a run whose clock waits for the planner; a plan that takes longer is of no use [s].
  double time_left = std::numeric_limits<double>::infinity();
};

/// Answer to a Question, and its cost.
struct Answer {
  planning::PlanResult result;
  std::optional<Trajectory> trajectory;  ///< timed plan, if it is worth carrying out
  double processor_s = 0;                ///< processor time of all cores of the process
  bool joined = false;                   ///< the current plan goes on, without a search
  bool slips = false;                    ///< no search: the object does not rest at the start with the friction of the plan
  long join_steps = 0;                   ///< steps spent on trying to go on with the current plan
  bool late = false;                     ///< the measured state has left the start of the plan meanwhile
  double charge_s = 0;                   ///< time for which the clock of the plant goes on meanwhile [s]
};

/// Gets plans during a run. It uses nothing of the plant but the measured state, so it can work beside the loop that commands the plant.
class PlanSource {
 public:
  PlanSource(const planning::PlanningProblem& problem, const planning::PlannerOptions& options, const RunOptions& how,
             const RunSpeeds& speed);

  /// @param control  control of the run; each plan also has the budget of the RunOptions
  Answer ask(const Question& question, const core::RunControl& control);
  int found() const { return found_; }  ///< number of plans found by a search

  /// Discards the current plan, because the problem has another goal.
  void forget_plan();

  /// Times a plan and keeps it as the current plan, to be continued later.
  Trajectory take(const planning::Plan& plan);
  /// Share of the goal's tolerances within which a plan counts as reaching the goal.
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
  const double enough_;                 ///< share of the tolerances that the planner's options ask for; they ask for plan_fraction in a run
  std::optional<planning::Plan> last_;  ///< current plan, which is being carried out
  double durations_ = 0, shares_ = 0;   ///< sums over the found plans: duration [s] and distance to the goal [tolerances]
  double thought_ = 0;                  ///< sum of the times charged for searches [s]
  int searches_ = 0, found_ = 0;
  long usual_ = 0;  ///< number of extensions of the last successful search
  /// Least distance from the goal of the states from which the plan was continued [tolerances].
  double nearest_ = std::numeric_limits<double>::infinity();
  int in_vain_ = 0;  ///< how often the plan was continued since then
};

}  // namespace stiction::execution
