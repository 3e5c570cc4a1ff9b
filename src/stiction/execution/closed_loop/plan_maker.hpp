#pragma once

#include <optional>
#include <string>

#include "stiction/execution/closed_loop/commanded_robot.hpp"
#include "stiction/execution/closed_loop/plan_request.hpp"
#include "stiction/execution/closed_loop/plan_source.hpp"

namespace stiction::execution {

/// Gets the plans of a run: chooses the requests (PlanRequest), commands the robot meanwhile, and handles refusals.
class PlanMaker {
 public:
  /// @param real_time  true: the clock of the plant goes on by itself
  PlanMaker(CommandedRobot& robot, PlanSource& source, const world::Model& model, const RunOptions& how, bool real_time,
            const core::RunControl& control, RunResult& out)
      : robot_(robot), source_(source), model_(model), how_(how), real_time_(real_time), control_(control), out_(out) {}

  /// Returns a timed plan from the measured state. If none is found, the run ends.
  /// @param cause    why a plan is needed; replaced by the cause of the next plan if nothing is returned
  /// @param counts   true: this is not the first plan of the goal and counts towards RunOptions::replans
  /// @returns nothing if the run is over, if the object has left the start of the plan, or if it came to its goal while the robot prepared
  std::optional<Trajectory> make(std::string& cause, bool counts);

 private:
  bool count();
  bool wait_for_rest(double time);
  bool prepare(Preparation preparation);
  bool ask(const PlanRequest& request, Answer& answer);
  bool meet(const Question& question, double arrival, Answer& answer);
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
