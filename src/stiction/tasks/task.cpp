#include "stiction/tasks/task.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <system_error>

#include "stiction/core/faults.hpp"
#include "stiction/core/file_fault.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/planning/goal_measure.hpp"
#include "stiction/tasks/kind_of_file.hpp"
#include "stiction/tasks/options.hpp"
#include "stiction/tasks/scene_text.hpp"
#include "stiction/tasks/task_sections.hpp"
#include "stiction/world/object_space.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;
using world::Model;
using world::YamlNode;

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

/// The start's joint positions become the rest positions of the robots.
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

/// The start, and the model again where the robots are at rest in other joints than it was made with.
Eigen::VectorXd read_start_of(std::shared_ptr<const Model>& model, const YamlNode& start, std::vector<std::string>& notes) {
  const Eigen::VectorXd q = read_start(start, *model, &notes);
  const auto joints = start.find("joints");
  if (joints && !start.has("keyframe") && !start.has("poses")) return q;
  const Eigen::VectorXd rest = q.tail(model->n_a());
  const bool at_rest = model->scene().rest.empty() ? rest == model->neutral().tail(model->n_a())
                                                   : rest == Eigen::Map<const Eigen::VectorXd>(model->scene().rest.data(), rest.size());
  if (at_rest) return q;
  world::Scene scene = model->scene();
  scene.rest.assign(rest.begin(), rest.end());
  model = Model::make(scene);
  return q;
}

/// A fault in one section does not hide faults in the next section.
Task read_task(const YamlNode& root, std::string name) {
  root.require_map();
  Task task;
  task.file = fs::absolute(root.file());  // plans name it from wherever they are written, also after a change of the working folder
  task.document = root;
  core::Faults faults;
  refuse_other_kind(root, FileKind::Task);
  faults.collect([&] {
    root.require_map({"name", "description", "scene", "start", "goal", "tolerance", "bystanders", "planner", "optimize"});
  });
  faults.collect([&] { task.name = root.string_or("name", std::move(name)); });
  faults.collect([&] { task.description = root.string_or("description", ""); });
  faults.collect([&] { read_tolerance(root.at("tolerance"), task.problem.goal); });
  if (!root.find("scene")) {
    for (const char* key : {"scene", "goal"}) faults.collect([&] { (void)root.at(key); });
    faults.raise();
  }
  const YamlNode start = root.find("start").value_or(YamlNode::parse("{}", root.file()));
  faults.collect([&] { task.model = make_model(world::read_scene_file(root, default_package_dirs()), start); });
  if (task.model == nullptr) faults.raise();
  faults.collect([&] { task.problem.q_start = read_start_of(task.model, start, task.notes); });
  const Model& model = *task.model;
  task.problem.model = task.model;
  if (task.problem.q_start.size() == 0) task.problem.q_start = model.neutral();
  faults.collect([&] { read_goal(root.at("goal"), model, task.problem); });
  faults.collect([&] {
    if (const auto bystanders = root.find("bystanders")) read_bystanders(*bystanders, model, task.problem);
  });
  faults.collect([&] { require_touch(root.at("scene"), model); });
  if (model.objects().empty()) faults.raise();  // there is none to be brought to its goal
  faults.collect([&] {
    if (const auto planner = root.find("planner")) task.options = read_planner_options(*planner, model, task.options, &task.notes);
  });
  faults.collect([&] {
    if (const auto optimize = root.find("optimize")) task.optimize = read_optimize_setup(*optimize, model);
  });
  faults.raise();
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
  std::error_code ignored;
  if (names_a_file(name_or_file) && fs::is_fifo(name_or_file, ignored))  // what came through a pipe cannot be read again
    return parse_task(core::read_file(name_or_file, "a YAML file"), fs::current_path());
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
  for (const auto& dir : data_dirs) {
    std::error_code error;
    if (!name_or_file.empty() && fs::is_regular_file(dir.parent_path() / "scenarios" / (name_or_file + ".yaml"), error))
      core::throw_invalid("task", fmt::format("'{}', which is a scenario of sense, control or touch", name_or_file),
                          fmt::format("a file ending in .yaml or one of {}", fmt::join(known, ", ")));
  }
  core::throw_invalid("task", fmt::format("'{}'", name_or_file),
                      fmt::format("a file ending in .yaml or one of {}", world::list_with_hint(name_or_file, known)));
}

Task load_task(const std::string& name_or_file) { return load_task(name_or_file, default_data_dirs()); }

Task parse_task(const std::string& text, const fs::path& folder) {
  Task task = read_task(world::parse_yaml_with_base(text, fs::absolute(folder)), "task");
  task.text = text;
  return task;
}

void set_start(Task& task, Eigen::Ref<const Eigen::VectorXd> q) {
  world::require_configuration(*task.model, "start", q);
  task.problem.q_start = q;
  if (task.problem.goal.bystanders) task.problem.goal.bystanders->q_u = q.head(task.model->n_qu());
  task.start_from_command_line = true;
}

void set_places(Task& task, const std::map<std::string, Eigen::Vector3d>& places) {
  world::Scene scene = task.model->scene();
  nlohmann::ordered_json text;
  for (const auto& [name, p_W] : places) {
    core::require_finite(fmt::format("places.{}", name), {p_W.data(), 3});
    const auto body = std::ranges::find(scene.fixed, name, &world::FixedSpec::name);
    if (body == scene.fixed.end()) core::throw_invalid("places", fmt::format("'{}'", name), "names of fixed bodies of the scene");
    body->X_WB.p = p_W;
    text[name] = {p_W.x(), p_W.y(), p_W.z()};
  }
  task.model = task.problem.model = Model::make(scene);
  task.scene_text = make_scene_text(*task.model);
  task.scene_sha256 = core::sha256(task.scene_text);
  if (!task.text.empty() || places.empty()) return;
  task.text =
      nlohmann::ordered_json{{"base", task.file.filename().generic_string()}, {"name", task.name}, {"scene", {{"places", text}}}}.dump();
  task.file = task.file.parent_path() / "";
  task.builtin = false;
}

trajopt::OptimizeInput make_optimize_input(const Task& task) {
  if (!task.optimize) core::throw_invalid("task", fmt::format("'{}', which has no section 'optimize'", task.name), "a task with one");
  const Model& model = *task.model;
  Eigen::VectorXd goal = task.problem.q_start;
  goal.head(model.n_qu()) = planning::goal_configuration(task.problem, world::ObjectSpace(model));
  for (const auto& object : model.objects()) {
    if (object.n_q != 3) continue;  // the angle of an object in a plane: of those that are the same pose the nearest
    const int angle = object.q_begin + 2;
    goal[angle] = world::nearest_turn(goal[angle], task.problem.q_start[angle]);
  }
  if (task.optimize->joints_reference.size() > 0) goal.tail(model.n_a()) = task.optimize->joints_reference;
  const int T = task.optimize->horizon;
  return {task.problem.q_start, trajopt::constant_inputs(model, task.problem.q_start, T), trajopt::constant_reference(goal, T), nullptr};
}

}  // namespace stiction::tasks
