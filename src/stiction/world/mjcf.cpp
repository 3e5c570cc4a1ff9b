#include "stiction/world/mjcf.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <tuple>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/mjcf_axes.hpp"
#include "stiction/world/mjcf_compile.hpp"
#include "stiction/world/mjcf_geoms.hpp"
#include "stiction/world/mjcf_motors.hpp"
#include "stiction/world/mjcf_roles.hpp"
#include "stiction/world/mjcf_unread.hpp"
#include "stiction/world/mjcf_view.hpp"
#include "stiction/world/mjcf_visuals.hpp"
#include "stiction/world/scene_sections.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/xml_reader.hpp"

namespace stiction::world {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

[[noreturn]] void fail(const std::filesystem::path& file, std::string_view got, std::string_view expected) {
  throw core::InvalidInput(fmt::format("{}: mjcf: got {}, expected {}", file.string(), got, expected));
}

Vector3d vector3(const mjtNum* p) { return {p[0], p[1], p[2]}; }

Pose pose(const mjtNum* position, const mjtNum* wxyz) {
  return {Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix(), vector3(position)};
}

Pose shift(const Vector3d& p) { return {Matrix3d::Identity(), p}; }

/// Reads one compiled model.
class MjcfReader : private MjcfView {
 public:
  MjcfReader(const mjModel* m, const MjcfRoles& roles, const std::filesystem::path& file)
      : MjcfView(m, roles, file), motors_(*this), axes_(*this), geoms_(*this) {}

  RobotContents read() {
    require_supported();
    if (const auto names = list_passed_over(motors_.couplings().meaning()); !names.empty())
      out_.robot.notes.push_back(fmt::format("passed over: {}", fmt::join(names, "; ")));
    note_balls();
    auto attributes = list_unread(*m_, [&](int j) { return roles_.of_joint(j) == MjcfRole::Robot; });
    if (roles_.by_actuators()) std::erase_if(attributes, [](const std::string& entry) { return entry.starts_with("option gravity"); });
    if (!attributes.empty()) out_.robot.notes.push_back(fmt::format("not read: {}", fmt::join(attributes, "; ")));
    for (std::string& note : motors_.notes()) out_.robot.notes.push_back(std::move(note));
    out_.robot.name = m_->names[0] != '\0' ? std::string(m_->names) : file_.stem().string();
    link_of_.assign(static_cast<std::size_t>(m_->nbody), -1);
    joint_of_.assign(static_cast<std::size_t>(m_->njnt), 0);
    link_of_[0] = add_link("world");
    for (int body = 1; body < m_->nbody; ++body) {  // parents first, depth first
      if (roles_.of_body(body) == MjcfRole::Robot)
        read_body(body);
      else if (roles_.of_body(body) == MjcfRole::Fixed)
        read_geoms(body, Pose{}, nullptr, "");
      else if (roles_.top(body) == body && object_collides(body))
        read_object(body);
    }
    read_couplings();
    read_geoms(0, Pose{}, nullptr, "");
    geoms_.add_note(out_.robot.notes);
    if (!held_.empty())
      out_.robot.notes.push_back(
          fmt::format("objects that damping alone holds have a dry friction that bears their weight: {}", list_some(held_)));
    read_excludes();
    read_contacts();
    read_configurations();
    read_places();
    list_mjcf_visuals(*m_, roles_, file_, X_OB_, out_.robot);
    out_.gravity = vector3(m_->opt.gravity);
    return std::move(out_);
  }

 private:
  void note_balls() {
    std::vector<std::string> names;
    for (int j = 0; j < m_->njnt; ++j) {
      if (is_ball(j) && roles_.moves(j)) names.push_back(joint_name(j));
    }
    if (names.empty()) return;
    out_.robot.notes.push_back(fmt::format(
        "ball joints are hinges about z, y and x; where that about y stands at ±90°, the other two turn about the same axis: {}",
        list_some(names)));
  }

  // ---- joints that follow others ----

  void read_couplings() {
    for (const MjcfCoupling& coupling : motors_.couplings().list()) {
      RobotJoint& follower = out_.robot.joints[joint_of_[static_cast<std::size_t>(coupling.joint)]];
      if (coupling.leader < 0) {
        follower.lower = follower.upper = coupling.offset;
        continue;
      }
      follower.leader = static_cast<int>(joint_of_[static_cast<std::size_t>(coupling.leader)]);
      follower.ratio = coupling.ratio;
      follower.offset = coupling.offset;
      follower.room = coupling.room;
    }
    release_placeholder_limits(out_.robot);
    try {
      resolve_followers(out_.robot);
    } catch (const core::InvalidInput& e) {
      fail(file_, fmt::format("'{}'", e.what()), "equalities without a circle");
    }
  }

  /// Reads excluded pairs as pairs of bodies, and which shapes belong to each body. MuJoCo excludes the geoms of these bodies, not those of bodies welded to them.
  void read_excludes() {
    for (int body = 0; body < m_->nbody; ++body) {
      std::vector<std::string> shapes;
      for (int g = m_->body_geomadr[body]; g >= 0 && g < m_->body_geomadr[body] + m_->body_geomnum[body]; ++g) {
        const std::string shape = geoms_.full_name(g);
        if (!shape.empty() && !is_in_link(g)) shapes.push_back(shape);
      }
      if (!shapes.empty()) out_.shapes_of.emplace_back(body_name(body), std::move(shapes));
    }
    for (int i = 0; i < m_->nexclude; ++i)
      out_.excludes.emplace_back(body_name(m_->exclude_signature[i] >> 16), body_name(m_->exclude_signature[i] & 0xffff));
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

  RobotJoint make_joint(const MjcfAxis& axis, const Pose& X_PB) const {
    const int j = axis.joint;
    RobotJoint joint;
    joint.name = axis.name;
    joint.kind = axis.turns ? RobotJoint::Kind::Revolute : RobotJoint::Kind::Prismatic;
    joint.axis = axis.direction;
    joint.X_PJ = X_PB * shift(axis.anchor) * axis.at(-axis.reference);
    joint.lower = axis.limited ? m_->jnt_range[2 * j] : -kInfinity;
    joint.upper = axis.limited ? m_->jnt_range[2 * j + 1] : kInfinity;
    if (const auto limits = motors_.couplings().limits(j)) {
      joint.lower = std::max(joint.lower, limits->first);
      joint.upper = std::min(joint.upper, limits->second);
    }
    const MjcfMotor& motor = motors_.of(axis.dof);
    if (motor.commands) std::tie(joint.command_lower, joint.command_upper) = *motor.commands;
    joint.stiffness = motor.spring;
    joint.effort = motor.effort;
    joint.friction = m_->dof_frictionloss[axis.dof];
    joint.damping = damping(axis);
    joint.motor = {m_->dof_armature[axis.dof], motor.servo_damping};
    joint.spring = motor.passive_spring;
    return joint;
  }

  /// Adds one link per joint of a body. The body is the last link, or is welded to that link if the joint's anchor is not the body's origin.
  void read_body(int body) {
    const std::string name = body_name(body);
    int link = link_of_[static_cast<std::size_t>(m_->body_parentid[body])];
    Pose X_PB = pose(m_->body_pos + 3 * body, m_->body_quat + 4 * body);
    const std::vector<MjcfAxis> axes = axes_.of(body);
    bool welded = true;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const MjcfAxis& axis = axes[k];
      welded = !(k == axes.size() - 1 && axis.anchor.isZero(0));
      RobotJoint joint = make_joint(axis, X_PB);
      const std::string moved = welded ? fmt::format("{}.{}", name, joint.name) : name;
      joint_of_[static_cast<std::size_t>(axis.joint)] = out_.robot.joints.size();
      link = add_joint(std::move(joint), link, moved);
      X_PB = shift(-axis.anchor);
    }
    if (welded) link = add_joint({.name = fmt::format("{}.weld", name), .X_PJ = X_PB}, link, name);
    link_of_[static_cast<std::size_t>(body)] = link;
    RobotLink& made = out_.robot.links[static_cast<std::size_t>(link)];
    made.inertia = inertia_of(body);  // a body of mass 0 weighs nothing, whatever shapes it has
    read_geoms(body, Pose{}, &made, name);
    made.only_seen = m_->body_geomnum[body] > 0 && made.collisions.empty();
  }

  BodyInertia inertia_of(int body) const {
    const Matrix3d R = pose(m_->body_ipos + 3 * body, m_->body_iquat + 4 * body).R;
    const Matrix3d moments = vector3(m_->body_inertia + 3 * body).asDiagonal();
    return {m_->body_mass[body], vector3(m_->body_ipos + 3 * body), R * moments * R.transpose()};
  }

  // ---- objects ----

  /// Coordinates of an object: its name and the axes of its coordinates, or the joint of a free object.
  struct ObjectCoordinates {
    std::string name;
    int free_joint = -1;
    std::vector<MjcfAxis> axes{};
  };

  /// Pose X_UB of a body B in a body U at or above it, at the pose of the file.
  Pose pose_below(int body, int above) const {
    Pose X;
    for (; body != above; body = m_->body_parentid[body]) X = pose(m_->body_pos + 3 * body, m_->body_quat + 4 * body) * X;
    return X;
  }

  /// True for two slides followed by a hinge about the axis normal to both, without properties that a planar object cannot have.
  bool is_planar(const std::vector<MjcfAxis>& axes) const {
    constexpr double kSquare = 1e-9;
    if (axes.size() != 3 || axes[0].turns || axes[1].turns || !axes[2].turns || axes[2].part >= 0) return false;
    if (axes[0].limited || axes[1].limited || axes[2].limited) return false;
    if (damping(axes[0]) != damping(axes[1]) || damping(axes[0]) != damping(axes[2])) return false;
    return std::abs(axes[0].direction.dot(axes[1].direction)) < kSquare && std::abs(axes[0].direction.dot(axes[2].direction)) < kSquare &&
           std::abs(axes[1].direction.dot(axes[2].direction)) < kSquare;
  }
  double damping(const MjcfAxis& axis) const { return m_->dof_damping[axis.dof]; }
  bool has_friction_or_spring(const MjcfAxis& axis) const {
    return m_->jnt_stiffness[axis.joint] != 0 || m_->dof_frictionloss[axis.dof] != 0;
  }

  /// Reads a body, with the bodies welded to it, as an object.
  void read_object(int body) {
    const int above = m_->body_parentid[body], carrier = roles_.is_object(above) ? roles_.top(above) : 0;
    Pose X_PB = pose_below(body, carrier);
    if (carrier != 0) X_PB = X_OB_.at(carrier) * X_PB;
    const std::string parent = carrier != 0 ? body_name(carrier) : "";
    if (const int j = roles_.joints_of(body)[0]; is_free(j)) {
      X_OB_[body] = Pose{};
      coordinates_.push_back({body_name(body), j, {}});
      ObjectSpec object = make_object(body_name(body), ObjectJoint::Free);
      object.joint_damping = m_->dof_damping[m_->jnt_dofadr[j]];
      return add_object(body, std::move(object), 1);
    }
    const std::vector<MjcfAxis> axes = axes_.of(body);
    const bool plain = std::none_of(axes.begin(), axes.end(), [&](const MjcfAxis& axis) { return has_friction_or_spring(axis); });
    if (parent.empty() && plain && is_planar(axes)) return read_planar(body, axes, X_PB);
    read_axes(body, axes, X_PB, parent);
  }

  static ObjectSpec make_object(std::string name, ObjectJoint joint) {
    ObjectSpec object;
    object.name = std::move(name);
    object.joint = joint;
    return object;
  }

  void read_planar(int body, const std::vector<MjcfAxis>& axes, const Pose& X_PB) {
    const Vector3d a = axes[0].direction, b = axes[1].direction, normal = axes[2].direction;
    const bool right = a.cross(b).dot(normal) > 0;
    ObjectSpec object = make_object(body_name(body), right ? ObjectJoint::PlanarXY : ObjectJoint::PlanarXZ);
    object.joint_damping = damping(axes[0]);
    Matrix3d R;
    if (right)
      R << a, b, normal;
    else
      R << a, normal, b;
    object.X_WP = X_PB * Pose{R, axes[2].anchor - axes[0].reference * a - axes[1].reference * b};
    const Matrix3d R_OB = R.transpose() * axes[2].at(-axes[2].reference).R;
    X_OB_[body] = {R_OB, -(R_OB * axes[2].anchor)};
    coordinates_.push_back({object.name, -1, axes});
    add_object(body, std::move(object), 1);
  }

  /// Adds one object per axis. All but the last have a millionth of the body's mass, because an object must have a mass.
  void read_axes(int body, const std::vector<MjcfAxis>& axes, Pose X_PB, std::string parent) {
    constexpr double kShare = 1e-6;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const MjcfAxis& axis = axes[k];
      const bool last = k == axes.size() - 1;
      ObjectSpec object = make_object(last ? body_name(body) : fmt::format("{}.{}", body_name(body), axis.name),
                                      axis.turns ? ObjectJoint::Hinge : ObjectJoint::Slider);
      object.parent = parent;
      object.axis = axis.direction;
      object.X_WP = X_PB * shift(axis.anchor) * axis.at(-axis.reference);
      if (axis.limited) object.limits = {m_->jnt_range[2 * axis.joint], m_->jnt_range[2 * axis.joint + 1]};
      object.joint_friction = m_->dof_frictionloss[axis.dof];
      object.joint_damping = damping(axis);
      if (has_linear_spring(axis.joint)) {
        object.joint_stiffness = m_->jnt_stiffness[axis.joint];
        object.joint_rest = m_->qpos_spring[m_->jnt_qposadr[axis.joint]];
      }
      coordinates_.push_back({object.name, -1, {axis}});
      parent = object.name;
      X_PB = shift(-axis.anchor);
      X_OB_[body] = X_PB;
      add_object(body, std::move(object), last ? 1 - kShare * static_cast<double>(axes.size() - 1) : kShare, last);
      hold_by_damping(pose_below(body, 0).R * axis.direction, out_.objects.back());
    }
  }

  /// Replaces strong damping by dry friction. If the damping lets the weight move the object more slowly than kSlow, the object practically stays
  /// where it is left. A quasi-static model has no damping, so it gets a friction that bears the weight.
  void hold_by_damping(const Vector3d& axis_W, ObjectSpec& object) {
    constexpr double kSlow = 0.02, kSpare = 1.5;  // largest speed [rad/s, m/s]; friction as a multiple of the load
    if (object.joint_damping == 0 || object.joint_friction != 0 || object.joint_stiffness != 0) return;
    const Vector3d weight = object.mass * object.weight_share * vector3(m_->opt.gravity);
    const double arm = object.axis.cross(object.p_BCom).norm();
    const double load = object.joint == ObjectJoint::Hinge ? arm * axis_W.cross(weight).norm() : std::abs(axis_W.dot(weight));
    if (load < 1e-6 * weight.norm() || load > kSlow * object.joint_damping) return;
    object.joint_friction = kSpare * load;
    held_.push_back(object.name);
  }

  /// @param share   share of the mass of the body and the bodies welded to it
  /// @param shapes  whether the object gets their shapes
  void add_object(int body, ObjectSpec object, double share, bool shapes = true) {
    const Pose& X_OB = X_OB_.at(body);
    std::vector<std::pair<int, Pose>> parts;  // body, pose in the object
    for (int b = body; b < m_->nbody; ++b) {
      if (roles_.top(b) == body) parts.emplace_back(b, X_OB * pose_below(b, body));
    }
    Vector3d first = Vector3d::Zero();
    double weight = 0, mass = 0;
    for (const auto& [b, X] : parts) {
      weight += m_->body_mass[b] * std::max(0.0, 1 - m_->body_gravcomp[b]);
      if (m_->body_gravcomp[b] > 1) out_.robot.notes.push_back(fmt::format("`gravcomp` above 1 counts as 1: {}", body_name(b)));
      mass += m_->body_mass[b];
      first += m_->body_mass[b] * (X * vector3(m_->body_ipos + 3 * b));
    }
    object.weight_share = mass > 0 ? weight / mass : 1;
    object.mass = share * mass;
    const Vector3d center = first / mass;
    object.p_BCom = center;
    for (const auto& [b, X] : parts) {
      const BodyInertia part = inertia_of(b);
      object.inertia += share * (X.R * part.inertia * X.R.transpose() + parallel_axis(part.mass, X * part.p_BCom - center));
      if (!shapes) continue;
      RobotLink link;
      read_geoms(b, X, &link, object.name);
      for (const auto& c : link.collisions) object.geometries.push_back(to_geometry(c, c.X_LG));
    }
    round_center(object);
    out_.objects.push_back(std::move(object));
  }

  // ---- where things are ----

  FileConfiguration read_configuration(std::string name, const mjtNum* qpos) const {
    FileConfiguration out{.name = std::move(name)};
    for (const ObjectCoordinates& object : coordinates_) {
      Eigen::VectorXd q(object.free_joint >= 0 ? 7 : static_cast<Eigen::Index>(object.axes.size()));
      if (object.free_joint >= 0) {
        const mjtNum* x = qpos + m_->jnt_qposadr[object.free_joint];
        q << x[0], x[1], x[2], Eigen::Quaterniond(x[3], x[4], x[5], x[6]).normalized().coeffs();
      }
      for (std::size_t i = 0; i < object.axes.size(); ++i) q[static_cast<Eigen::Index>(i)] = axes_.value(object.axes[i], qpos);
      out.objects.emplace_back(object.name, std::move(q));
    }
    for (int body = 1; body < m_->nbody; ++body) {
      if (roles_.of_body(body) != MjcfRole::Robot) continue;
      for (const MjcfAxis& axis : axes_.of(body)) out.joints.emplace_back(axis.name, axes_.value(axis, qpos));
    }
    for (int joint = 0; joint < m_->njnt; ++joint) {
      const int begin = m_->jnt_qposadr[joint], end = joint + 1 < m_->njnt ? m_->jnt_qposadr[joint + 1] : static_cast<int>(m_->nq);
      if (roles_.moves(joint) || std::equal(qpos + begin, qpos + end, m_->qpos0 + begin)) continue;
      const std::string& body = body_name(m_->jnt_bodyid[joint]);
      if (out.elsewhere.empty() || out.elsewhere.back() != body) out.elsewhere.push_back(body);
    }
    return out;
  }

  void read_configurations() {
    out_.as_written = read_configuration("", m_->qpos0);
    for (int k = 0; k < m_->nkey; ++k) {
      const std::string name = given_name(mjOBJ_KEY, k);
      out_.keyframes.push_back(read_configuration(name.empty() ? std::to_string(k) : name, m_->key_qpos + k * m_->nq));
    }
  }

  void read_places() {
    const auto add = [&](std::string name, int body, const Pose& X_BF) {
      if (name.empty()) return;
      FilePlace place{.name = std::move(name), .X_WF = pose_below(body, 0) * X_BF};
      if (roles_.top(body) != 0) place.moved_by = body_name(roles_.is_object(body) ? roles_.top(body) : body);
      place.with_robot = roles_.top(body) != 0 && !roles_.is_object(body);
      out_.places.push_back(std::move(place));
    };
    for (int s = 0; s < m_->nsite; ++s)
      add(given_name(mjOBJ_SITE, s), m_->site_bodyid[s], pose(m_->site_pos + 3 * s, m_->site_quat + 4 * s));
    for (int b = 1; b < m_->nbody; ++b) add(given_name(mjOBJ_BODY, b), b, Pose{});
  }

  // ---- geoms ----

  static GeometrySpec to_geometry(const RobotCollision& c, const Pose& X_BG) {
    return {.name = c.name, .shape = c.shape, .X_BG = X_BG, .friction = *c.friction, .mask = c.mask, .rule = *c.rule};
  }

  void read_contacts() {
    for (int i = 0; i < m_->npair; ++i) {
      const std::string one = geoms_.full_name(m_->pair_geom1[i]), other = geoms_.full_name(m_->pair_geom2[i]);
      if (one.empty() || other.empty() || !acts(i)) continue;
      const mjtNum* friction = m_->pair_friction + 5 * i;
      const int dimension = m_->pair_dim[i];
      out_.contacts.push_back({.a = one,
                               .b = other,
                               .friction = dimension > 1 ? friction[0] : 0,
                               .torsional = dimension > 3 ? friction[2] : 0,
                               .rolling = dimension > 4 ? friction[3] : 0});
    }
  }

  /// True for a geom of a link of the robot.
  bool is_in_link(int geom) const {
    const int body = m_->geom_bodyid[geom];
    return body != 0 && roles_.of_body(body) == MjcfRole::Robot && m_->geom_type[geom] != mjGEOM_PLANE;
  }

  /// Reads the colliding geoms of a body; X_LB is the body's pose in the link. Geoms of the world and planes go to the fixed body.
  /// @param owner  name of the link or object that the geoms belong to
  void read_geoms(int body, const Pose& X_LB, RobotLink* link, const std::string& owner) {
    for (int g = m_->body_geomadr[body]; g >= 0 && g < m_->body_geomadr[body] + m_->body_geomnum[body]; ++g) {
      if (!collides(g)) continue;
      const bool in_link = link != nullptr && m_->geom_type[g] != mjGEOM_PLANE;
      const std::string& holder = in_link ? owner : body_name(0);
      RobotCollision c = geoms_.read(g, holder, in_link && !roles_.is_object(body));
      c.X_LG = X_LB * c.X_LG;
      if (in_link)
        link->collisions.push_back(std::move(c));
      else
        out_.fixed.push_back(to_geometry(c, pose_below(body, 0) * c.X_LG));
    }
  }

  const MjcfMotors motors_;
  const MjcfAxes axes_;
  RobotContents out_{};
  std::vector<int> link_of_;                    ///< per body of the file
  std::vector<std::size_t> joint_of_;           ///< joint of the robot, per joint of the file; for a ball joint its last hinge
  std::map<int, Pose> X_OB_;                    ///< per body that is an object: the pose of its frame in the object's frame
  std::vector<ObjectCoordinates> coordinates_;  ///< coordinates of the objects
  std::set<std::string> link_names_;
  MjcfGeoms geoms_;
  std::vector<std::string> held_;  ///< objects that hold_by_damping() gave a friction
};

/// Reads the bytes of an MJCF. @param folder  folder for its relative paths  @param name  name of the file in messages
RobotContents read_text(const std::string& bytes, const std::filesystem::path& folder, const std::filesystem::path& name,
                        const RobotSpec& robot) {
  const std::string text = xml_text(bytes, name, "mjcf");
  tinyxml2::XMLDocument document;  // MuJoCo would also accept a URDF, by its own rules
  if (parse_xml(document, text, name, "mjcf") == nullptr) fail(name, "no element", "'mujoco'");
  std::vector<std::string> notes;
  const CompiledMjcf model = compile_mjcf(text, folder, name, notes);
  const MjcfRoles roles(*model, robot, name);
  RobotContents out = MjcfReader(model.get(), roles, name).read();
  out.robot.notes.insert(out.robot.notes.end(), notes.begin(), notes.end());
  out.sha256 = core::sha256(bytes);
  return out;
}

}  // namespace

RobotContents read_mjcf(const std::filesystem::path& file, const RobotSpec& robot) {
  if (!std::filesystem::is_regular_file(file)) fail(file, "a file that does not exist", "an MJCF file");
  return read_text(read_bytes(file), file.parent_path(), file, robot);
}

RobotContents read_mjcf_text(const std::string& text, const std::filesystem::path& folder, const RobotSpec& robot) {
  return read_text(text, folder, kTextName, robot);
}

}  // namespace stiction::world
