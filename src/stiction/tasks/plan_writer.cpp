#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/tasks/options.hpp"
#include "stiction/tasks/plan_file.hpp"
#include "stiction/tasks/pose_numbers.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;

/// The value that a file has of a number that is only shown. + 0.0 turns −0 into 0.
double rounded(double value) { return std::round(value * 1e6) / 1e6 + 0.0; }

/// Writes JSON into a buffer; one knot per line keeps files small and diffs readable.
class Writer {
 public:
  std::string take() { return std::move(out_); }
  template <class... Args>
  void raw(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }
  void text(std::string_view value) { out_ += nlohmann::json(value).dump(); }
  void exact(double value) {
    core::require_finite("plan", value);
    raw("{}", value);
  }
  void display(double value) { exact(rounded(value)); }

  template <class Range, class Each>
  void list(const Range& values, Each&& each) {
    out_ += '[';
    bool first = true;
    for (const auto& value : values) {
      if (!first) out_ += ',';
      first = false;
      each(value);
    }
    out_ += ']';
  }
  template <class Range>
  void exact_list(const Range& values) {
    list(values, [this](double x) { exact(x); });
  }
  template <class Range>
  void display_list(const Range& values) {
    list(values, [this](double x) { display(x); });
  }

 private:
  std::string out_;
};

void write_pose_members(Writer& w, const PoseNumbers& n) {
  w.raw("\"position\":");
  w.exact_list(std::span(n).first<3>());
  w.raw(",\"quaternion_wxyz\":");
  w.exact_list(std::span(n).last<4>());
}

struct ShapeWriter {
  Writer& w;
  void operator()(const world::Sphere& s) const { w.raw(R"({{"type":"sphere","radius":{}}})", s.radius); }
  void operator()(const world::Capsule& s) const { w.raw(R"({{"type":"capsule","radius":{},"half_length":{}}})", s.radius, s.half_length); }
  void operator()(const world::Box& s) const {
    w.raw(R"({{"type":"box","half_extents":)");
    w.exact_list(s.half_extents);
    w.raw("}}");
  }
  void operator()(const world::Cylinder& s) const {
    w.raw(R"({{"type":"cylinder","radius":{},"half_length":{}}})", s.radius, s.half_length);
  }
  void operator()(const world::HalfSpace&) const { w.raw(R"({{"type":"half_space"}})"); }
  void operator()(const world::Mesh& s) const {
    w.raw(R"({{"type":"mesh","vertices":)");
    w.list(s.mesh->vertices.colwise(), [this](const auto& v) { w.display_list(v); });
    w.raw(R"(,"triangles":)");
    w.list(s.mesh->triangles.colwise(), [this](const auto& t) { w.list(t, [this](int i) { w.raw("{}", i); }); });
    w.raw("}}");
  }
};

/// The members "joints" and "objects" of a state.
void write_state(Writer& w, const PlanFile& plan, const Eigen::VectorXd& q) {
  w.raw("\"joints\":");
  w.exact_list(q.tail(static_cast<Eigen::Index>(plan.joints.size())));
  w.raw(",\"objects\":");
  Eigen::Index at = 0;
  w.list(plan.objects, [&](const StoredObject& object) {
    if (object.joint == world::ObjectJoint::Free) {
      w.raw("{{");
      write_pose_members(w, {q[at], q[at + 1], q[at + 2], q[at + 6], q[at + 3], q[at + 4], q[at + 5]});
    } else {
      w.raw("{{\"coordinates\":");
      w.exact_list(q.segment(at, object.n_q));
    }
    w.raw("}}");
    at += object.n_q;
  });
}

void write_knot(Writer& w, const PlanFile& plan, const StoredKnot& knot) {
  w.raw("{{\"u\":");
  w.exact_list(knot.u);
  w.raw(",");
  write_state(w, plan, knot.q);
  w.raw(",\"bodies\":");
  w.list(knot.bodies, [&](const PoseNumbers& pose) { w.display_list(pose); });
  w.raw(",\"contacts\":");
  w.list(knot.contacts, [&](const StoredContact& c) {
    w.raw("{{\"a\":{},\"b\":{},\"point\":", c.a, c.b);
    w.display_list(c.point_W);
    w.raw(",\"normal\":");
    w.display_list(c.normal_W);
    w.raw(",\"force\":");
    w.display_list(c.force_W);
    w.raw(",\"friction\":");
    w.display(c.friction);
    w.raw(",\"gap\":");
    w.display(c.gap);
    if (rounded(c.moment) != 0) {  // a moment that the file would have as 0 is not there when it is read
      w.raw(",\"moment\":");
      w.display(c.moment);
    }
    w.raw("}}");
  });
  w.raw("}}");
}

void write_head(Writer& w, const PlanFile& p) {
  w.raw("{{\n\"format\":\"{}\",\n\"format_version\":{},\n\"code_version\":", kPlanFormat, kPlanFormatVersion);
  w.text(p.code_version);
  w.raw(",\n\"task\":{{\"name\":");
  w.text(p.task_name);
  w.raw(",\"builtin\":{},\"file\":", p.task_builtin);
  w.text(p.task_file);
  if (!p.task_text.empty()) {
    w.raw(",\"text\":");
    w.text(p.task_text);
  }
  w.raw("}},\n\"scene_sha256\":");
  w.text(p.scene_sha256);
  w.raw(",\n\"scene_text\":");
  w.text(p.scene_text);
  w.raw(",\n\"status\":\"{}\",\n\"seed\":{},\n\"options\":{},\n", core::to_string(p.status), p.seed, p.options);
  if (p.options_from_command_line) w.raw("\"options_from\":\"command_line\",\n");
  w.raw("\"statistics\":{{\"iterations\":{},\"nodes\":{},\"steps\":{},\"linearisations\":{},\"failed_steps\":{},\"distrusted\":{},",
        p.iterations, p.nodes, p.steps, p.linearisations, p.failed_steps, p.distrusted);
  w.raw("\"regrasps\":{{\"tried\":{},\"accepted\":{},\"no_sample\":{},\"no_path\":{},\"object_moved\":{},\"failed_step\":{}}},",
        p.regrasps.tried, p.regrasps.accepted, p.regrasps.no_sample, p.regrasps.no_path, p.regrasps.object_moved, p.regrasps.failed_step);
  w.raw("\"start_penetration\":");
  w.exact(p.start_penetration);
  w.raw(",\"start_projected\":{}}},\n\"timing\":{{\"wall_s\":", p.start_projected);
  w.exact(p.wall_s);
  w.raw(",\"threads\":{},\"created\":", p.threads);
  w.text(p.created);
  w.raw("}},\n\"step\":{{\"h\":");
  w.exact(p.step.h);
  if (const auto* rule = std::get_if<dynamics::ByRule>(&p.step.regularisation)) {
    w.raw(",\"regularisation\":{{\"ratio\":{}}}", rule->ratio);
  } else {
    w.raw(",\"regularisation\":{{\"epsilon\":{}}}", std::get<dynamics::FixedEpsilon>(p.step.regularisation).epsilon);
  }
  w.raw(",\"friction_law\":\"{}\",\"friction_scale\":", kFrictionLawNames[static_cast<std::size_t>(p.step.friction_law)]);
  w.exact(p.step.friction_scale);
  w.raw(",\"contact_margin\":");
  w.exact(p.step.contact_margin);
  w.raw(",\"joint_limits\":{},\"effort_limits\":{},\"tol_complementarity\":", p.step.joint_limits, p.step.effort_limits);
  w.exact(p.step.tol_complementarity);
  w.raw("}},\n\"substep\":");
  if (p.substep) {
    w.raw("{{\"joint_angle\":{},\"joint_travel\":{},\"slide\":{},\"max_substeps\":{}}}", p.substep->joint_angle, p.substep->joint_travel,
          p.substep->slide, p.substep->max_substeps);
  } else {
    w.raw("null");
  }
}

void write_body(Writer& w, const StoredBody& body) {
  w.raw("\n{{\"name\":");
  w.text(body.name);
  w.raw(",\"kind\":\"{}\",\"moving\":{}", kBodyKindNames[static_cast<std::size_t>(body.kind)], !body.fixed_pose);
  if (body.fixed_pose) {
    w.raw(",");
    write_pose_members(w, *body.fixed_pose);
  }
  w.raw("}}");
}

void write_geometry(Writer& w, const StoredGeometry& geometry) {
  w.raw("\n{{\"name\":");
  w.text(geometry.name);
  w.raw(",\"body\":{},\"shape\":", geometry.body);
  std::visit(ShapeWriter{w}, geometry.shape);
  w.raw(",");
  write_pose_members(w, geometry.X_BG);
  w.raw(",\"friction\":");
  w.exact(geometry.friction);
  w.raw("}}");
}

void write_scene(Writer& w, const PlanFile& p) {
  w.raw(",\n\"joints\":");
  w.list(p.joints, [&](const std::string& name) { w.text(name); });
  w.raw(",\n\"objects\":");
  w.list(p.objects, [&](const StoredObject& object) {
    w.raw("{{\"name\":");
    w.text(object.name);
    w.raw(",\"joint\":\"{}\"}}", kObjectJointNames[static_cast<std::size_t>(object.joint)]);
  });
  w.raw(",\n\"bodies\":");
  w.list(p.bodies, [&](const StoredBody& body) { write_body(w, body); });
  w.raw(",\n\"geometries\":");
  w.list(p.geometries, [&](const StoredGeometry& geometry) { write_geometry(w, geometry); });
}

[[noreturn]] void cannot_write(const fs::path& path, const std::string& why) {
  core::throw_invalid("output folder " + path.string(), why, "a folder that can be written");
}

/// null where there is none.
void write_bounds(Writer& w, const Eigen::VectorXd& bounds) {
  w.list(bounds, [&](double bound) {
    if (std::isfinite(bound))
      w.exact(bound);
    else
      w.raw("null");
  });
}

void write_bystanders(Writer& w, const PlanFile& plan) {
  const planning::Bystanders& bystanders = *plan.bystanders;
  w.raw(",\"bystanders\":{{\"objects\":");
  w.list(bystanders.objects, [&](int object) { w.text(plan.objects[static_cast<std::size_t>(object)].name); });
  for (const auto& [name, most] : {std::pair("may_move", bystanders.may_move), std::pair("may_tip", bystanders.may_tip)}) {
    if (!std::isfinite(most)) continue;
    w.raw(",\"{}\":", name);
    w.exact(most);
  }
  w.raw("}}");
}

/// The file up to its digest.
std::string content(const PlanFile& plan) {
  Writer w;
  write_head(w, plan);
  write_scene(w, plan);
  w.raw(",\n\"start\":{{\"u\":");
  w.exact_list(plan.u_start);
  w.raw(",");
  write_state(w, plan, plan.q_start);
  if (plan.start_from_command_line) w.raw(",\"from\":\"command_line\"");
  w.raw("}},\n\"goal\":{{\"object\":");
  w.text(plan.goal_object);
  w.raw(",");
  write_pose_members(w, plan.goal_pose);
  w.raw(",\"tolerance\":{{\"position\":");
  w.exact(plan.tol_position);
  w.raw(",\"angle\":");
  w.exact(plan.tol_angle);
  w.raw("}}");
  if (plan.region) {
    w.raw(",\"region\":{{\"lower\":");
    write_bounds(w, plan.region->lower);
    w.raw(",\"upper\":");
    write_bounds(w, plan.region->upper);
    w.raw("}}");
  }
  if (plan.bystanders) write_bystanders(w, plan);
  w.raw(",\"from\":\"{}\"}},\n\"error\":{{\"position\":", plan.goal_from_command_line ? "command_line" : "task");
  w.exact(plan.error.position);
  w.raw(",\"angle\":");
  w.exact(plan.error.angle);
  w.raw("}},\n\"segments\":");
  w.list(plan.segments, [&](const StoredSegment& segment) {
    w.raw("\n{{\"kind\":\"{}\",\"knots\":", kSegmentKindNames[static_cast<std::size_t>(segment.kind)]);
    w.list(segment.knots, [&](const StoredKnot& knot) {
      w.raw("\n");
      write_knot(w, plan, knot);
    });
    w.raw("}}");
  });
  w.raw(",\n\"tree\":");
  w.list(plan.tree, [&](const StoredTreeNode& node) {
    w.raw("\n{{\"parent\":{},\"edge\":\"{}\",\"object\":", node.parent, kSegmentKindNames[static_cast<std::size_t>(node.edge)]);
    w.display_list(node.object);
    w.raw("}}");
  });
  return w.take();
}

}  // namespace

std::string to_text(const StoredBody& body) {
  Writer w;
  write_body(w, body);
  return w.take();
}

std::string to_text(const StoredGeometry& geometry) {
  Writer w;
  write_geometry(w, geometry);
  return w.take();
}

std::string content_sha256(const PlanFile& plan) { return core::sha256(content(plan)); }

std::string to_text(const PlanFile& plan) {
  const std::string text = content(plan);
  return fmt::format("{},\n\"sha256\":\"{}\"\n}}\n", text, core::sha256(text));
}

void require_writable(const fs::path& dir) {
  std::error_code error;
  fs::create_directories(dir, error);
  if (error) cannot_write(dir, error.message());
  const fs::path probe = dir / fmt::format(".stiction-probe-{}", ::getpid());
  std::ofstream out(probe);
  out << "x";
  out.close();
  const bool good = out.good();
  fs::remove(probe, error);
  if (!good) cannot_write(dir, "no permission or no space to write there");
}

void write_plan(const PlanFile& plan, const fs::path& file) { write_text(to_text(plan), file); }

namespace {

/// Where a file is written: a link leads to it. @throws core::InvalidInput: something else than a file is there, which renaming would remove
fs::path place_of(const fs::path& file) {
  constexpr int kMostLinks = 40;  // as Linux follows
  fs::path out = file;
  std::error_code error;
  if (const auto there = fs::status(file, error); fs::exists(there) && !fs::is_regular_file(there))  // also /dev/stdout, a link to no path
    core::throw_invalid(file.string(), fs::is_directory(there) ? "a folder" : "a device or a pipe", "a file to write");
  for (int i = 0; i < kMostLinks && fs::is_symlink(out, error); ++i) out = out.parent_path() / fs::read_symlink(out, error);
  return out;
}

}  // namespace

void write_text(const std::string& text, const fs::path& given) {
  const fs::path file = place_of(given);
  const fs::path dir = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code error;
  fs::create_directories(dir, error);
  if (error) cannot_write(dir, error.message());
  fs::path temporary = file;
  temporary += fmt::format(".tmp{}", ::getpid());
  {
    std::ofstream out(temporary, std::ios::binary);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    out.close();
    if (!out) {
      fs::remove(temporary, error);
      cannot_write(dir, "no permission or no space to write there");
    }
  }
  fs::rename(temporary, file, error);
  if (error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    cannot_write(dir, error.message());
  }
}

}  // namespace stiction::tasks
