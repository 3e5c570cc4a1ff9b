#include "stiction/planning/goal_measure.hpp"

#include <algorithm>
#include <cmath>

namespace stiction::planning {
namespace {

/// 1 per coordinate that a goal region bounds, else 0. All three coordinates of a rotation count if one of roll, pitch and yaw is bounded.
Eigen::VectorXd bounded_coordinates(const world::Model& model, const GoalRegion& region) {
  Eigen::VectorXd out(model.n_vu());
  for (int i = 0; i < model.n_vu(); ++i) out[i] = std::isfinite(region.lower[i]) || std::isfinite(region.upper[i]);
  for (const auto& object : model.objects()) {
    if (object.n_v == 6) out.segment<3>(object.v_begin + 3).setConstant(out.segment<3>(object.v_begin + 3).maxCoeff());
  }
  return out;
}

/// The objects that robots can touch neither directly nor at their carriers.
std::vector<int> find_out_of_touch(const world::Model& model, const std::vector<int>& objects) {
  const auto body = [&](int geometry) { return model.geometries()[static_cast<std::size_t>(geometry)].body; };
  std::vector<char> touched(model.bodies().size(), 0);
  for (const auto& pair : model.pairs()) {
    if (model.bodies()[static_cast<std::size_t>(body(pair.geometry_b))].kind == world::BodyKind::Robot)
      touched[static_cast<std::size_t>(body(pair.geometry_a))] = 1;
  }
  std::vector<int> out;
  for (const int object : objects) {
    const auto chain = chain_of(model, object);
    const auto is_touched = [&](int o) {
      return touched[static_cast<std::size_t>(model.objects()[static_cast<std::size_t>(o)].body)] != 0;
    };
    if (std::ranges::none_of(chain, is_touched)) out.push_back(object);
  }
  return out;
}

}  // namespace

Eigen::VectorXd goal_configuration(const PlanningProblem& problem, const world::ObjectSpace& space) {
  if (problem.q_goal.size() > 0) return problem.q_goal;
  const auto& object = problem.model->objects()[static_cast<std::size_t>(problem.goal.object)];
  Eigen::VectorXd q_goal = problem.q_start.head(problem.model->n_qu());
  q_goal.segment(object.q_begin, object.n_q) = space.coordinates(problem.goal.object, problem.goal.X_WG);
  return q_goal;
}

GoalMeasure::GoalMeasure(const PlanningProblem& problem)
    : model_(*problem.model),
      goal_(problem.goal),
      space_(model_),
      objects_(goal_objects(model_, goal_)),
      out_of_touch_(find_out_of_touch(model_, objects_)),
      tolerances_(path_tolerances(model_, goal_)),
      q_goal_(goal_configuration(problem, space_)),
      inverse_tolerances_(planning::inverse_tolerances(model_, goal_)),
      bounded_(problem.goal.region     ? bounded_coordinates(model_, *problem.goal.region)
               : out_of_touch_.empty() ? Eigen::VectorXd::Ones(model_.n_vu())
                                       : flags(objects_)) {}

Eigen::VectorXd GoalMeasure::nearest_to(const Eigen::VectorXd& q_u) const {
  if (!goal_.region) return out_of_touch_.empty() ? q_goal_ : with(objects_, q_goal_, q_u);
  Eigen::VectorXd q = q_u;
  project(model_, *goal_.region, q);
  return q;
}

Eigen::VectorXd GoalMeasure::with(const std::vector<int>& objects, const Eigen::VectorXd& q_there, Eigen::VectorXd q_u) const {
  for (const int object : objects) {
    for (const int o : chain_of(model_, object)) {
      const auto& info = model_.objects()[static_cast<std::size_t>(o)];
      q_u.segment(info.q_begin, info.n_q) = q_there.segment(info.q_begin, info.n_q);
    }
  }
  return q_u;
}

Eigen::VectorXd GoalMeasure::flags(const std::vector<int>& objects) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(model_.n_vu());
  for (const int object : objects) {
    for (const int o : chain_of(model_, object)) {
      const auto& info = model_.objects()[static_cast<std::size_t>(o)];
      out.segment(info.v_begin, info.n_v).setOnes();
    }
  }
  return out;
}

double GoalMeasure::ratio(const Eigen::VectorXd& q) const { return goal_error(model_, q, goal_).share(goal_); }

double GoalMeasure::distance(const Eigen::VectorXd& q, const Eigen::VectorXd& q_u) const {
  return inverse_tolerances_.cwiseProduct(difference(q, q_u)).norm();
}

Eigen::VectorXd GoalMeasure::difference(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
  Eigen::VectorXd e(model_.n_vu());
  space_.error(from.data(), to.data(), e.data());
  return e;
}

double GoalMeasure::share(const Eigen::VectorXd& from, const Eigen::VectorXd& to, double position, double angle) const {
  return world::largest_share(model_, difference(from, to), position, angle);
}

}  // namespace stiction::planning
