#include "stiction/tasks/task.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <system_error>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/planning/default_options.hpp"
#include "stiction/planning/goal_measure.hpp"
#include "stiction/planning/object_space.hpp"
#include "stiction/tasks/options.hpp"
#include "stiction/tasks/scene_text.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;
using world::Model;
using world::Pose;
using world::YamlNode;

Eigen::Matrix3d rotation_of_rpy(const Eigen::Vector3d& rpy) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(rpy[2], Vector3d::UnitZ()) * AngleAxisd(rpy[1], Vector3d::UnitY()) * AngleAxisd(rpy[0], Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Quaterniond read_rotation(const YamlNode& pose) {
  const auto quaternion = pose.find("quaternion_wxyz");
  const auto rpy = pose.find("rpy");
  if (quaternion && rpy) pose.fail("both 'quaternion_wxyz' and 'rpy'", "one of the two");
  if (quaternion) {
    const Eigen::VectorXd c = quaternion->vector(4);
    if (std::abs(c.norm() - 1) > 1e-3) quaternion->fail(fmt::format("norm {:.6g}", c.norm()), "a unit quaternion");
    return Eigen::Quaterniond(c[0], c[1], c[2], c[3]).normalized();
  }
  return rpy ? Eigen::Quaterniond(rotation_of_rpy(rpy->vector3())) : Eigen::Quaterniond::Identity();
}

bool is_free(const Model& model, int object) {
  return model.scene().objects[static_cast<std::size_t>(object)].joint == world::ObjectJoint::Free;
}

/// Writes the pose of one object, as a file or a start or goal section gives it, into q.
void read_object_pose(const YamlNode& node, const Model& model, int object, Eigen::VectorXd& q) {
  const auto& info = model.objects()[static_cast<std::size_t>(object)];
  if (is_free(model, object)) {
    node.require_map({"position", "quaternion_wxyz", "rpy"});
    const Eigen::Quaterniond rotation = read_rotation(node);
    q.segment<3>(info.q_begin) = node.at("position").vector3();
    q.segment<4>(info.q_begin + 3) = rotation.coeffs();
    return;
  }
  node.require_map({"coordinates"});
  q.segment(info.q_begin, info.n_q) = node.at("coordinates").vector(info.n_q);
}

int find_object(const YamlNode& entry, const std::string& name, const Model& model) {
  std::vector<std::string> known;
  for (const auto& object : model.objects()) known.push_back(object.name);
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end()) entry.fail_unknown("object", name, known);
  return static_cast<int>(found - known.begin());
}

void read_joints(const YamlNode& node, const Model& model, Eigen::VectorXd& q) {
  const int first = model.n_q() - model.n_a();
  if (node.is_sequence()) {
    if (const auto given = static_cast<int>(node.items().size()); given != model.n_a()) {
      std::vector<std::string> names;
      for (int j = 0; j < model.n_a(); ++j) names.push_back(model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name);
      node.fail(fmt::format("{} numbers", given), fmt::format("{}, of {}", model.n_a(), fmt::join(names, ", ")));
    }
    q.tail(model.n_a()) = node.vector(model.n_a());
  } else {
    for (const auto& [name, value] : node.entries()) {
      int index = -1;
      try {
        index = model.joint_index(name);
      } catch (const core::InvalidInput& e) {
        throw core::InvalidInput(fmt::format("{}: {}", value.where(), e.what()));
      }
      q[first + index] = value.number();
    }
  }
  for (int j = 0; j < model.n_a(); ++j) {
    const double value = q[first + j];
    if (value < model.lower()[j] || value > model.upper()[j]) {
      node.fail(fmt::format("{} = {}", model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name, value),
                fmt::format("a start inside the joint limits [{}, {}]", model.lower()[j], model.upper()[j]));
    }
  }
}

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
      const Eigen::VectorXd ends = item.vector(2);
      if (ends[0] > ends[1]) item.fail("[lower, upper] with lower ≤ upper");
      lower[i] = ends[0], upper[i] = ends[1];
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

/// Of hinges and sliders.
void require_in_limits(const YamlNode& node, const Model& model, int object, double x, std::string_view what) {
  const auto& spec = model.scene().objects[static_cast<std::size_t>(object)];
  if (!spec.limits || (x >= (*spec.limits)[0] && x <= (*spec.limits)[1])) return;
  node.fail(fmt::format("{} = {}", spec.name, x),
            fmt::format("a {} inside the limits [{}, {}]", what, (*spec.limits)[0], (*spec.limits)[1]));
}

/// The number in [lower, upper] that is nearest to the range of a hinge or slider.
double nearest_in_limits(const Model& model, int object, double lower, double upper) {
  const auto& spec = model.scene().objects[static_cast<std::size_t>(object)];
  return spec.limits ? std::clamp((*spec.limits)[0], lower, upper) : lower;
}

Eigen::VectorXd read_start(const YamlNode& node, const Model& model) {
  node.require_map({"objects", "joints"});
  Eigen::VectorXd q = model.neutral();
  const YamlNode objects = node.at("objects");
  std::vector<bool> seen(model.objects().size(), false);
  for (const auto& [name, value] : objects.entries()) {
    const int object = find_object(value, name, model);
    read_object_pose(value, model, object, q);
    seen[static_cast<std::size_t>(object)] = true;
    require_in_limits(value, model, object, q[model.objects()[static_cast<std::size_t>(object)].q_begin], "start");
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) objects.fail(fmt::format("no start of object '{}'", model.objects()[i].name), "one for every object");
  }
  if (const auto joints = node.find("joints")) read_joints(*joints, model, q);
  return q;
}

/// The object and those that it hangs on, from the world outwards.
std::vector<int> chain_of(const Model& model, int object) {
  std::vector<int> chain;
  for (int o = object; o >= 0; o = model.objects()[static_cast<std::size_t>(o)].parent) chain.insert(chain.begin(), o);
  return chain;
}

void read_goal(const YamlNode& node, const YamlNode& tolerance, const Model& model, planning::PlanningProblem& problem) {
  node.require_map({"objects"});
  const auto entries = node.at("objects").entries();
  if (entries.empty()) node.at("objects").fail("no object", "the goal pose of one object");
  planning::Goal goal;
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
  tolerance.require_map({"position", "angle"});
  goal.tol_position = tolerance.at("position").positive();
  goal.tol_angle = tolerance.at("angle").positive();
  problem.goal = goal;
  set_goal_at(q, problem);
  if (several) set_region(std::move(region), problem);
}

/// @throws core::InvalidInput: no shape of a robot may touch an object
void require_touch(const YamlNode& scene, const Model& model) {
  const auto kind = [&](int geometry) {
    return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(geometry)].body)].kind;
  };
  for (const auto& pair : model.pairs()) {
    if (kind(pair.geometry_a) == world::BodyKind::Object && kind(pair.geometry_b) == world::BodyKind::Robot) return;
  }
  if (model.n_a() > 0 && !model.objects().empty())
    scene.fail("no robot has a shape that may touch an object", "a robot with collision geometry, and filters that let it touch");
}

bool names_a_file(const std::string& text) {
  return text.find('/') != std::string::npos || text.ends_with(".yaml") || text.ends_with(".yml");
}

/// The joints of the start are those of the robots at rest.
std::shared_ptr<const Model> make_model(world::Scene scene, const YamlNode& start) {
  if (const auto joints = start.find("joints"); joints && joints->is_sequence()) {
    try {
      const Eigen::VectorXd rest = joints->vector();
      scene.rest.assign(rest.begin(), rest.end());
      return Model::make(scene);
    } catch (const core::InvalidInput&) {  // what does not fit is named by read_start(), with its line
      scene.rest.clear();
    }
  }
  return Model::make(scene);
}

Task read_task(const YamlNode& root, std::string name) {
  root.require_map({"name", "description", "scene", "start", "goal", "tolerance", "planner", "optimize"});
  Task task;
  task.name = root.string_or("name", std::move(name));
  task.description = root.string_or("description", "");
  task.file = root.file();
  task.model = make_model(world::read_scene_file(root, default_package_dirs()), root.at("start"));
  const Model& model = *task.model;
  task.problem.model = task.model;
  task.problem.q_start = read_start(root.at("start"), model);
  read_goal(root.at("goal"), root.at("tolerance"), model, task.problem);
  require_touch(root.find("scene").value_or(root), model);
  task.options = planning::default_options(model, task.problem.goal.object);
  if (const auto planner = root.find("planner")) task.options = read_planner_options(*planner, model, task.options);
  if (const auto optimize = root.find("optimize")) task.optimize = read_optimize_setup(*optimize, model);
  task.scene_text = make_scene_text(model);
  task.scene_sha256 = core::sha256(task.scene_text);
  return task;
}

}  // namespace

std::vector<std::string> list_tasks(std::span<const fs::path> data_dirs) {
  std::vector<std::string> names;
  for (const auto& dir : data_dirs) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(dir, error)) {
      if (entry.is_regular_file() && entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
    }
  }
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

Task load_task(const std::string& name_or_file, std::span<const fs::path> data_dirs) {
  if (names_a_file(name_or_file)) return read_task(world::load_yaml_with_base(name_or_file), fs::path(name_or_file).stem().string());
  for (const auto& dir : data_dirs) {
    const fs::path file = dir / (name_or_file + ".yaml");
    std::error_code error;
    if (name_or_file.empty() || !fs::is_regular_file(file, error)) continue;
    Task task = read_task(world::load_yaml_with_base(file), name_or_file);
    task.builtin = true;
    return task;
  }
  const auto known = list_tasks(data_dirs);
  core::throw_invalid("task", fmt::format("'{}'", name_or_file),
                      fmt::format("a file ending in .yaml or one of {}", world::list_with_hint(name_or_file, known)));
}

Task load_task(const std::string& name_or_file) { return load_task(name_or_file, default_data_dirs()); }

Task parse_task(const std::string& text, const fs::path& folder) {
  Task task = read_task(world::parse_yaml_with_base(text, fs::absolute(folder)), "task");
  task.text = text;
  return task;
}

void set_goal(Task& task, std::span<const double> values) {
  core::require_finite("goal", values);
  set_goal(task, std::vector<std::optional<double>>(values.begin(), values.end()));
}

void set_start(Task& task, Eigen::Ref<const Eigen::VectorXd> q) {
  world::require_configuration(*task.model, "start", q);
  task.problem.q_start = q;
  task.start_from_command_line = true;
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

trajopt::OptimizeInput make_optimize_input(const Task& task) {
  if (!task.optimize) core::throw_invalid("task", fmt::format("'{}', which has no section 'optimize'", task.name), "a task with one");
  const Model& model = *task.model;
  Eigen::VectorXd goal = task.problem.q_start;
  goal.head(model.n_qu()) = planning::goal_configuration(task.problem, planning::ObjectSpace(model));
  for (const auto& object : model.objects()) {
    if (object.n_q != 3) continue;  // the angle of an object in a plane: of those that are the same pose the nearest
    const int angle = object.q_begin + 2;
    goal[angle] = planning::nearest_turn(goal[angle], task.problem.q_start[angle]);
  }
  if (task.optimize->joints_reference.size() > 0) goal.tail(model.n_a()) = task.optimize->joints_reference;
  const int T = task.optimize->horizon;
  return {task.problem.q_start, trajopt::constant_inputs(model, task.problem.q_start, T), trajopt::constant_reference(goal, T), nullptr};
}

}  // namespace stiction::tasks
