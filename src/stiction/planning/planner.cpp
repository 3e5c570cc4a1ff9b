#include "stiction/planning/planner.hpp"

#include <span>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/sample_boxes.hpp"
#include "stiction/planning/search.hpp"
#include "stiction/planning/thesis/rrt.hpp"

namespace stiction::planning {
namespace {

core::Status run(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                 const core::RunControl& control, const GrowthSink& grown, const PlanSink& found, PlanResult& result) {
  const auto start = core::RunControl::Clock::now();
  problem.validate();
  if (u_start.size() > 0) {
    core::require_size("u_start", u_start.size(), problem.model->n_a());
    core::require_finite("u_start", std::span(u_start.data(), static_cast<std::size_t>(u_start.size())));
  }
  options.validate(*problem.model);
  PlannerOptions whole = options;
  if (whole.sample_boxes.empty()) whole.sample_boxes = default_sample_boxes(problem);

  result = PlanResult{};
  if (options.thesis) {
    thesis::grow_tree(problem, whole, control, result);
  } else {
    search(problem, u_start, whole, control, start, grown, result);
  }
  if (result.status == core::Status::Solved) {
    result.wall_s = core::seconds_since(start);
    result.improvements.push_back({result.cost, result.iterations, result.wall_s});
    if (found) found(result);
    if (options.anytime) improve(problem, u_start, whole, control, start, found, result);
  }
  result.wall_s = core::seconds_since(start);
  return result.status;
}

}  // namespace

core::Status plan(const PlanningProblem& problem, const PlannerOptions& options, const core::RunControl& control, PlanResult& result) {
  return run(problem, {}, options, control, {}, {}, result);
}

core::Status plan_from(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                       const core::RunControl& control, PlanResult& result) {
  return run(problem, u_start, options, control, {}, {}, result);
}

core::Status plan_watched(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options,
                          const core::RunControl& control, const GrowthSink& grown, PlanResult& result, const PlanSink& found) {
  return run(problem, u_start, options, control, grown, found, result);
}

}  // namespace stiction::planning
