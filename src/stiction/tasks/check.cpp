#include "stiction/tasks/check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/tasks/check_file.hpp"
#include "stiction/tasks/check_replay.hpp"
#include "stiction/tasks/pose_numbers.hpp"

namespace stiction::tasks {

using core::Status;

PoseError goal_error(const world::Model& model, const PlanFile& plan, const Eigen::VectorXd& q) {
  PoseError out{0, 0};
  Eigen::VectorXd nearest = q;  // the meaning of the region belongs to the problem, not to how it was solved
  if (plan.region) planning::project(model, *plan.region, nearest.head(model.n_qu()));
  for (const int object : goal_objects(model, plan)) {
    const world::Pose X_WO = world::object_pose(model, q, object);
    const world::Pose X_WG = plan.region ? world::object_pose(model, nearest, object) : to_pose(plan.goal_pose);
    double angle = angle_between(X_WO.R, X_WG.R);
    if (model.scene().objects[static_cast<std::size_t>(object)].joint == world::ObjectJoint::Hinge) {
      const int at = model.objects()[static_cast<std::size_t>(object)].q_begin;
      if (std::abs(q[at] - nearest[at]) > std::numbers::pi) angle = std::abs(q[at] - nearest[at]);
    }
    out = {std::max(out.position, (X_WO.p - X_WG.p).norm()), std::max(out.angle, angle)};
  }
  return out;
}

std::vector<int> goal_objects(const world::Model& model, const PlanFile& plan) {
  planning::Goal goal;
  goal.object = model.object_index(plan.goal_object);
  goal.region = plan.region;
  return planning::goal_objects(model, goal);
}

Eigen::VectorXd normalised(const world::Model& model, Eigen::VectorXd q) {
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    if (model.scene().objects[i].joint != world::ObjectJoint::Free) continue;
    auto c = q.segment(model.objects()[i].q_begin + 3, 4);
    if (std::abs(c.norm() - 1) <= CheckOptions{}.quaternion_norm) continue;  // a valid quaternion stays bitwise as stored
    if (c.norm() > 0) {
      c.normalize();
    } else {
      c << 0, 0, 0, 1;
    }
  }
  return q;
}

const CheckItem& CheckReport::at(std::string_view name) const {
  for (const auto& item : items) {
    if (item.name == name) return item;
  }
  core::throw_invalid("check", fmt::format("'{}'", name), "the name of a check");
}

Status check_plan(const Task& task, const PlanFile& plan, const CheckOptions& options, const core::RunControl& control, CheckReport& out) {
  const auto start = core::RunControl::Clock::now();
  out = {};
  Replay replay(task, plan, options);
  FileCheck file(task, plan, options);
  out.status = replay.run(control, out);
  file.run();
  replay.report(out);
  file.report(out);
  out.pass = out.status == Status::Solved && std::all_of(out.items.begin(), out.items.end(), [](const CheckItem& i) { return i.pass; });
  out.wall_s = core::seconds_since(start);
  return out.status;
}

}  // namespace stiction::tasks
