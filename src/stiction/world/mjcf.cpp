#include "stiction/world/mjcf.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/world/call_mujoco.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/mjcf_unread.hpp"
#include "stiction/world/mjcf_view.hpp"
#include "stiction/world/scene_sections.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/simplify_hull.hpp"
#include "stiction/world/xml_reader.hpp"

namespace stiction::world {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Delete {
  void operator()(mjVFS* files) const { mj_deleteVFS(files); }
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using CompiledModel = std::unique_ptr<mjModel, Delete>;

[[noreturn]] void fail(const std::filesystem::path& file, std::string_view got, std::string_view expected) {
  throw core::InvalidInput(fmt::format("{}: mjcf: got {}, expected {}", file.string(), got, expected));
}

/// The text stands for `file`, beside which includes and meshes are found. @param name  of the file in messages
CompiledModel compile(const std::string& text, const std::filesystem::path& file, const std::filesystem::path& name) {
  mjVFS files;
  mj_defaultVFS(&files);
  const std::unique_ptr<mjVFS, Delete> cleared(&files);
  if (mj_addBufferVFS(&files, file.c_str(), text.data(), static_cast<int>(text.size())) != 0)
    fail(name, "a text that MuJoCo does not take", "an MJCF");
  char error[1024] = "";
  mjSpec* parsed = nullptr;
  auto report = call_mujoco([&] { parsed = mj_parseXML(file.c_str(), &files, error, sizeof(error)); });
  const std::unique_ptr<mjSpec, Delete> spec(parsed);
  const auto refuse = [&](std::string said) {
    std::replace(said.begin(), said.end(), '\n', ' ');
    while (said.ends_with(' ')) said.pop_back();
    fail(name, fmt::format("'{}'", said), "a file that MuJoCo compiles");
  };
  if (parsed == nullptr) refuse(report.failed ? report.error : error);
  parsed->compiler.usethread = 0;  // messages of other threads would not come back with the call
  mjModel* compiled = nullptr;
  report = call_mujoco([&] { compiled = mj_compile(parsed, &files); });
  if (compiled == nullptr) {
    const char* reason = mjs_getError(parsed);
    refuse(report.failed ? report.error : reason ? reason : "");
  }
  return CompiledModel(compiled);
}

Vector3d vector3(const mjtNum* p) { return {p[0], p[1], p[2]}; }

Pose pose(const mjtNum* position, const mjtNum* wxyz) {
  return {Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix(), vector3(position)};
}

Pose shift(const Vector3d& p) { return {Matrix3d::Identity(), p}; }

/// Reads one compiled model.
class MjcfReader : private MjcfView {
 public:
  using MjcfView::MjcfView;

  RobotContents read() {
    require_supported();
    if (const auto names = list_passed_over(); !names.empty())
      out_.robot.notes.push_back(fmt::format("passed over: {}", fmt::join(names, "; ")));
    if (const auto attributes = list_unread(*m_); !attributes.empty())
      out_.robot.notes.push_back(fmt::format("not read: {}", fmt::join(attributes, "; ")));
    find_springs();
    out_.robot.name = m_->names[0] != '\0' ? std::string(m_->names) : file_.stem().string();
    link_of_.assign(static_cast<std::size_t>(m_->nbody), -1);
    joint_of_.assign(static_cast<std::size_t>(m_->njnt), 0);
    link_of_[0] = add_link("world");
    for (int body = 1; body < m_->nbody; ++body) {  // parents first, depth first
      const int top = m_->body_weldid[body];
      if (top != 0 && is_free(top)) {
        if (top == body && object_collides(body)) read_object(body);
      } else {
        read_body(body);
      }
    }
    read_equalities();
    read_geoms(0, Pose{}, nullptr);
    hulls_.add_note(out_.robot.notes);
    for (int i = 0; i < m_->nexclude; ++i) {
      const int signature = m_->exclude_signature[i];
      const auto is_there = [&](int body) { return !is_free(m_->body_weldid[body]) || object_collides(m_->body_weldid[body]); };
      if (!is_there(signature >> 16) || !is_there(signature & 0xffff)) continue;
      out_.excludes.emplace_back(exclude_name(signature >> 16), exclude_name(signature & 0xffff));
    }
    return std::move(out_);
  }

 private:
  // ---- actuators and joints that follow others ----

  /// A position servo of gain k_p through gear g holds its joint with the stiffness k_p g². What any actuator can bear: its range of forces
  /// through the gear, or of a motor that of its commands; of a joint with a range of its own that.
  void find_springs() {
    spring_.resize(static_cast<std::size_t>(m_->njnt));
    effort_.resize(static_cast<std::size_t>(m_->njnt));
    const auto largest = [](const mjtNum* range) { return std::max(std::abs(range[0]), std::abs(range[1])); };
    for (int i = 0; i < m_->nactuator; ++i) {
      if (!is_on_joint(i)) continue;
      const mjtNum* gain = m_->actuator_gainprm + i * mjNGAIN;
      const mjtNum* bias = m_->actuator_biasprm + i * mjNBIAS;
      const auto joint = static_cast<std::size_t>(m_->actuator_trnid[2 * i]);
      const double gear = m_->actuator_gear[6 * m_->actuator_outadr[i]];
      const bool fixed_gain = m_->actuator_gaintype[i] == mjGAIN_FIXED;
      std::optional<double> force;
      if (m_->actuator_forcelimited[i])
        force = largest(m_->actuator_forcerange + 2 * i);
      else if (fixed_gain && m_->actuator_biastype[i] == mjBIAS_NONE && m_->actuator_ctrllimited[i])
        force = std::abs(gain[0]) * largest(m_->actuator_ctrlrange + 2 * i);
      if (force && *force * gear != 0) effort_[joint] = effort_[joint].value_or(0) + *force * std::abs(gear);
      const bool servo = fixed_gain && m_->actuator_biastype[i] == mjBIAS_AFFINE && gain[0] > 0 && bias[0] == 0 && bias[1] == -gain[0] &&
                         m_->actuator_dyntype[i] != mjDYN_INTEGRATOR;
      if (servo) spring_[joint] = spring_[joint].value_or(0) + gain[0] * gear * gear;
    }
    for (int j = 0; j < m_->njnt; ++j) {
      if (m_->jnt_actfrclimited[j]) effort_[static_cast<std::size_t>(j)] = largest(m_->jnt_actfrcrange + 2 * j);
    }
  }

  void read_equalities() {
    for (int i = 0; i < m_->neq; ++i) {
      if (!m_->eq_active0[i] || !couples_joints(i)) continue;
      const int joint = m_->eq_obj1id[i], leader = m_->eq_obj2id[i];
      const mjtNum* a = m_->eq_data + i * mjNEQDATA;
      const double y0 = m_->qpos0[m_->jnt_qposadr[joint]];
      RobotJoint& follower = out_.robot.joints[joint_of_[static_cast<std::size_t>(joint)]];
      if (leader < 0) {
        follower.lower = follower.upper = y0 + a[0];
        continue;
      }
      follower.leader = static_cast<int>(joint_of_[static_cast<std::size_t>(leader)]);
      follower.ratio = a[1];
      follower.offset = y0 + a[0] - a[1] * m_->qpos0[m_->jnt_qposadr[leader]];
    }
    release_placeholder_limits(out_.robot);
    try {
      resolve_followers(out_.robot);
    } catch (const core::InvalidInput& e) {
      fail(file_, fmt::format("'{}'", e.what()), "equalities without a circle");
    }
  }

  // ---- bodies ----

  int add_link(std::string name) {
    if (!link_names_.insert(name).second) fail(file_, fmt::format("the name '{}' twice", name), "each name once");
    out_.robot.links.push_back({.name = std::move(name), .collisions = {}, .inertia = std::nullopt});
    return static_cast<int>(out_.robot.links.size()) - 1;
  }

  int add_joint(RobotJoint joint, int parent, std::string link) {
    joint.parent = parent;
    joint.child = add_link(std::move(link));
    out_.robot.joints.push_back(std::move(joint));
    return out_.robot.joints.back().child;
  }

  RobotJoint make_joint(int j, const Pose& X_PB) const {
    RobotJoint joint;
    joint.name = joint_name(j);
    joint.axis = vector3(m_->jnt_axis + 3 * j);
    // MuJoCo measures from the reference value, the pose of the file.
    const double reference = m_->qpos0[m_->jnt_qposadr[j]];
    if (m_->jnt_type[j] == mjJNT_HINGE) {
      joint.kind = RobotJoint::Kind::Revolute;
      joint.X_PJ =
          X_PB * shift(vector3(m_->jnt_pos + 3 * j)) * Pose{Eigen::AngleAxisd(-reference, joint.axis).toRotationMatrix(), Vector3d::Zero()};
    } else {
      joint.kind = RobotJoint::Kind::Prismatic;
      joint.X_PJ = X_PB * shift(-reference * joint.axis);
    }
    joint.lower = m_->jnt_limited[j] ? m_->jnt_range[2 * j] : -kInfinity;
    joint.upper = m_->jnt_limited[j] ? m_->jnt_range[2 * j + 1] : kInfinity;
    joint.stiffness = spring_[static_cast<std::size_t>(j)];
    joint.effort = effort_[static_cast<std::size_t>(j)];
    joint.friction = m_->dof_frictionloss[m_->jnt_dofadr[j]];
    joint.damping = m_->dof_damping[m_->jnt_dofadr[j]];
    return joint;
  }

  /// A link per joint. The body is the last one, or is welded to it where the joint's anchor is not its origin.
  void read_body(int body) {
    const std::string name = body_name(body);
    int link = link_of_[static_cast<std::size_t>(m_->body_parentid[body])];
    Pose X_PB = pose(m_->body_pos + 3 * body, m_->body_quat + 4 * body);
    const int n = m_->body_jntnum[body];
    bool welded = true;
    for (int k = 0; k < n; ++k) {
      const int j = m_->body_jntadr[body] + k;
      const bool hinge = m_->jnt_type[j] == mjJNT_HINGE;
      const Vector3d anchor = hinge ? vector3(m_->jnt_pos + 3 * j) : Vector3d::Zero();
      welded = !(k == n - 1 && anchor.isZero(0));
      RobotJoint joint = make_joint(j, X_PB);
      const std::string moved = welded ? fmt::format("{}.{}", name, joint.name) : name;
      joint_of_[static_cast<std::size_t>(j)] = out_.robot.joints.size();
      link = add_joint(std::move(joint), link, moved);
      X_PB = shift(-anchor);
    }
    if (welded) link = add_joint({.name = fmt::format("{}.weld", name), .X_PJ = X_PB}, link, name);
    link_of_[static_cast<std::size_t>(body)] = link;
    RobotLink& made = out_.robot.links[static_cast<std::size_t>(link)];
    if (m_->body_mass[body] > 0) made.inertia = inertia_of(body);
    read_geoms(body, Pose{}, &made);
    made.only_seen = m_->body_geomnum[body] > 0 && made.collisions.empty();
  }

  BodyInertia inertia_of(int body) const {
    const Matrix3d R = pose(m_->body_ipos + 3 * body, m_->body_iquat + 4 * body).R;
    const Matrix3d moments = vector3(m_->body_inertia + 3 * body).asDiagonal();
    return {m_->body_mass[body], vector3(m_->body_ipos + 3 * body), R * moments * R.transpose()};
  }

  /// A free body with what is welded to it, in the frame of the body.
  void read_object(int body) {
    ObjectSpec object;
    object.name = body_name(body);
    std::vector<std::pair<int, Pose>> parts;  // body, pose in the free body
    for (int b = body; b < m_->nbody; ++b) {
      if (m_->body_weldid[b] != body) continue;
      Pose X;
      for (int up = b; up != body; up = m_->body_parentid[up]) X = pose(m_->body_pos + 3 * up, m_->body_quat + 4 * up) * X;
      parts.emplace_back(b, X);
    }
    Vector3d first = Vector3d::Zero();
    double weight = 0;
    for (const auto& [b, X] : parts) {
      weight += m_->body_mass[b] * std::max(0.0, 1 - m_->body_gravcomp[b]);
      object.mass += m_->body_mass[b];
      first += m_->body_mass[b] * (X * vector3(m_->body_ipos + 3 * b));
    }
    object.weight_share = weight / object.mass;
    const Vector3d center = first / object.mass;
    object.p_BCom = center;
    for (const auto& [b, X] : parts) {
      const BodyInertia part = inertia_of(b);
      const Vector3d d = X * part.p_BCom - center;
      object.inertia += X.R * part.inertia * X.R.transpose() + part.mass * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose());
      RobotLink link;
      read_geoms(b, X, &link);
      for (auto& c : link.collisions) {
        c.name = b == body ? c.name : fmt::format("{}.{}", body_name(b), c.name);
        object.geometries.push_back({c.name, c.shape, c.X_LG, *c.friction, c.mask});
      }
    }
    round_center(object);
    out_.objects.push_back(std::move(object));
  }

  // ---- geoms ----

  /// Geoms of a body that collide, posed in the link's frame by X_LB; those of the world and planes go to the fixed body.
  void read_geoms(int body, const Pose& X_LB, RobotLink* link) {
    for (int g = m_->body_geomadr[body]; g >= 0 && g < m_->body_geomadr[body] + m_->body_geomnum[body]; ++g) {
      if (!collides(g)) continue;
      RobotCollision c{.name = usable(given_name(mjOBJ_GEOM, g)),
                       .shape = read_shape(g),
                       .X_LG = X_LB * pose(m_->geom_pos + 3 * g, m_->geom_quat + 4 * g)};
      c.friction = m_->geom_friction[3 * g];
      c.mask = {static_cast<std::uint32_t>(m_->geom_contype[g]), static_cast<std::uint32_t>(m_->geom_conaffinity[g])};
      if (c.name.empty()) c.name = fmt::format("{}_{}", shape_name(c.shape), g - m_->body_geomadr[body]);
      const bool plane = m_->geom_type[g] == mjGEOM_PLANE;
      if (plane && body != 0) c.name = fmt::format("{}.{}", body_name(body), c.name);
      if (link != nullptr && !plane) {
        if (const auto* mesh = std::get_if<Mesh>(&c.shape); mesh != nullptr && !is_free(m_->body_weldid[body]))
          c.shape = simplify(*mesh->mesh, given_name(mjOBJ_MESH, m_->geom_dataid[g]));
        link->collisions.push_back(std::move(c));
        continue;
      }
      Pose X_WB;
      for (int up = body; up != 0; up = m_->body_parentid[up]) X_WB = pose(m_->body_pos + 3 * up, m_->body_quat + 4 * up) * X_WB;
      out_.fixed.push_back({c.name, c.shape, X_WB * c.X_LG, *c.friction, c.mask});
    }
  }

  Mesh simplify(const ConvexMesh& mesh, const std::string& name) {
    SimplifiedHull hull = simplify_hull_by_share(mesh, kHullTolerance);
    hulls_.add(hull.error, name);
    return {std::make_shared<const ConvexMesh>(std::move(hull.mesh))};
  }

  Shape read_shape(int g) const {
    const mjtNum* size = m_->geom_size + 3 * g;
    switch (m_->geom_type[g]) {
      case mjGEOM_PLANE:
        return HalfSpace{};
      case mjGEOM_SPHERE:
        return Sphere{size[0]};
      case mjGEOM_CAPSULE:
        return Capsule{size[0], size[1]};
      case mjGEOM_CYLINDER:
        return Cylinder{size[0], size[1]};
      case mjGEOM_BOX:
        return Box{vector3(size)};
      default:
        break;
    }
    const int mesh = m_->geom_dataid[g];
    const Eigen::Map<const Eigen::Matrix3Xf> vertices(m_->mesh_vert + 3 * m_->mesh_vertadr[mesh], 3, m_->mesh_vertnum[mesh]);
    try {
      auto hull = std::make_shared<ConvexMesh>(make_convex_hull(vertices.cast<double>()));
      hull->source = file_.string();
      return Mesh{std::move(hull)};
    } catch (const core::InvalidInput& e) {
      fail(file_, fmt::format("mesh '{}': {}", given_name(mjOBJ_MESH, mesh), e.what()), "a mesh with a convex hull");
    }
  }

  RobotContents out_{};
  std::vector<int> link_of_;                            ///< per body of the file
  std::vector<std::optional<double>> spring_, effort_;  ///< per joint of the file
  std::vector<std::size_t> joint_of_;                   ///< of the robot, per joint of the file
  std::set<std::string> link_names_;
  LinkHulls hulls_;
};

/// MuJoCo would take a URDF as well, by rules of its own.
void require_mjcf(const std::string& text, const std::filesystem::path& name) {
  tinyxml2::XMLDocument document;
  if (parse_xml(document, text, name, "mjcf") == nullptr) fail(name, "no element", "'mujoco'");
}

RobotContents read_text(const std::string& text, const std::filesystem::path& file, const std::filesystem::path& name) {
  require_mjcf(text, name);
  const CompiledModel model = compile(text, file, name);
  RobotContents out = MjcfReader(model.get(), name).read();
  out.sha256 = core::sha256(text);
  return out;
}

}  // namespace

RobotContents read_mjcf(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file)) fail(file, "a file that does not exist", "an MJCF file");
  return read_text(read_bytes(file), file, file);
}

RobotContents read_mjcf_text(const std::string& text, const std::filesystem::path& folder) {
  return read_text(text, folder / ".text.xml", kTextName);
}

void add_mjcf(Scene& scene, const RobotSpec& robot) {
  const std::shared_ptr<const RobotContents> model = contents_of(robot);
  scene.robots.push_back(robot);
  scene.robots.back().contents = model;
  const std::string fixed = robot.name + "_world";
  const auto is_object = [&](const std::string& name) {
    return std::any_of(model->objects.begin(), model->objects.end(), [&](const ObjectSpec& object) { return object.name == name; });
  };
  const auto full = [&](const std::string& body) {
    if (body == "world") return fixed;
    return is_object(body) ? body : fmt::format("{}/{}", robot.name, body);
  };
  for (const auto& [a, b] : model->excludes) {
    if ((a == "world" || b == "world") && model->fixed.empty()) continue;
    scene.filters.push_back({full(a), full(b), std::nullopt});
  }
  scene.objects.insert(scene.objects.end(), model->objects.begin(), model->objects.end());
  if (!model->fixed.empty()) scene.fixed.push_back({fixed, robot.X_WBase, model->fixed});
}

}  // namespace stiction::world
