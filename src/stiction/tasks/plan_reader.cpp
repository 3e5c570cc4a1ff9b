#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "stiction/core/file_fault.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/tasks/located_json.hpp"
#include "stiction/tasks/options.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/pose_numbers.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;
using Value = LocatedJson;

void read_pose_members(const Value& v, PoseNumbers& out) {
  v.at("position").numbers(3, out.data());
  v.at("quaternion_wxyz").numbers(4, out.data() + 3);
}

Eigen::VectorXd read_state(const Value& v, const PlanFile& plan) {
  Eigen::Index n_q = static_cast<Eigen::Index>(plan.joints.size());
  for (const auto& object : plan.objects) n_q += object.n_q;
  Eigen::VectorXd q(n_q);
  const Value objects = v.at("objects");
  if (objects.size() != plan.objects.size())
    objects.fail(fmt::format("{} objects", objects.size()), fmt::format("{}", plan.objects.size()));
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < plan.objects.size(); ++i) {
    const Value object = objects[i];
    const int n = plan.objects[i].n_q;
    if (plan.objects[i].joint == world::ObjectJoint::Free) {
      object.require_keys({"position", "quaternion_wxyz"});
      PoseNumbers p;
      read_pose_members(object, p);
      q.segment(at, 7) << p[0], p[1], p[2], p[4], p[5], p[6], p[3];
    } else {
      object.require_keys({"coordinates"});
      q.segment(at, n) = object.at("coordinates").vector(static_cast<std::size_t>(n));
    }
    at += n;
  }
  q.tail(static_cast<Eigen::Index>(plan.joints.size())) = v.at("joints").vector(plan.joints.size());
  return q;
}

StoredContact read_contact(const Value& v, const PlanFile& plan) {
  v.require_keys({"a", "b", "point", "normal", "force", "friction", "gap"}, {"moment"});
  const long last = static_cast<long>(plan.geometries.size()) - 1;
  return {.a = static_cast<int>(v.at("a").integer(0, last)),
          .b = static_cast<int>(v.at("b").integer(0, last)),
          .point_W = v.at("point").vector3(),
          .normal_W = v.at("normal").vector3(),
          .force_W = v.at("force").vector3(),
          .friction = v.at("friction").nonnegative(),
          .gap = v.at("gap").number(),
          .moment = v.has("moment") ? v.at("moment").number() : 0};
}

StoredKnot read_knot(const Value& v, const PlanFile& plan, std::size_t n_moving) {
  v.require_keys({"u", "joints", "objects", "bodies", "contacts"});
  StoredKnot knot;
  knot.u = v.at("u").vector(plan.joints.size());
  knot.q = read_state(v, plan);
  const Value bodies = v.at("bodies");
  if (bodies.size() != n_moving) bodies.fail(fmt::format("{} poses", bodies.size()), fmt::format("{}", n_moving));
  bodies.each([&](const Value& pose) { pose.numbers(7, knot.bodies.emplace_back().data()); });
  v.at("contacts").each([&](const Value& contact) { knot.contacts.push_back(read_contact(contact, plan)); });
  return knot;
}

world::Shape read_shape(const Value& v) {
  const std::string& type = v.at("type").string();
  if (type == "sphere") {
    v.require_keys({"type", "radius"});
    return world::Sphere{v.at("radius").positive()};
  }
  if (type == "capsule" || type == "cylinder") {
    v.require_keys({"type", "radius", "half_length"});
    const double radius = v.at("radius").positive();
    const double half_length = v.at("half_length").nonnegative();
    if (type == "capsule") return world::Capsule{radius, half_length};
    return world::Cylinder{radius, half_length};
  }
  if (type == "box") {
    v.require_keys({"type", "half_extents"});
    return world::Box{v.at("half_extents").vector3()};
  }
  if (type == "half_space") {
    v.require_keys({"type"});
    return world::HalfSpace{};
  }
  if (type == "mesh") {
    v.require_keys({"type", "vertices", "triangles"});
    auto mesh = std::make_shared<world::ConvexMesh>();
    const Value vertices = v.at("vertices");
    const Value triangles = v.at("triangles");
    const auto n = static_cast<Eigen::Index>(vertices.size());
    mesh->vertices.resize(3, n);
    for (Eigen::Index i = 0; i < n; ++i) mesh->vertices.col(i) = vertices[static_cast<std::size_t>(i)].vector3();
    mesh->triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      const Value triangle = triangles[i];
      if (triangle.size() != 3) triangle.fail("3 indices");
      for (std::size_t k = 0; k < 3; ++k) {
        mesh->triangles(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(i)) = static_cast<int>(triangle[k].integer(0, n - 1));
      }
    }
    return world::Mesh{std::move(mesh)};
  }
  v.at("type").fail("one of sphere, capsule, box, cylinder, half_space, mesh");
}

dynamics::StepOptions read_step(const Value& v) {
  dynamics::StepOptions out;
  v.require_keys({"h", "regularisation", "friction_scale", "contact_margin", "joint_limits", "tol_complementarity"},
                 {"friction_law", "effort_limits"});  // plans of earlier versions have none of these
  if (v.has("friction_law")) out.friction_law = static_cast<dynamics::FrictionLaw>(v.at("friction_law").one_of(kFrictionLawNames));
  if (v.has("effort_limits")) out.effort_limits = v.at("effort_limits").boolean();
  out.h = v.at("h").positive();
  const Value regularisation = v.at("regularisation");
  if (regularisation.has("ratio")) {
    regularisation.require_keys({"ratio"});
    out.regularisation = dynamics::ByRule{regularisation.at("ratio").positive()};
  } else {
    regularisation.require_keys({"epsilon"});
    out.regularisation = dynamics::FixedEpsilon{regularisation.at("epsilon").positive()};
  }
  out.friction_scale = v.at("friction_scale").nonnegative();
  out.contact_margin = v.at("contact_margin").nonnegative();
  out.joint_limits = v.at("joint_limits").boolean();
  out.tol_complementarity = v.at("tol_complementarity").positive();
  return out;
}

void read_statistics(const Value& v, PlanFile& out) {
  v.require_keys(
      {"iterations", "nodes", "steps", "linearisations", "failed_steps", "distrusted", "regrasps", "start_penetration", "start_projected"});
  out.iterations = v.at("iterations").integer();
  out.nodes = v.at("nodes").integer();
  out.steps = v.at("steps").integer();
  out.linearisations = v.at("linearisations").integer();
  out.failed_steps = v.at("failed_steps").integer();
  out.distrusted = v.at("distrusted").integer();
  const Value regrasps = v.at("regrasps");
  regrasps.require_keys({"tried", "accepted", "no_sample", "no_path", "object_moved", "failed_step"});
  out.regrasps.tried = regrasps.at("tried").integer();
  out.regrasps.accepted = regrasps.at("accepted").integer();
  out.regrasps.no_sample = regrasps.at("no_sample").integer();
  out.regrasps.no_path = regrasps.at("no_path").integer();
  out.regrasps.object_moved = regrasps.at("object_moved").integer();
  out.regrasps.failed_step = regrasps.at("failed_step").integer();
  out.start_penetration = v.at("start_penetration").nonnegative();
  out.start_projected = v.at("start_projected").boolean();
}

void read_head(const Value& top, PlanFile& out) {
  out.code_version = top.at("code_version").string();
  const Value task = top.at("task");
  const bool in_memory = task.has("text");
  in_memory ? task.require_keys({"name", "builtin", "file", "text"}) : task.require_keys({"name", "builtin", "file"});
  out.task_name = task.at("name").string();
  out.task_builtin = task.at("builtin").boolean();
  out.task_file = task.at("file").string();
  if (in_memory) out.task_text = task.at("text").string();
  out.scene_sha256 = top.at("scene_sha256").string();
  out.scene_text = top.at("scene_text").string();
  if (const std::string actual = core::sha256(out.scene_text); actual != out.scene_sha256) {
    top.at("scene_sha256").fail(fmt::format("'{}'", out.scene_sha256), fmt::format("'{}', the SHA-256 of scene_text", actual));
  }
  constexpr std::array kStatuses = {core::Status::Solved, core::Status::MaxIterations, core::Status::Cancelled, core::Status::Infeasible,
                                    core::Status::NumericalFailure};
  const Value status = top.at("status");
  bool known = false;
  for (const auto candidate : kStatuses) {
    if (core::to_string(candidate) == status.string()) out.status = candidate, known = true;
  }
  if (!known) status.fail("Solved, MaxIterations or Cancelled");
  out.seed = top.at("seed").seed();
  read_statistics(top.at("statistics"), out);
  const Value timing = top.at("timing");
  timing.require_keys({"wall_s", "threads", "created"});
  out.wall_s = timing.at("wall_s").nonnegative();
  out.threads = static_cast<int>(timing.at("threads").integer(0, 1 << 20));
  out.created = timing.at("created").string();
  out.step = read_step(top.at("step"));
  if (const Value substep = top.at("substep"); !substep.is_null()) {
    substep.require_keys({"joint_angle", "joint_travel", "slide", "max_substeps"});
    out.substep = {.joint_angle = substep.at("joint_angle").positive(),
                   .joint_travel = substep.at("joint_travel").positive(),
                   .slide = substep.at("slide").positive(),
                   .max_substeps = static_cast<int>(substep.at("max_substeps").integer(1, std::numeric_limits<int>::max()))};
  }
}

void read_scene(const Value& top, PlanFile& out) {
  top.at("joints").each([&](const Value& name) { out.joints.push_back(name.string()); });
  // The number of coordinates of an object that is not free follows from its joint.
  constexpr std::array<int, 6> kSizes = {7, 3, 3, 3, 1, 1};
  top.at("objects").each([&](const Value& v) {
    v.require_keys({"name", "joint"});
    const std::size_t joint = v.at("joint").one_of(kObjectJointNames);
    out.objects.push_back({v.at("name").string(), static_cast<world::ObjectJoint>(joint), kSizes[joint]});
  });
  top.at("bodies").each([&](const Value& v) {
    StoredBody& body = out.bodies.emplace_back();
    if (v.at("moving").boolean()) {
      v.require_keys({"name", "kind", "moving"});
    } else {
      v.require_keys({"name", "kind", "moving", "position", "quaternion_wxyz"});
      read_pose_members(v, body.fixed_pose.emplace());
    }
    body.name = v.at("name").string();
    body.kind = static_cast<world::BodyKind>(v.at("kind").one_of(kBodyKindNames));
  });
  top.at("geometries").each([&](const Value& v) {
    v.require_keys({"name", "body", "shape", "position", "quaternion_wxyz", "friction"});
    StoredGeometry& geometry = out.geometries.emplace_back();
    geometry.name = v.at("name").string();
    geometry.body = static_cast<int>(v.at("body").integer(0, static_cast<long>(out.bodies.size()) - 1));
    geometry.shape = read_shape(v.at("shape"));
    read_pose_members(v, geometry.X_BG);
    geometry.friction = v.at("friction").nonnegative();
  });
}

planning::GoalRegion read_region(const Value& region, const PlanFile& plan) {
  region.require_keys({"lower", "upper"});
  std::size_t n = 0;
  for (const auto& object : plan.objects) n += object.n_q == 7 ? 6 : static_cast<std::size_t>(object.n_q);
  planning::GoalRegion out{region.at("lower").bounds(n, -1), region.at("upper").bounds(n, 1)};
  if (!(out.lower.array() <= out.upper.array()).all()) region.fail("lower ≤ upper");
  return out;
}

planning::Bystanders read_bystanders(const Value& node, const PlanFile& plan) {
  node.require_keys({"objects"}, {"may_move", "may_tip"});
  const double infinity = std::numeric_limits<double>::infinity();
  planning::Bystanders out;
  out.may_move = node.has("may_move") ? node.at("may_move").positive() : infinity;
  out.may_tip = node.has("may_tip") ? node.at("may_tip").positive() : infinity;
  int n_q = 0;
  for (const auto& object : plan.objects) n_q += object.n_q;
  out.q_u = plan.q_start.head(n_q);
  node.at("objects").each([&](const Value& name) {
    const auto found = std::ranges::find(plan.objects, name.string(), &StoredObject::name);
    if (found == plan.objects.end()) name.fail("the name of an object");
    out.objects.push_back(static_cast<int>(found - plan.objects.begin()));
  });
  return out;
}

/// Start and goal: of the task, or given in its place.
bool is_of_command_line(const Value& from) { return from.one_of(std::array<std::string_view, 2>{"task", "command_line"}) == 1; }

void read_goal(const Value& top, PlanFile& out) {
  const Value goal = top.at("goal");
  goal.require_keys({"object", "position", "quaternion_wxyz", "tolerance", "from"}, {"region", "bystanders"});
  if (goal.has("region")) out.region = read_region(goal.at("region"), out);
  if (goal.has("bystanders")) out.bystanders = read_bystanders(goal.at("bystanders"), out);
  out.goal_object = goal.at("object").string();
  if (std::none_of(out.objects.begin(), out.objects.end(), [&](const auto& object) { return object.name == out.goal_object; })) {
    goal.at("object").fail("the name of an object");
  }
  read_pose_members(goal, out.goal_pose);
  const double norm = std::hypot(std::hypot(out.goal_pose[3], out.goal_pose[4]), std::hypot(out.goal_pose[5], out.goal_pose[6]));
  if (std::abs(norm - 1) > 1e-6) goal.at("quaternion_wxyz").fail(fmt::format("norm {:.9g}", norm), "a unit quaternion");
  const Value tolerance = goal.at("tolerance");
  tolerance.require_keys({"position", "angle"});
  out.tol_position = tolerance.at("position").positive();
  out.tol_angle = tolerance.at("angle").positive();
  out.goal_from_command_line = is_of_command_line(goal.at("from"));
  const Value error = top.at("error");
  error.require_keys({"position", "angle"});
  out.error = {error.at("position").nonnegative(), error.at("angle").nonnegative()};
}

PlanFile read(const Value& top) {
  if (!top.node().is_object()) top.fail("an object");
  if (top.at("format").string() != kPlanFormat) top.at("format").fail(fmt::format("\"{}\"", kPlanFormat));
  if (const Value version = top.at("format_version"); version.integer() != kPlanFormatVersion) {
    version.fail(fmt::format("{}, the only version this program reads", kPlanFormatVersion));
  }
  top.require_keys({"format",     "format_version", "code_version", "task",  "scene_sha256", "scene_text", "status",  "seed",
                    "options",    "statistics",     "timing",       "step",  "substep",      "joints",     "objects", "bodies",
                    "geometries", "start",          "goal",         "error", "segments",     "tree"},
                   {"sha256", "options_from"});
  PlanFile out;
  read_head(top, out);
  if (!top.at("options").node().is_object()) top.at("options").fail("an object");
  out.options_from_command_line = top.has("options_from") && is_of_command_line(top.at("options_from"));
  read_scene(top, out);
  const Value start = top.at("start");
  start.require_keys({"u", "joints", "objects"}, {"from"});
  out.start_from_command_line = start.has("from") && is_of_command_line(start.at("from"));
  out.u_start = start.at("u").vector(out.joints.size());
  out.q_start = read_state(start, out);
  read_goal(top, out);
  const auto n_moving =
      static_cast<std::size_t>(std::count_if(out.bodies.begin(), out.bodies.end(), [](const auto& b) { return !b.fixed_pose; }));
  top.at("segments").each([&](const Value& v) {
    v.require_keys({"kind", "knots"});
    StoredSegment& segment = out.segments.emplace_back();
    segment.kind = static_cast<planning::SegmentKind>(v.at("kind").one_of(kSegmentKindNames));
    v.at("knots").each([&](const Value& knot) { segment.knots.push_back(read_knot(knot, out, n_moving)); });
  });
  top.at("tree").each([&](const Value& v) {
    v.require_keys({"parent", "edge", "object"});
    const auto before = static_cast<long>(out.tree.size()) - 1;
    StoredTreeNode& node = out.tree.emplace_back();
    node.parent = static_cast<int>(v.at("parent").integer(-1, before));
    node.edge = static_cast<planning::SegmentKind>(v.at("edge").one_of(kSegmentKindNames));
    const Eigen::VectorXd numbers = v.at("object").vector(7);
    std::copy_n(numbers.data(), 7, node.object.begin());
  });
  if (top.has("sha256")) out.sha256 = top.at("sha256").string();
  return out;
}

}  // namespace

PlanFile parse_plan(const std::string& text, const fs::path& file) {
  const std::string name = file.string();
  json root;
  try {
    root = json::parse(text);
  } catch (const json::exception& e) {
    if (file.extension() == ".yaml" || file.extension() == ".yml")
      core::throw_invalid(name + ": file", "a YAML file", "a plan file (plan.json), as `stiction plan` writes it from a task");
    core::throw_invalid(name + ": file", fmt::format("something that is not JSON, or only part of it ({})", e.what()), "a plan file");
  }
  PlanFile out = read(Value(root, name, nullptr, {}, -1));
  out.options = root["options"].dump();
  return out;
}

PlanFile read_plan(const fs::path& path) {
  const fs::path file = fs::is_directory(path) ? path / "plan.json" : path;
  return parse_plan(core::read_file(file, "a plan file"), file);
}

}  // namespace stiction::tasks
