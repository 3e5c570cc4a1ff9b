#include "stiction/tasks/plan_file.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include <nlohmann/json.hpp>
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/version.hpp"
#include "stiction/tasks/options.hpp"
#include "stiction/tasks/pose_numbers.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;

/// Largest number of stored tree nodes; enough to show how the tree grew.
constexpr std::size_t kShownNodes = 2000;

PoseNumbers rounded(const PoseNumbers& in, double unit) {
  PoseNumbers out;
  for (std::size_t i = 0; i < in.size(); ++i) out[i] = std::round(in[i] / unit) * unit + 0.0;
  return out;
}

std::string now_utc() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

/// Bodies with geometry, in the order of the model, and the index of each body in that list (−1: no geometry).
struct ShownBodies {
  std::vector<int> bodies;
  std::vector<int> place;
  explicit ShownBodies(const world::Model& model) : place(model.bodies().size(), -1) {
    for (const auto& geometry : model.geometries()) place[static_cast<std::size_t>(geometry.body)] = 0;
    for (std::size_t i = 0; i < place.size(); ++i) {
      if (place[i] < 0) continue;
      place[i] = static_cast<int>(bodies.size());
      bodies.push_back(static_cast<int>(i));
    }
  }
};

StoredContact stored(const world::Model& model, const dynamics::ContactImpulse& impulse, double h) {
  const auto& contact = impulse.contact;
  const auto& pair = model.pairs()[static_cast<std::size_t>(contact.pair)];
  const Eigen::Vector3d& l = impulse.lambda;
  return {.a = pair.geometry_a,
          .b = pair.geometry_b,
          .point_W = contact.p_WB,
          .normal_W = contact.nhat_BA_W,
          .force_W = (contact.nhat_BA_W * l[0] + contact.t1_W * l[1] + contact.t2_W * l[2]) / h,
          .friction = contact.friction,
          .gap = contact.phi,
          .moment = contact.spin * l[2] / h};
}

/// Adds a contact to a list. The two rows of a contact that resists turning (S.26) become one.
void add_contact(const world::Model& model, const dynamics::ContactImpulse& impulse, double h, std::vector<StoredContact>& out) {
  const StoredContact contact = stored(model, impulse, h);
  const auto twin = impulse.contact.spin == 0 ? out.end() : std::ranges::find_if(out, [&](const StoredContact& c) {
    return c.a == contact.a && c.b == contact.b && c.point_W == contact.point_W;
  });
  if (twin == out.end()) {
    out.push_back(contact);
  } else {
    twin->force_W += contact.force_W;
    twin->moment += contact.moment;
  }
}

void add_scene(const world::Model& model, const ShownBodies& shown, const world::Kinematics& start, PlanFile& out) {
  for (int j = 0; j < model.n_a(); ++j) out.joints.push_back(model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name);
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    out.objects.push_back({model.objects()[i].name, model.scene().objects[i].joint, model.objects()[i].n_q});
  }
  for (const int b : shown.bodies) {
    const auto& body = model.bodies()[static_cast<std::size_t>(b)];
    StoredBody& entry = out.bodies.emplace_back();
    entry.name = body.name;
    entry.kind = body.kind;
    if (body.dofs.empty()) entry.fixed_pose = rounded(to_numbers(start.X_WB[static_cast<std::size_t>(b)]), 1e-9);
  }
  for (const auto& geometry : model.geometries()) {
    out.geometries.push_back({geometry.name, shown.place[static_cast<std::size_t>(geometry.body)], geometry.shape,
                              rounded(to_numbers(geometry.X_BG), 1e-9), geometry.friction});
  }
}

/// Thins the tree evenly to at most kShownNodes nodes. The parent of a node becomes its nearest kept ancestor.
void add_tree(const std::vector<planning::TreeNode>& tree, PlanFile& out) {
  const std::size_t stride = (tree.size() + kShownNodes - 1) / kShownNodes;
  std::vector<int> kept(tree.size());  // of each node, itself or the nearest kept ancestor
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const planning::TreeNode& node = tree[i];
    const int parent = node.parent < 0 ? -1 : kept[static_cast<std::size_t>(node.parent)];
    kept[i] = parent;
    if (i % stride != 0) continue;
    kept[i] = static_cast<int>(out.tree.size());
    out.tree.push_back({parent, node.edge, to_numbers(node.X_WB)});
  }
}

/// For a goal region: the goal in it that is nearest to the end of the plan.
world::Pose goal_pose(const world::Model& model, const planning::Plan& plan) {
  if (!plan.goal.region) return plan.goal.X_WG;
  Eigen::VectorXd q = plan.segments.empty() ? plan.q_start : plan.segments.back().knots.back().q;
  planning::project(model, *plan.goal.region, q.head(model.n_qu()));
  return world::object_pose(model, q, plan.goal.object);
}

}  // namespace

std::string spell_task_file(const Task& task, const fs::path& file) {
  if (task.builtin) return task.file.filename().generic_string();
  return fs::weakly_canonical(task.file).lexically_proximate(fs::weakly_canonical(file).parent_path()).generic_string();
}

namespace {

/// The plan of a search; only the start if the search could not make its first step.
planning::Plan plan_of(const Task& task, const planning::PlannerOptions& options, const planning::PlanResult& result) {
  planning::Plan out = result.plan;
  if (out.q_start.size() > 0) return out;
  out.q_start = task.problem.q_start;
  out.u_start = out.q_start.tail(task.model->n_a());
  out.goal = task.problem.goal;
  out.step = options.step_options(*task.model);
  out.error = planning::goal_error(*task.model, out.q_start, out.goal);
  return out;
}

void add_task(const Task& task, const fs::path& file, PlanFile& out) {
  out.task_name = task.name;
  out.task_text = task.text;
  out.task_builtin = task.builtin;
  out.task_file = spell_task_file(task, file);
  out.scene_sha256 = task.scene_sha256;
  out.scene_text = task.scene_text;
  out.start_from_command_line = task.start_from_command_line;
  out.goal_from_command_line = task.goal_from_command_line;
  out.options_from_command_line = task.options_from_command_line;
}

/// The figures of the search, without its plan.
void add_search(const planning::PlanResult& result, PlanFile& out) {
  out.status = result.status;
  out.seed = result.seed;
  out.iterations = result.iterations;
  out.nodes = result.nodes;
  out.steps = result.steps;
  out.linearisations = result.linearisations;
  out.failed_steps = result.failed_steps;
  out.distrusted = result.distrusted;
  out.regrasps = result.regrasps;
  out.start_penetration = result.start_penetration;
  out.start_projected = result.start_projected;
  out.wall_s = result.wall_s;
}

void add_goal(const world::Model& model, const planning::Plan& plan, PlanFile& out) {
  out.goal_object = model.objects()[static_cast<std::size_t>(plan.goal.object)].name;
  out.goal_pose = rounded(to_numbers(goal_pose(model, plan)), 1e-12);
  out.tol_position = plan.goal.tol_position;
  out.tol_angle = plan.goal.tol_angle;
  out.region = plan.goal.region;
  out.bystanders = plan.goal.bystanders;
  out.error = plan.error;
}

StoredKnot stored(const world::Model& model, const dynamics::Knot& knot, const ShownBodies& shown, const world::Kinematics& kinematics,
                  double h) {
  StoredKnot out;
  out.u = knot.u;
  out.q = knot.q;
  for (const int b : shown.bodies) {
    if (model.bodies()[static_cast<std::size_t>(b)].dofs.empty()) continue;
    out.bodies.push_back(to_numbers(kinematics.X_WB[static_cast<std::size_t>(b)]));
  }
  for (const auto& contact : knot.contacts) add_contact(model, contact, h, out.contacts);
  return out;
}

}  // namespace

PlanFile make_plan_file(const Task& task, const planning::PlannerOptions& options, const planning::PlanResult& result,
                        const fs::path& file) {
  const world::Model& model = *task.model;
  const planning::Plan plan = plan_of(task, options, result);
  PlanFile out;
  add_task(task, file, out);
  add_search(result, out);
  out.options = planner_options_json(options, model);
  out.threads = options.threads;
  out.code_version = core::version();
  out.created = now_utc();
  out.step = plan.step;
  if (!options.thesis) out.substep = plan.substep;

  const ShownBodies shown(model);
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  calc_kinematics(model, plan.q_start, work, kinematics);
  add_scene(model, shown, kinematics, out);
  add_goal(model, plan, out);
  out.q_start = plan.q_start;
  out.u_start = plan.u_start;
  for (const auto& segment : plan.segments) {
    StoredSegment& to = out.segments.emplace_back();
    to.kind = segment.kind;
    for (const auto& knot : segment.knots) {
      calc_kinematics(model, knot.q, work, kinematics);
      to.knots.push_back(stored(model, knot, shown, kinematics, plan.step.h));
    }
  }
  add_tree(result.tree, out);
  out.sha256 = content_sha256(out);
  return out;
}

planning::Plan to_plan(const world::Model& model, const PlanFile& file) {
  planning::Plan plan;
  plan.q_start = file.q_start;
  plan.u_start = file.u_start;
  plan.goal = {
      model.object_index(file.goal_object), to_pose(file.goal_pose), file.tol_position, file.tol_angle, file.region, file.bystanders};
  plan.error = file.error;
  plan.step = file.step;
  if (file.substep) plan.substep = *file.substep;
  for (const auto& segment : file.segments) {
    auto& to = plan.segments.emplace_back(planning::Segment{segment.kind, {}});
    for (const auto& knot : segment.knots) to.knots.push_back({.u = knot.u, .q = knot.q, .contacts = {}});
  }
  return plan;
}

planning::PlanResult to_result(const world::Model& model, const PlanFile& file) {
  planning::PlanResult out;
  out.status = file.status;
  out.plan = to_plan(model, file);
  out.seed = file.seed;
  out.iterations = file.iterations;
  out.nodes = file.nodes;
  out.steps = file.steps;
  out.linearisations = file.linearisations;
  out.failed_steps = file.failed_steps;
  out.distrusted = file.distrusted;
  out.regrasps = file.regrasps;
  out.wall_s = file.wall_s;
  out.start_penetration = file.start_penetration;
  out.start_projected = file.start_projected;
  return out;
}

namespace {

fs::path file_of_plan(const fs::path& file) { return fs::is_directory(file) ? file / "plan.json" : file; }

[[noreturn]] void fail(const fs::path& file, std::string_view field, std::string_view got, std::string_view expected) {
  core::throw_invalid(fmt::format("{}: {}", file_of_plan(file).string(), field), got, expected);
}

}  // namespace

planning::PlannerOptions options_of_plan(const world::Model& model, const PlanFile& plan, const fs::path& file) {
  // Options are spelled as in a task file, so the reader of task files judges them.
  nlohmann::ordered_json options = nlohmann::ordered_json::parse(plan.options);
  options.erase("advanced");  // of files before 0.3.0; what followed from them is in `step` and `substep`
  if (!plan.substep && !options.contains("thesis")) options["thesis"] = nlohmann::ordered_json::object();
  const auto text = world::YamlNode::parse(fmt::format("{{\"options\": {}}}", options.dump()), file_of_plan(file));
  planning::PlannerOptions out = read_planner_options(text.at("options"), model);
  out.seed = plan.seed;
  out.threads = plan.threads;
  return out;
}

void require_same_scene(const PlanFile& plan, const Task& task, const fs::path& file) {
  const world::Model& model = *task.model;
  if (plan.scene_sha256 != task.scene_sha256) {
    fail(file, "scene_sha256", plan.scene_sha256.substr(0, 12) + "…",
         fmt::format("{}… (the scene of task '{}' as it is now, {})", task.scene_sha256.substr(0, 12), task.name, task.file.string()));
  }
  // The same scene has the same names and sizes: these are left to catch a file that was edited.
  if (static_cast<int>(plan.joints.size()) != model.n_a())
    fail(file, "joints", fmt::format("{} names", plan.joints.size()), fmt::format("{}", model.n_a()));
  for (int j = 0; j < model.n_a(); ++j) {
    const auto& name = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name;
    const auto& got = plan.joints[static_cast<std::size_t>(j)];
    if (got != name) fail(file, fmt::format("joints[{}]", j), fmt::format("'{}'", got), fmt::format("'{}'", name));
  }
  if (plan.objects.size() != model.objects().size()) {
    fail(file, "objects", fmt::format("{} objects", plan.objects.size()), fmt::format("{}", model.objects().size()));
  }
  for (std::size_t i = 0; i < plan.objects.size(); ++i) {
    const auto& object = model.objects()[i];
    if (plan.objects[i].name != object.name || plan.objects[i].joint != model.scene().objects[i].joint ||
        plan.objects[i].n_q != object.n_q) {
      fail(file, fmt::format("objects[{}]", i), fmt::format("'{}' with {} numbers", plan.objects[i].name, plan.objects[i].n_q),
           fmt::format("'{}' with {} numbers", object.name, object.n_q));
    }
  }
  (void)options_of_plan(model, plan, file);
  const auto shown = ShownBodies(model);
  PlanFile expected;
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  calc_kinematics(model, model.neutral(), work, kinematics);
  add_scene(model, shown, kinematics, expected);
  if (plan.bodies.size() != shown.bodies.size())
    fail(file, "bodies", fmt::format("{} bodies", plan.bodies.size()), fmt::format("{}", shown.bodies.size()));
  for (std::size_t i = 0; i < plan.bodies.size(); ++i) {
    const auto& body = model.bodies()[static_cast<std::size_t>(shown.bodies[i])];
    if (plan.bodies[i].name != body.name || plan.bodies[i].kind != body.kind ||
        plan.bodies[i].fixed_pose.has_value() != body.dofs.empty()) {
      fail(file, fmt::format("bodies[{}]", i), fmt::format("'{}'", plan.bodies[i].name), fmt::format("'{}'", body.name));
    }
    if (to_text(plan.bodies[i]) != to_text(expected.bodies[i]))
      fail(file, fmt::format("bodies[{}]", i), fmt::format("'{}' in another place", body.name), "its place in the scene");
  }
  if (plan.geometries.size() != model.geometries().size()) {
    fail(file, "geometries", fmt::format("{} geometries", plan.geometries.size()), fmt::format("{}", model.geometries().size()));
  }
  for (std::size_t i = 0; i < plan.geometries.size(); ++i) {
    const auto& geometry = model.geometries()[i];
    if (plan.geometries[i].name != geometry.name || plan.geometries[i].body != shown.place[static_cast<std::size_t>(geometry.body)]) {
      fail(file, fmt::format("geometries[{}]", i), fmt::format("'{}'", plan.geometries[i].name), fmt::format("'{}'", geometry.name));
    }
    if (to_text(plan.geometries[i]) != to_text(expected.geometries[i]))
      fail(file, fmt::format("geometries[{}]", i), fmt::format("another shape, pose or friction of '{}'", geometry.name),
           "those of the scene");
  }
}

Task load_task_of_plan(const PlanFile& plan, const fs::path& file, std::span<const fs::path> data_dirs) {
  Task task;
  if (plan.task_builtin) {
    const fs::path name(plan.task_file);
    const auto known = list_tasks(data_dirs);
    if (name.extension() != ".yaml" || name != name.filename() ||
        std::find(known.begin(), known.end(), name.stem().string()) == known.end()) {
      fail(file, "task.file", fmt::format("'{}'", plan.task_file), "the file name of a built-in task");
    }
    task = load_task(name.stem().string(), data_dirs);
  } else {
    const fs::path path = (fs::absolute(file_of_plan(file)).parent_path() / plan.task_file).lexically_normal();
    if (!plan.task_text.empty()) {
      task = parse_task(plan.task_text, path);
      require_same_scene(plan, task, file);
      return task;
    }
    if (!fs::is_regular_file(path)) {
      fail(file, "task.file", fmt::format("'{}', which is not there", path.string()), "the task file that the plan was made from");
    }
    task = load_task(path.string(), data_dirs);
  }
  require_same_scene(plan, task, file);
  return task;
}

}  // namespace stiction::tasks
