#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stiction/core/faults.hpp"
#include "stiction/planning/goal_measure.hpp"
#include "stiction/tasks/file_start.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/tasks/task_sections.hpp"
#include "stiction/world/object_space.hpp"

namespace stiction::tasks {
namespace {

using world::Model;
using world::YamlNode;

/// Of a goal: what was written is more than one pose: somewhere [lower, upper], or ~ for any value.
bool is_region(const YamlNode& node) {
  for (const char* key : {"position", "rpy", "coordinates"}) {
    const auto value = node.find(key);
    if (!value) continue;
    if (value->kind() == YamlNode::Kind::Null) return true;
    if (!value->is_sequence()) continue;
    for (const YamlNode& item : value->items()) {
      if (item.is_sequence() || item.kind() == YamlNode::Kind::Null) return true;
    }
  }
  return false;
}

/// Coordinates of a goal, each a number, [lower, upper], or ~ for any value; ~ for all of them.
void read_bounds(const YamlNode& node, Eigen::Ref<Eigen::VectorXd> lower, Eigen::Ref<Eigen::VectorXd> upper) {
  if (node.kind() == YamlNode::Kind::Null) return;  // bounds are infinite until given
  const auto items = node.items(static_cast<std::size_t>(lower.size()));
  for (Eigen::Index i = 0; i < lower.size(); ++i) {
    const YamlNode& item = items[static_cast<std::size_t>(i)];
    if (item.kind() == YamlNode::Kind::Null) continue;
    if (item.is_sequence()) {
      const auto ends = item.items(2);
      if (ends[0].kind() != YamlNode::Kind::Null) lower[i] = ends[0].number();
      if (ends[1].kind() != YamlNode::Kind::Null) upper[i] = ends[1].number();
      if (lower[i] > upper[i]) item.fail("[lower, upper] with lower ≤ upper, or ~ for one that is open");
    } else {
      lower[i] = upper[i] = item.number();
    }
  }
}

/// Bounds of one object, as a goal section gives them.
void read_object_region(const YamlNode& node, const Model& model, int object, planning::GoalRegion& region) {
  const auto& info = model.objects()[static_cast<std::size_t>(object)];
  auto lower = region.lower.segment(info.v_begin, info.n_v), upper = region.upper.segment(info.v_begin, info.n_v);
  if (!is_free(model, object)) {
    node.require_map({"coordinates"});
    return read_bounds(node.at("coordinates"), lower, upper);
  }
  node.require_map({"position", "quaternion_wxyz", "rpy"});
  read_bounds(node.at("position"), lower.head<3>(), upper.head<3>());
  const auto rpy = node.find("rpy");
  if (rpy && !node.has("quaternion_wxyz")) return read_bounds(*rpy, lower.tail<3>(), upper.tail<3>());
  lower.tail<3>() = upper.tail<3>() = planning::roll_pitch_yaw(read_rotation(node).toRotationMatrix());
}

planning::GoalRegion unbounded(const Model& model) {
  const double infinity = std::numeric_limits<double>::infinity();
  return {Eigen::VectorXd::Constant(model.n_vu(), -infinity), Eigen::VectorXd::Constant(model.n_vu(), infinity)};
}

/// The goal is where the object is at q.
void set_goal_at(const Eigen::VectorXd& q, planning::PlanningProblem& problem) {
  const Model& model = *problem.model;
  problem.q_goal = q.head(model.n_qu());
  problem.goal.X_WG = world::object_pose(model, q, problem.goal.object);
}

/// The pose does not tell the goal from another turn of a hinge: the goal is more than half a turn away, or another turn of it lies inside
/// the limits. Such a goal is a region with one coordinate in it; a hinge is a number, 2π is not 0.
bool counts_turns(const Model& model, int object, double start, double goal) {
  const auto& spec = model.scene().objects[static_cast<std::size_t>(object)];
  if (spec.joint != world::ObjectJoint::Hinge) return false;
  constexpr double kTurn = 2 * std::numbers::pi;
  if (std::abs(goal - start) > kTurn / 2) return true;
  return spec.limits && (goal - kTurn >= (*spec.limits)[0] || goal + kTurn <= (*spec.limits)[1]);
}

/// The goal region, and what of it is nearest to the start.
void set_region(planning::GoalRegion region, planning::PlanningProblem& problem) {
  const Model& model = *problem.model;
  Eigen::VectorXd q = problem.q_start;
  planning::project(model, region, q.head(model.n_qu()));
  problem.goal.region = std::move(region);
  set_goal_at(q, problem);
}

/// The number in [lower, upper] that is nearest to the range of a hinge or slider.
double nearest_in_limits(const Model& model, int object, double lower, double upper) {
  const auto& spec = model.scene().objects[static_cast<std::size_t>(object)];
  return spec.limits ? std::clamp((*spec.limits)[0], lower, upper) : lower;
}

/// The object and those that it hangs on, from the world outwards.
std::vector<int> chain_of(const Model& model, int object) {
  std::vector<int> chain;
  for (int o = object; o >= 0; o = model.objects()[static_cast<std::size_t>(o)].parent) chain.insert(chain.begin(), o);
  return chain;
}

/// The goal is a site or a body of the file. `rpy: ~` leaves the orientation open.
void read_goal_at(const YamlNode& node, const Model& model, planning::PlanningProblem& problem) {
  node.require_map({"object", "at", "rpy"});
  const YamlNode name = node.at("object");
  const int object = problem.goal.object = find_object(name, name.string(), model);
  const auto& info = model.objects()[static_cast<std::size_t>(object)];
  if (info.n_v == 1)
    name.fail(fmt::format("'{}', which is on a hinge or a slider", info.name),
              fmt::format("objects: {{{}: {{coordinates: […]}}}}", info.name));
  const world::Pose X_WG = find_place(node.at("at"), model);
  Eigen::VectorXd q = problem.q_start;
  q.segment(info.q_begin, info.n_q) = world::ObjectSpace(model).coordinates(object, X_WG);
  set_goal_at(q, problem);
  const auto rpy = node.find("rpy");
  if (!rpy) return;
  if (rpy->kind() != YamlNode::Kind::Null) rpy->fail("~, an orientation that is open, or no rpy, that of the place");
  planning::GoalRegion region = unbounded(model);
  const int n = info.n_v == 6 ? 3 : 2;  // a free object, one in a plane
  region.lower.segment(info.v_begin, n) = region.upper.segment(info.v_begin, n) = q.segment(info.q_begin, n);
  set_region(std::move(region), problem);
}

}  // namespace

void read_tolerance(const YamlNode& node, planning::Goal& goal) {
  core::Faults faults;
  node.require_map();
  faults.collect([&] { node.require_map({"position", "angle"}); });
  faults.collect([&] { goal.tol_position = node.at("position").positive(); });
  faults.collect([&] { goal.tol_angle = node.at("angle").positive(); });
  faults.raise();
}

void read_goal(const YamlNode& node, const Model& model, planning::PlanningProblem& problem) {
  node.require_map();
  if (!node.has("objects")) return read_goal_at(node, model, problem);
  node.require_map({"objects"});
  const auto entries = node.at("objects").entries();
  if (entries.empty()) node.at("objects").fail("no object", "the goal pose of one object");
  planning::Goal& goal = problem.goal;
  Eigen::VectorXd q = problem.q_start;
  std::vector<int> named;
  planning::GoalRegion region = unbounded(model);
  bool several = false;
  for (const auto& [name, value] : entries) {
    const int object = named.emplace_back(find_object(value, name, model));
    const auto& info = model.objects()[static_cast<std::size_t>(object)];
    several |= is_region(value);
    if (!is_region(value)) {
      read_object_pose(value, model, object, q);
      several |= counts_turns(model, object, problem.q_start[info.q_begin], q[info.q_begin]);
    }
    read_object_region(value, model, object, region);
    if (info.n_v == 1)
      require_in_limits(value, model, object, nearest_in_limits(model, object, region.lower[info.v_begin], region.upper[info.v_begin]),
                        "goal");
  }
  goal.object = *std::max_element(named.begin(), named.end());  // what hangs on another is listed after it
  const auto chain = chain_of(model, goal.object);
  for (const int object : named) {
    if (std::find(chain.begin(), chain.end(), object) == chain.end())
      node.at("objects").fail(fmt::format("{} objects", entries.size()), "the goal pose of exactly one object, and of what it hangs on");
  }
  set_goal_at(q, problem);
  if (several) set_region(std::move(region), problem);
}

void set_goal(Task& task, std::span<const double> values) {
  core::require_finite("goal", values);
  set_goal(task, std::vector<std::optional<double>>(values.begin(), values.end()));
}

void set_goal(Task& task, const std::vector<std::optional<double>>& values) {
  const Model& model = *task.model;
  const int object = task.problem.goal.object;
  const bool free = is_free(model, object);
  const auto chain = chain_of(model, object);
  std::size_t expected = 6;
  std::string names;
  if (!free) expected = 0;
  for (const int o : chain) {
    const auto& info = model.objects()[static_cast<std::size_t>(o)];
    if (!free) expected += static_cast<std::size_t>(info.n_q);
    names += fmt::format("{}'{}'", names.empty() ? "" : " and ", info.name);
  }
  if (values.size() != expected) {
    core::throw_invalid(
        "goal", fmt::format("{} numbers", values.size()),
        free ? fmt::format("6 (x y z roll pitch yaw of {})", names) : fmt::format("{} (the coordinates of {})", expected, names));
  }
  for (const auto& value : values) {
    if (value) core::require_finite("goal", std::span(&*value, 1));
  }
  task.goal_from_command_line = true;
  task.problem.goal.region.reset();
  const int at = model.objects()[static_cast<std::size_t>(object)].q_begin;
  const bool turns = !free && values.back() && counts_turns(model, object, task.problem.q_start[at], *values.back());
  if (turns || std::any_of(values.begin(), values.end(), [](const auto& x) { return !x; })) {
    planning::GoalRegion region = unbounded(model);
    std::size_t next = 0;
    for (const int o : chain) {
      const auto& info = model.objects()[static_cast<std::size_t>(o)];
      for (int i = 0; i < info.n_v && next < values.size(); ++i, ++next) {
        if (values[next]) region.lower[info.v_begin + i] = region.upper[info.v_begin + i] = *values[next];
      }
    }
    return set_region(std::move(region), task.problem);
  }
  Eigen::VectorXd q = task.problem.q_start;
  if (free) {
    const auto& info = model.objects()[static_cast<std::size_t>(object)];
    q.segment<3>(info.q_begin) << *values[0], *values[1], *values[2];
    q.segment<4>(info.q_begin + 3) = Eigen::Quaterniond(rotation_of_rpy({*values[3], *values[4], *values[5]})).coeffs();
  } else {
    std::size_t next = 0;
    for (const int o : chain) {
      const auto& info = model.objects()[static_cast<std::size_t>(o)];
      for (int i = 0; i < info.n_q; ++i) q[info.q_begin + i] = *values[next++];
    }
  }
  set_goal_at(q, task.problem);
}

}  // namespace stiction::tasks
