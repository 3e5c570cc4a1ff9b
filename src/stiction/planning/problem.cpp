#include "stiction/planning/planner.hpp"

#include <fmt/format.h>

#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/contact_limits.hpp"
#include "stiction/planning/goal_measure.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using world::Model;

/// Throws if the goal puts a coordinate of an object outside its limits. A coordinate without limits always passes.
void require_in_range(const Model& model, const Goal& goal, int i, double lower, double upper) {
  const auto& dof = model.dofs()[static_cast<std::size_t>(i)];
  const double tolerance = dof.kind == world::DofKind::Revolute ? goal.tol_angle : goal.tol_position;
  if (lower <= dof.upper + tolerance && upper >= dof.lower - tolerance) return;
  const std::string given =
      lower == upper ? fmt::format("{} = {}", dof.name, lower) : fmt::format("{} in [{}, {}]", dof.name, lower, upper);
  core::throw_invalid("goal", given, fmt::format("a value in its range [{}, {}]", dof.lower, dof.upper));
}

void require_region(const Model& model, const GoalRegion& region) {
  core::require_size("goal.region.lower", region.lower.size(), model.n_vu());
  core::require_size("goal.region.upper", region.upper.size(), model.n_vu());
  for (int i = 0; i < model.n_vu(); ++i) {
    if (!(region.lower[i] <= region.upper[i]))
      core::throw_invalid("goal.region",
                          fmt::format("{} in [{}, {}]", model.dofs()[static_cast<std::size_t>(i)].name, region.lower[i], region.upper[i]),
                          "lower ≤ upper");
  }
}

/// Throws if the goal is outside the range of the object's joint, or is one pose that penetrates fixed bodies by more than its tolerance.
void require_reachable_goal(const PlanningProblem& problem) {
  const Model& model = *problem.model;
  const Goal& goal = problem.goal;
  if (goal.region) require_region(model, *goal.region);
  const Eigen::VectorXd q_goal = goal_configuration(problem, world::ObjectSpace(model));
  for (int i = 0; i < model.n_vu(); ++i) {
    const auto& dof = model.dofs()[static_cast<std::size_t>(i)];
    if (!std::isfinite(dof.lower) && !std::isfinite(dof.upper)) continue;
    const double x = q_goal[model.objects()[static_cast<std::size_t>(dof.owner)].q_begin];  // hinge or slider
    require_in_range(model, goal, i, goal.region ? goal.region->lower[i] : x, goal.region ? goal.region->upper[i] : x);
  }
  if (goal.region) return;
  Eigen::VectorXd q = problem.q_start;
  q.head(model.n_qu()) = q_goal;
  contact::GeometryWorkspace work(model);
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  contact::query(model, work.kinematics, {}, work.contact_work, work.contacts);
  const int body = model.objects()[static_cast<std::size_t>(goal.object)].body;
  for (const auto& c : work.contacts) {
    const auto& pair = model.pairs()[static_cast<std::size_t>(c.pair)];
    const auto& a = model.geometries()[static_cast<std::size_t>(pair.geometry_a)];
    const auto& b = model.geometries()[static_cast<std::size_t>(pair.geometry_b)];
    const bool fixed = model.bodies()[static_cast<std::size_t>(b.body)].dofs.empty();  // a fixed body, or the base of a robot
    if (a.body != body || !fixed || c.phi > -(goal.tol_position + kMostEdgePenetration * model.scales().contact_tolerance(c.pair)))
      continue;
    core::throw_invalid("goal", fmt::format("a pose in which '{}' is {:.3g} m inside '{}'", a.name, -c.phi, b.name),
                        "one outside everything that cannot move");
  }
}

}  // namespace

void PlanningProblem::validate() const {
  if (!model) core::throw_invalid("problem.model", "nothing", "a model");
  world::require_configuration(*model, "start", q_start);
  if (goal.object < 0 || goal.object >= static_cast<int>(model->objects().size())) {
    core::throw_invalid("goal.object", std::to_string(goal.object), "the index of an object");
  }
  core::require_positive("goal.tol_position", goal.tol_position);
  core::require_positive("goal.tol_angle", goal.tol_angle);
  if (q_goal.size() > 0) core::require_size("problem.q_goal", q_goal.size(), model->n_qu());
  require_reachable_goal(*this);
}

}  // namespace stiction::planning
