#pragma once

#include <optional>
#include <string>

#include "stiction/execution/closed_loop/commanded_robot.hpp"
#include "stiction/execution/closed_loop/plan_request.hpp"
#include "stiction/execution/closed_loop/plan_source.hpp"

namespace stiction::execution {

/// How a run comes to its plans: what the planner is asked (PlanRequest), what the robot does meanwhile, and what comes of the answers.
class PlanMaker {
 public:
  /// @param real_time  the clock of the plant goes on by itself
  PlanMaker(CommandedRobot& robot, PlanSource& source, const world::Model& model, const RunOptions& how, bool real_time,
            const core::RunControl& control, RunResult& out)
      : robot_(robot), source_(source), model_(model), how_(how), real_time_(real_time), control_(control), out_(out) {}

  /// A plan from what is measured; where none is found the run is over.
  /// @param cause    why one is needed
  /// @param counts   it is not the first one of the goal: too many of them end the run
  /// @returns nothing: the run is over, or the object is no more where the plan begins, or came to its goal as the robot made ready; `cause` then says
  ///          for what the next plan is
  std::optional<Trajectory> make(std::string& cause, bool counts);

 private:
  bool count();
  bool prepare(Preparation preparation);
  bool ask(const PlanRequest& request, Answer& answer);
  template <class Work>
  bool think_first(const Work& work, const Answer& answer);
  template <class Work>
  bool think_beside(const Work& work);

  CommandedRobot& robot_;
  PlanSource& source_;
  const world::Model& model_;
  const RunOptions& how_;
  bool real_time_;
  const core::RunControl& control_;
  RunResult& out_;
};

}  // namespace stiction::execution
