#include "stiction/planning/sample_boxes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "stiction/planning/goal_measure.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

/// Share of the way from start to goal by which a box extends beyond both.
constexpr double kWayBeyond = 0.25;
/// Share of the level part of the way by which a box of a free object extends upwards, because objects pass above obstacles.
constexpr double kAbove = 0.5;
/// Least angle by which a box extends beyond start and goal [rad].
constexpr double kBeyond = 0.2;

/// Coordinates in which a box is given: x y z roll pitch yaw of a free object, else the joint coordinates.
Eigen::VectorXd box_coordinates(const world::ObjectInfo& object, const Eigen::VectorXd& q) {
  if (object.n_v != 6) return q.segment(object.q_begin, object.n_q);
  Eigen::VectorXd out(6);
  out << q.segment<3>(object.q_begin),
      roll_pitch_yaw(Eigen::Quaterniond(Eigen::Vector4d(q.segment<4>(object.q_begin + 3))).normalized().toRotationMatrix());
  return out;
}

}  // namespace

std::vector<world::SampleBox> default_sample_boxes(const PlanningProblem& problem) {
  const world::Model& model = *problem.model;
  const world::ObjectSpace space(model);
  Eigen::VectorXd q_goal = problem.q_start;
  q_goal.head(model.n_qu()) = goal_configuration(problem, space);
  std::vector<world::SampleBox> boxes;
  std::vector<int> objects;
  for (const int of_goal : goal_objects(model, problem.goal)) {
    std::vector<int> chain = chain_of(model, of_goal);
    std::ranges::reverse(chain);
    std::ranges::copy_if(chain, std::back_inserter(objects), [&](int o) { return std::ranges::find(objects, o) == objects.end(); });
  }
  for (const int o : objects) {
    const world::ObjectInfo& object = model.objects()[static_cast<std::size_t>(o)];
    const Eigen::VectorXd start = box_coordinates(object, problem.q_start), goal = box_coordinates(object, q_goal);
    world::SampleBox& box = boxes.emplace_back();
    box.object = o;
    box.lower = box.upper = start;
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      const world::Dof& dof = model.dofs()[static_cast<std::size_t>(object.v_begin + i)];
      if (object.n_v == 1 && std::isfinite(dof.lower) && std::isfinite(dof.upper)) {
        box.lower[i] = dof.lower;
        box.upper[i] = dof.upper;
        continue;
      }
      const bool revolute = dof.kind == world::DofKind::Revolute;
      const double to = revolute && object.n_v > 1 ? world::nearest_turn(goal[i], start[i]) : goal[i];
      const double beyond = std::max(kWayBeyond * std::abs(to - start[i]), revolute ? kBeyond : 0.5 * model.scales().object(o).length);
      box.lower[i] = std::min(start[i], to) - beyond;
      box.upper[i] = std::max(start[i], to) + beyond;
    }
    if (object.n_v == 6 && model.scene().gravity.norm() > 0) {
      const Eigen::Vector3d up = -model.scene().gravity.normalized();
      const Eigen::Vector3d way = (goal - start).head<3>();
      const double above = kAbove * (way - up * up.dot(way)).norm();
      for (int i = 0; i < 3; ++i) {
        box.lower[i] += std::min(0.0, above * up[i]);
        box.upper[i] += std::max(0.0, above * up[i]);
      }
    }
  }
  return boxes;
}

}  // namespace stiction::planning
