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
#include "stiction/world/scales.hpp"

namespace stiction::tasks {
namespace {

using world::Model;
using world::YamlNode;

/// True if a goal is more than one pose: it has an interval [lower, upper], or ~ for any value.
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

/// True if the goal pose of a hinge is ambiguous by full turns: the goal is more than half a turn away, or another turn of it lies inside
/// the limits. Such a goal is a region with one coordinate, because a hinge angle is a number and 2π is not 0.
bool counts_turns(const Model& model, int object, double start, double goal) {
  const auto& spec = model.scene().objects[static_cast<std::size_t>(object)];
  if (spec.joint != world::ObjectJoint::Hinge) return false;
  constexpr double kTurn = 2 * std::numbers::pi;
  if (std::abs(goal - start) > kTurn / 2) return true;
  return spec.limits && (goal - kTurn >= (*spec.limits)[0] || goal + kTurn <= (*spec.limits)[1]);
}

/// Sets the goal region, and the goal configuration in it that is nearest to the start.
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

/// Objects named by a goal on which no other named object hangs, ascending.
std::vector<int> leaves_of(const Model& model, const std::vector<int>& named) {
  std::vector<int> out;
  for (const int o : named) {
    const auto carries = [&](int other) {
      const auto chain = planning::chain_of(model, other);
      return other != o && std::find(chain.begin(), chain.end(), o) != chain.end();
    };
    if (std::none_of(named.begin(), named.end(), carries)) out.push_back(o);
  }
  std::sort(out.begin(), out.end());
  return out;
}

/// The smallest of several objects, whose size sets the thresholds.
int smallest(const Model& model, const std::vector<int>& objects) {
  return *std::min_element(objects.begin(), objects.end(),
                           [&](int a, int b) { return model.scales().object(a).length < model.scales().object(b).length; });
}

/// The objects of a goal and all objects that they hang on, ascending: an object comes after its parent.
std::vector<int> objects_with_carriers(const Model& model, const planning::Goal& goal) {
  std::vector<int> out;
  for (const int of_goal : planning::goal_objects(model, goal)) {
    const auto chain = planning::chain_of(model, of_goal);
    out.insert(out.end(), chain.begin(), chain.end());
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
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
  const world::Pose X_WG = find_place(node.at("at"), model) * find_body_of_object(model, object).inverse();
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
  if (entries.empty()) node.at("objects").fail("no object", "the goal pose of an object");
  planning::Goal& goal = problem.goal;
  Eigen::VectorXd q = problem.q_start;
  std::vector<int> named;
  planning::GoalRegion region = unbounded(model);
  bool is_wide = false;  // more than one pose
  for (const auto& [name, value] : entries) {
    const int object = named.emplace_back(find_object(value, name, model));
    const auto& info = model.objects()[static_cast<std::size_t>(object)];
    is_wide |= is_region(value);
    if (!is_region(value)) {
      read_object_pose(value, model, object, q);
      is_wide |= counts_turns(model, object, problem.q_start[info.q_begin], q[info.q_begin]);
    }
    read_object_region(value, model, object, region);
    if (info.n_v == 1)
      require_in_limits(value, model, object, nearest_in_limits(model, object, region.lower[info.v_begin], region.upper[info.v_begin]),
                        "goal");
  }
  const std::vector<int> leaves = leaves_of(model, named);
  goal.object = smallest(model, leaves);
  set_goal_at(q, problem);
  if (is_wide || leaves.size() > 1) set_region(std::move(region), problem);
}

void set_goal(Task& task, std::span<const double> values) {
  set_goal(task, std::vector<std::optional<double>>(values.begin(), values.end()));
}

void set_goal(Task& task, const std::vector<std::optional<double>>& values) {
  const Model& model = *task.model;
  planning::Goal& goal = task.problem.goal;
  const auto leaves = planning::goal_objects(model, goal);
  const auto objects = objects_with_carriers(model, goal);
  std::size_t expected = 0;
  std::string names;
  for (const int o : objects) {
    const auto& info = model.objects()[static_cast<std::size_t>(o)];
    expected += static_cast<std::size_t>(info.n_v);
    names += fmt::format("{}'{}'", names.empty() ? "" : " and ", info.name);
  }
  if (values.size() != expected) {
    const bool any_free = std::any_of(objects.begin(), objects.end(), [&](int o) { return is_free(model, o); });
    core::throw_invalid("goal", fmt::format("{} numbers", values.size()),
                        fmt::format("{} ({}{} of {})", expected, any_free ? "x y z roll pitch yaw" : "the coordinates",
                                    any_free && objects.size() > 1 ? ", or the coordinates," : "", names));
  }
  std::vector<double> numbers;
  for (const auto& value : values) numbers.push_back(value.value_or(0));
  core::require_finite("goal", numbers);
  task.goal_from_command_line = true;
  planning::GoalRegion region = unbounded(model);
  Eigen::VectorXd q = task.problem.q_start;
  bool is_wide = leaves.size() > 1;
  std::size_t next = 0;
  for (const int o : objects) {
    const auto& info = model.objects()[static_cast<std::size_t>(o)];
    const auto given = std::span(values).subspan(next, static_cast<std::size_t>(info.n_v));
    next += given.size();
    for (std::size_t i = 0; i < given.size(); ++i) {
      const auto v = static_cast<Eigen::Index>(i);
      is_wide |= !given[i];
      if (given[i]) region.lower[info.v_begin + v] = region.upper[info.v_begin + v] = *given[i];
      if (given[i] && v < info.n_q && !(is_free(model, o) && v >= 3)) q[info.q_begin + v] = *given[i];
    }
    if (is_free(model, o) && given[3] && given[4] && given[5])
      q.segment<4>(info.q_begin + 3) = Eigen::Quaterniond(rotation_of_rpy({*given[3], *given[4], *given[5]})).coeffs();
    is_wide |= o == goal.object && given[0] && counts_turns(model, o, task.problem.q_start[info.q_begin], *given[0]);
  }
  goal.region.reset();
  if (is_wide) return set_region(std::move(region), task.problem);
  set_goal_at(q, task.problem);
}

void read_bystanders(const YamlNode& node, const Model& model, planning::PlanningProblem& problem) {
  node.require_map({"may_move", "may_tip", "objects"});
  const double infinity = std::numeric_limits<double>::infinity();
  planning::Bystanders out;
  out.q_u = problem.q_start.head(model.n_qu());
  out.may_move = node.positive_or("may_move", infinity);
  out.may_tip = node.positive_or("may_tip", infinity);
  if (!node.has("may_move") && !node.has("may_tip")) node.fail("neither 'may_move' nor 'may_tip'", "what they may do, in m or rad");
  if (node.has("may_tip") && model.scene().gravity.isZero())
    node.at("may_tip").fail("a limit in a scene without gravity", "none: nothing is upright there");
  const auto of_goal = objects_with_carriers(model, problem.goal);
  const auto is_of_goal = [&](int o) { return std::find(of_goal.begin(), of_goal.end(), o) != of_goal.end(); };
  if (const auto named = node.find("objects")) {
    for (const YamlNode& name : named->items()) {
      out.objects.push_back(find_object(name, name.string(), model));
      if (is_of_goal(out.objects.back()))
        name.fail(fmt::format("'{}', which the goal moves", name.string()), "an object that is not in the goal");
    }
    std::sort(out.objects.begin(), out.objects.end());
    out.objects.erase(std::unique(out.objects.begin(), out.objects.end()), out.objects.end());
  } else {
    for (int o = 0; o < static_cast<int>(model.objects().size()); ++o) {
      if (!is_of_goal(o)) out.objects.push_back(o);
    }
  }
  problem.goal.bystanders = std::move(out);
}

}  // namespace stiction::tasks
