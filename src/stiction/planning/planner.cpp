#include "stiction/planning/planner.hpp"

#include "stiction/planning/anytime.hpp"
#include "stiction/planning/default_options.hpp"
#include "stiction/planning/forest.hpp"
#include "stiction/planning/problem.hpp"

namespace stiction::planning {

core::Status plan(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, PlanResult& result) {
  const auto start = core::RunControl::Clock::now();
  validate(problem);
  options.validate(*problem.model);
  PlannerOptions whole = options;
  if (whole.sample_boxes.empty()) whole.sample_boxes = default_sample_boxes(problem);

  result = PlanResult{};
  grow_forest(problem, whole, control, start, result);
  if (result.status == core::Status::Solved) {
    result.improvements.push_back({result.cost, result.iterations, core::seconds_since(start)});
    if (options.anytime) improve(problem, whole, control, start, result);
  }
  result.wall_s = core::seconds_since(start);
  return result.status;
}

}  // namespace stiction::planning
