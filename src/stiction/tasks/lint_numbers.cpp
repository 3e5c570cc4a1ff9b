#include "stiction/tasks/lint_numbers.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "stiction/world/scales.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {
namespace {

using std::numbers::pi;
using world::YamlNode;

constexpr double kTurn = 2 * pi;
constexpr double kTurnWritten = kTurn * (1 + 1e-3);  // 6.2832, and whatever else people write for 2π
constexpr double kTurnsOfALimit = 2 * kTurnWritten;  // wrists turn by two turns each way

std::string degrees(double x) {
  return fmt::format("{:g} rad, which is {:.1f} turns; angles are in radians, {:g}° = {:.4g} rad", x, std::abs(x) / kTurn, x, x * pi / 180);
}

/// Every number below a value, at any depth.
template <class Look>
void each_number(const YamlNode& node, const Look& look) {
  if (node.is_sequence()) {
    for (const YamlNode& item : node.items()) each_number(item, look);
  } else if (node.is_number()) {
    look(node.number());
  }
}

void look_at_angles(const YamlNode& rpy, std::vector<Finding>& out) {
  each_number(rpy, [&](double x) {
    if (std::abs(x) > kTurnWritten) out.push_back({"units", fmt::format("{}: {}", rpy.where(), degrees(x))});
  });
}

/// (w, x, y, z) = (0, v) is a half turn about v; (v, w) = (x, y, z, w) with w ≠ 0 is less than that.
void look_at_quaternion(const YamlNode& node, std::vector<Finding>& out) {
  const Eigen::VectorXd c = node.vector(4);
  if (std::abs(c[0]) > 1e-6 || std::abs(c[3]) < 1e-6) return;
  const double as_xyzw = 2 * std::atan2(c.head<3>().norm(), std::abs(c[3]));
  out.push_back(
      {"quaternion", fmt::format("{}: [{:g}, {:g}, {:g}, {:g}] is half a turn; w comes first here. As x y z w it would be {:.4g} rad",
                                 node.where(), c[0], c[1], c[2], c[3], as_xyzw)});
}

void walk(const YamlNode& node, std::vector<Finding>& out) {
  if (node.is_sequence()) {
    for (const YamlNode& item : node.items()) walk(item, out);
  }
  if (!node.is_map()) return;
  for (const auto& [key, value] : node.entries()) {
    if (key == "rpy") look_at_angles(value, out);
    if (key == "quaternion_wxyz" && value.is_sequence()) look_at_quaternion(value, out);
    walk(value, out);
  }
}

/// Coordinates that are angles: those of objects in a plane are rotations, that of a hinge is a number that its limits hold.
void look_at_coordinates(const Task& task, std::string_view section, const Eigen::VectorXd& q, std::vector<Finding>& out) {
  const world::Model& model = *task.model;
  for (const auto& object : model.objects()) {
    for (int i = 0; i < object.n_v; ++i) {
      const auto& dof = model.dofs()[static_cast<std::size_t>(object.v_begin + i)];
      const bool within_limits = std::isfinite(dof.lower) && std::isfinite(dof.upper);
      if (dof.kind != world::DofKind::Revolute || object.n_v == 6 || within_limits) continue;
      if (const double x = q[object.q_begin + i]; std::abs(x) > kTurnWritten)
        out.push_back({"units", fmt::format("{}: {} = {}", section, dof.name, degrees(x))});
    }
  }
}

void look_at_limits(const world::Model& model, std::vector<Finding>& out) {
  for (const auto& dof : model.dofs()) {
    if (dof.kind != world::DofKind::Revolute) continue;
    for (const double x : {dof.lower, dof.upper}) {
      if (std::isfinite(x) && std::abs(x) > kTurnsOfALimit) {
        out.push_back({"units", fmt::format("limits of {}: {}", dof.name, degrees(x))});
        break;
      }
    }
  }
}

void look_at_tolerances(const Task& task, std::vector<Finding>& out) {
  const planning::Goal& goal = task.problem.goal;
  if (goal.tol_angle > pi / 2)
    out.push_back({"units", fmt::format("tolerance.angle: {}; no two orientations are farther apart than π", degrees(goal.tol_angle))});
  const double L = task.model->scales().object(goal.object).length;
  if (goal.tol_position > 10 * L)
    out.push_back(
        {"units", fmt::format("tolerance.position: {:g} m, for an object of {:.2g} m; lengths are in metres", goal.tol_position, L)});
}

}  // namespace

void lint_numbers(const Task& task, std::vector<Finding>& out) {
  const YamlNode& root = task.document;
  if (root.is_map()) {  // a copy of a task has no file
    for (const char* section : {"start", "goal", "scene"}) {
      if (const auto node = root.find(section)) walk(*node, out);  // a scene of others may bring the start
    }
  }
  look_at_coordinates(task, "start", task.problem.q_start, out);
  look_at_coordinates(task, "goal", task.problem.q_goal, out);
  look_at_limits(*task.model, out);
  look_at_tolerances(task, out);
}

}  // namespace stiction::tasks
