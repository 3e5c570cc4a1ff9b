#include "stiction/world/model.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/model_impl.hpp"
#include "stiction/world/overlap.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr int kFollowers = 1 << 24;  ///< axes of followers are counted from here until there are no more coordinates to come
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

bool is_rotation(const Matrix3d& R) { return (R.transpose() * R - Matrix3d::Identity()).norm() <= 1e-9 && R.determinant() > 0; }

/// The value nearest to 0 in [lower, upper].
double nearest_to_zero(double lower, double upper) { return std::clamp(0.0, lower, upper); }

/// Builds a Model::Impl from a scene: objects, then robots, then fixed bodies; then what follows from them.
class Builder {
 public:
  explicit Builder(const Scene& scene) : impl_(std::make_unique<Model::Impl>()), m_(*impl_) { m_.scene = scene; }

  std::unique_ptr<Model::Impl> build() {
    const Scene& scene = m_.scene;
    guard("scene", [&] {
      core::require_finite("gravity", std::span(scene.gravity.data(), 3));
      core::require_positive("contact_distance", scene.contact_distance);
      if (scene.max_contacts && *scene.max_contacts < 1)
        core::throw_invalid("max_contacts", fmt::format("{}", *scene.max_contacts), "an integer ≥ 1");
    });
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      guard(fmt::format("objects[{}]", i), [&] { add_object(scene.objects[i], static_cast<int>(i)); });
    }
    m_.n_vu = m_.n_v;
    m_.n_qu = m_.n_q;
    for (std::size_t i = 0; i < scene.robots.size(); ++i) {
      guard(fmt::format("robots[{}]", i), [&] { add_robot(scene.robots[i], static_cast<int>(i)); });
    }
    m_.n_a = m_.n_v - m_.n_vu;
    for (std::size_t i = 0; i < scene.fixed.size(); ++i) {
      guard(fmt::format("fixed[{}]", i), [&] { add_fixed(scene.fixed[i]); });
    }
    number_followers();
    finish_vectors();
    add_pairs();
    find_planar_axis();
    return std::move(impl_);
  }

 private:
  /// Puts the file and the place in front of what a check below says.
  template <class F>
  void guard(const std::string& place, F&& body) {
    try {
      body();
    } catch (const core::InvalidInput& e) {
      const std::string file = m_.scene.file.empty() ? "" : m_.scene.file.string() + ": ";
      throw core::InvalidInput(fmt::format("{}{}: {}", file, place, e.what()));
    }
  }

  void add_note(std::string_view owner, std::string_view note) { m_.notes.push_back(fmt::format("{}: {}", owner, note)); }

  void add_owner_name(const std::string& name) {
    if (name.empty() || name.find_first_of("/* ") != std::string::npos)
      core::throw_invalid("name", fmt::format("'{}'", name), "a name without '/', '*' or spaces");
    if (!owner_names_.insert(name).second) core::throw_invalid("name", fmt::format("'{}' twice", name), "each name once");
  }

  int add_body(std::string name, BodyKind kind, int owner, std::vector<int> dofs) {
    m_.bodies.push_back({std::move(name), kind, owner, dofs, dofs});
    m_.inertias.emplace_back();
    group_.push_back(static_cast<int>(group_.size()));
    return static_cast<int>(m_.bodies.size()) - 1;
  }

  void add_geometry(int body, const std::string& name, const Shape& shape, const Pose& X_BG, double friction, ContactMask mask) {
    const std::string full = fmt::format("{}/{}", m_.bodies[at(body)].name, name);
    if (!geometry_names_.insert(full).second) core::throw_invalid("geometry", fmt::format("'{}' twice", full), "each name once");
    require_shape(name, shape);
    core::require_nonnegative(fmt::format("{}.friction", name), friction);
    if (!is_rotation(X_BG.R) || !X_BG.p.allFinite()) core::throw_invalid(fmt::format("{}.pose", name), "no rigid transform", "one");
    if (std::holds_alternative<HalfSpace>(shape) && m_.bodies[at(body)].kind != BodyKind::Fixed) {
      core::throw_invalid(name, "a half-space", "half-spaces on fixed bodies only");
    }
    const BoundingSphere sphere = calc_bounding_sphere(shape);
    m_.geometries.push_back({full, body, shape, X_BG, friction, X_BG * sphere.center, sphere.radius});
    masks_.push_back(mask);
  }

  void add_dof(std::string name, DofKind kind, BodyKind owner_kind, int owner, double lower, double upper, double stiffness,
               double effort = kInfinity) {
    m_.dofs.push_back({std::move(name), kind, owner_kind, owner, lower, upper, stiffness, effort});
  }

  /// The object that this one hangs on, −1 for the world.
  int find_parent(const ObjectSpec& spec, int index) const {
    if (spec.parent.empty()) return -1;
    if (spec.joint != ObjectJoint::Hinge && spec.joint != ObjectJoint::Slider)
      core::throw_invalid("parent", fmt::format("'{}'", spec.parent), "it only for hinge and slider objects");
    for (int i = 0; i < index; ++i) {
      if (m_.objects[at(i)].name == spec.parent) return i;
    }
    core::throw_invalid("parent", fmt::format("'{}'", spec.parent), "an object listed before");
  }

  void add_object(const ObjectSpec& spec, int index) {
    add_owner_name(spec.name);
    core::require_positive("mass", spec.mass);
    core::require_nonnegative("weight_share", spec.weight_share);
    core::require_finite("p_BCom", std::span(spec.p_BCom.data(), 3));
    if (!is_rotation(spec.X_WP.R) || !spec.X_WP.p.allFinite()) core::throw_invalid("pose", "no rigid transform", "one");
    const Eigen::LLT<Matrix3d> factor(spec.inertia);
    if (!spec.inertia.allFinite() || factor.info() != Eigen::Success || !spec.inertia.isApprox(spec.inertia.transpose())) {
      core::throw_invalid("inertia", "a matrix that is not symmetric positive definite", "one that is");
    }
    if (spec.joint == ObjectJoint::Free && spec.p_BCom.norm() > 1e-6) {
      core::throw_invalid("p_BCom", fmt::format("({}, {}, {})", spec.p_BCom[0], spec.p_BCom[1], spec.p_BCom[2]), "0 for a free object");
    }

    ObjectNode node{.joint = spec.joint,
                    .q = m_.n_q,
                    .v = m_.n_v,
                    .parent = find_parent(spec, index),
                    .X_WP = spec.X_WP,
                    .mass = spec.mass,
                    .weight_share = spec.weight_share,
                    .p_BCom = spec.p_BCom,
                    .inertia = spec.inertia};
    const auto dof = [&](std::string_view name, DofKind kind, double lower = -kInfinity, double upper = kInfinity) {
      add_dof(fmt::format("{}/{}", spec.name, name), kind, BodyKind::Object, index, lower, upper, 0);
    };
    const auto planar = [&](int first, int second) {
      static constexpr std::string_view kAxes[] = {"x", "y", "z"};
      node.first = first, node.second = second, node.normal = 3 - first - second;
      node.n_v = 3;
      dof(kAxes[first], DofKind::Prismatic);
      dof(kAxes[second], DofKind::Prismatic);
      dof("theta", DofKind::Revolute);
    };
    switch (spec.joint) {
      case ObjectJoint::Free:
        node.n_v = 6;
        for (const auto name : {"x", "y", "z"}) dof(name, DofKind::Prismatic);
        for (const auto name : {"rx", "ry", "rz"}) dof(name, DofKind::Revolute);
        break;
      case ObjectJoint::PlanarXY:
        planar(0, 1);
        break;
      case ObjectJoint::PlanarYZ:
        planar(1, 2);
        break;
      case ObjectJoint::PlanarXZ:
        planar(0, 2);
        break;
      case ObjectJoint::Hinge:
      case ObjectJoint::Slider: {
        if (!(spec.axis.norm() > 1e-9) || !spec.axis.allFinite()) core::throw_invalid("axis", "0 or not finite", "a direction");
        node.axis_P = spec.axis.normalized();
        node.n_v = 1;
        const auto limits = spec.limits.value_or(std::array{-kInfinity, kInfinity});
        if (!(limits[0] <= limits[1])) core::throw_invalid("limits", fmt::format("[{}, {}]", limits[0], limits[1]), "lower ≤ upper");
        const bool hinge = spec.joint == ObjectJoint::Hinge;
        dof(hinge ? "angle" : "position", hinge ? DofKind::Revolute : DofKind::Prismatic, limits[0], limits[1]);
        break;
      }
    }
    const int n_q = spec.joint == ObjectJoint::Free ? 7 : node.n_v;
    std::vector<int> dofs;
    if (node.parent >= 0) dofs = m_.bodies[at(m_.object_nodes[at(node.parent)].body)].dofs;
    for (int i = 0; i < node.n_v; ++i) dofs.push_back(m_.n_v + i);
    node.body = add_body(spec.name, BodyKind::Object, index, std::move(dofs));
    m_.inertias.back() = {spec.mass, spec.p_BCom, spec.inertia};
    for (const auto& geometry : spec.geometries)
      add_geometry(node.body, geometry.name, geometry.shape, geometry.X_BG, geometry.friction, geometry.mask);
    if (node.parent >= 0) adjacent_.insert({group_[at(m_.object_nodes[at(node.parent)].body)], group_[at(node.body)]});
    m_.objects.push_back({.name = spec.name,
                          .body = node.body,
                          .v_begin = m_.n_v,
                          .n_v = node.n_v,
                          .q_begin = m_.n_q,
                          .n_q = n_q,
                          .mass = spec.mass,
                          .parent = node.parent});
    m_.object_nodes.push_back(node);
    for (int o = index; o >= 0; o = m_.objects[at(o)].parent) {
      m_.objects[at(o)].carried_mass += spec.mass;
      m_.object_nodes[at(o)].carried.push_back(index);
    }
    m_.n_v += node.n_v;
    m_.n_q += n_q;
  }

  void add_robot(const RobotSpec& spec, int index) {
    add_owner_name(spec.name);
    if (!is_rotation(spec.X_WBase.R) || !spec.X_WBase.p.allFinite()) core::throw_invalid("base", "no rigid transform", "one");
    const RobotTree tree = read_robot_tree(spec);
    RobotInfo info{.name = spec.name, .v_begin = m_.n_v, .n_v = 0, .q_begin = m_.n_q, .chains = {}};
    for (const auto& [link, value] : spec.link_friction) {
      if (std::none_of(tree.links.begin(), tree.links.end(), [&](const RobotLink& l) { return l.name == link; })) {
        core::throw_invalid("link_friction", fmt::format("unknown link '{}'", link),
                            spec.mjcf.empty() ? "a link of the URDF" : "a body of the MJCF");
      }
    }
    const auto joints = tree.movable_joints();
    const PerJoint stiffness = take_per_joint("stiffness", spec.stiffness, joints), effort = take_per_joint("effort", spec.effort, joints);
    for (const auto& [joint, value] : stiffness) core::require_positive(fmt::format("stiffness.{}", joint), value);
    for (const auto& [joint, value] : effort) {
      if (!(value > 0))
        core::throw_invalid(fmt::format("effort.{}", joint), fmt::format("{}", value), "a number > 0, or infinity for none");
    }

    const int base = static_cast<int>(m_.bodies.size());
    const std::vector<int> v_of_joint = number_joints(tree, m_.n_v);
    const int q_ahead = m_.n_q - m_.n_v;  // of a joint's configuration number, of its velocity index
    for (std::size_t i = 0; i < tree.links.size(); ++i) {
      add_link(spec, tree, i, index, base, i == 0 ? -1 : v_of_joint[i - 1], q_ahead, stiffness, effort);
    }
    for (const std::string& note : tree.notes) add_note(spec.name, note);
    if (!chosen_.empty()) {
      add_note(spec.name, fmt::format("stiffness of joints without one, which bear their effort at 1/40 of their range [N·m/rad, N/m]: {}",
                                      list_some(chosen_)));
      chosen_.clear();
    }
    if (!unbounded_.empty()) {
      add_note(spec.name, fmt::format("motors whose effort nobody states (or states as 0), and which may bear anything, of joints: {}",
                                      list_some(unbounded_)));
      unbounded_.clear();
    }
    info.n_v = m_.n_v - info.v_begin;
    info.chains = calc_chains(tree, info.v_begin);
    m_.robots.push_back(std::move(info));
  }

  using PerJoint = std::map<std::string, double>;

  /// The numbers that a scene gives for joints by name.
  static PerJoint take_per_joint(std::string_view what, std::span<const std::pair<std::string, double>> given,
                                 std::span<const std::string> joints) {
    PerJoint out;
    for (const auto& [joint, value] : given) {
      if (std::find(joints.begin(), joints.end(), joint) == joints.end())
        core::throw_invalid(what, fmt::format("unknown joint '{}'", joint), "one of " + list_with_hint(joint, joints));
      if (!out.emplace(joint, value).second) core::throw_invalid(what, fmt::format("joint '{}' twice", joint), "each joint once");
    }
    return out;
  }

  /// Of the scene, else of the robot's file, else none.
  double effort_of(const RobotJoint& joint, const PerJoint& given) {
    if (const auto found = given.find(joint.name); found != given.end()) return found->second;
    if (!joint.effort) unbounded_.push_back(joint.name);
    return joint.effort.value_or(kInfinity);
  }

  void add_link(const RobotSpec& spec, const RobotTree& tree, std::size_t i, int index, int base, int v, int q_ahead,
                const PerJoint& stiffness, const PerJoint& effort) {
    const RobotLink& link = tree.links[i];
    const RobotJoint* joint = i == 0 ? nullptr : &tree.joints[i - 1];
    const bool movable = joint != nullptr && joint->moves(), follows = movable && joint->leader >= 0;
    const int parent = joint != nullptr ? base + joint->parent : -1;
    std::vector<int> dofs, axes;
    if (parent >= 0) dofs = m_.bodies[at(parent)].dofs, axes = m_.bodies[at(parent)].axes;
    // Columns of followers come after those of all coordinates, whose number is not known yet.
    const int axis = follows ? kFollowers + static_cast<int>(m_.followers.size()) : v;
    if (movable) {
      axes.push_back(axis);
      if (const auto place = std::lower_bound(dofs.begin(), dofs.end(), v); place == dofs.end() || *place != v) dofs.insert(place, v);
    }
    const bool constant = dofs.empty();
    const int body = add_body(fmt::format("{}/{}", spec.name, link.name), BodyKind::Robot, index, std::move(dofs));
    m_.bodies.back().axes = std::move(axes);
    m_.inertias.back() = link.inertia ? *link.inertia : calc_inertia(link);
    m_.links.push_back({.body = body, .parent = parent, .dof = movable ? v : -1, .X_PJ = joint ? joint->X_PJ : spec.X_WBase});
    if (movable) m_.links.back().axis = joint->axis;
    if (follows) m_.links.back().follower = static_cast<int>(m_.followers.size());

    std::optional<double> friction;
    for (const auto& [name, value] : spec.link_friction) {
      if (name == link.name) friction = value;
    }
    for (const auto& c : link.collisions) {
      add_geometry(body, c.name, c.shape, c.X_LG, friction.value_or(c.friction.value_or(spec.friction)), c.mask);
    }

    if (joint != nullptr && !movable) group_[at(body)] = group_[at(parent)];
    if (movable) adjacent_.insert({group_[at(parent)], group_[at(body)]});
    if (constant) {
      const Pose X_WB = joint != nullptr ? constant_pose(parent) * joint->X_PJ : spec.X_WBase;
      m_.constant_poses.emplace_back(body, X_WB);
      return;
    }
    LinkNode node{};
    node.body = body;
    node.parent = parent;
    node.p_PJ = joint->X_PJ.p;
    node.C0 = joint->X_PJ.R;
    if (movable) {
      const bool revolute = joint->kind == RobotJoint::Kind::Revolute;
      node.kind = revolute ? LinkNode::Kind::Revolute : LinkNode::Kind::Prismatic;
      node.v = v;
      node.q = v + q_ahead;
      node.axis = axis;
      node.ratio = joint->ratio;
      node.offset = joint->offset;
      node.axis_P = joint->X_PJ.R * joint->axis;
      if (revolute) {
        const Matrix3d along = joint->axis * joint->axis.transpose();
        node.C0 = joint->X_PJ.R * along;
        node.C1 = joint->X_PJ.R * (Matrix3d::Identity() - along);
        node.C2 = joint->X_PJ.R * cross_matrix(joint->axis);
      }
      const std::string name = fmt::format("{}/{}", spec.name, joint->name);
      const DofKind kind = revolute ? DofKind::Revolute : DofKind::Prismatic;
      if (follows) {
        m_.followers.push_back({name, kind, v, joint->ratio, joint->offset});
        m_.link_nodes.push_back(node);
        return;
      }
      const auto found = stiffness.find(joint->name);
      double spring = found != stiffness.end() ? found->second : joint->stiffness.value_or(0);
      if (spring == 0) {
        spring = calc_default_stiffness(tree, i);
        chosen_.push_back(fmt::format("{} {:.3g}", joint->name, spring));
      }
      add_dof(name, kind, BodyKind::Robot, index, joint->lower, joint->upper, spring, effort_of(*joint, effort));
      reach_.push_back(revolute ? calc_reach(tree, i) : 1.0);
      ++m_.n_v;
      ++m_.n_q;
    }
    m_.link_nodes.push_back(node);
  }

  Pose constant_pose(int body) const {
    for (const auto& [index, pose] : m_.constant_poses) {
      if (index == body) return pose;
    }
    return {};
  }

  void add_fixed(const FixedSpec& spec) {
    add_owner_name(spec.name);
    if (!is_rotation(spec.X_WB.R) || !spec.X_WB.p.allFinite()) core::throw_invalid("pose", "no rigid transform", "one");
    const int body = add_body(spec.name, BodyKind::Fixed, -1, {});
    m_.constant_poses.emplace_back(body, spec.X_WB);
    for (const auto& geometry : spec.geometries)
      add_geometry(body, geometry.name, geometry.shape, geometry.X_BG, geometry.friction, geometry.mask);
  }

  void number_followers() {
    const auto number = [&](int& axis) {
      if (axis >= kFollowers) axis += m_.n_v - kFollowers;
    };
    for (Body& body : m_.bodies) std::ranges::for_each(body.axes, number);
    for (LinkNode& node : m_.link_nodes) number(node.axis);
  }

  void finish_vectors() {
    m_.stiffness.resize(m_.n_a);
    m_.effort.resize(m_.n_a);
    m_.lower.resize(m_.n_a);
    m_.upper.resize(m_.n_a);
    m_.neutral.setZero(m_.n_q);
    m_.reach = Eigen::Map<const Eigen::VectorXd>(reach_.data(), static_cast<Eigen::Index>(reach_.size()));
    for (int i = 0; i < m_.n_a; ++i) {
      const Dof& dof = m_.dofs[at(m_.n_vu + i)];
      m_.stiffness[i] = dof.stiffness;
      m_.effort[i] = dof.effort;
      m_.lower[i] = dof.lower;
      m_.upper[i] = dof.upper;
      m_.neutral[m_.n_qu + i] = nearest_to_zero(dof.lower, dof.upper);
    }
    for (const ObjectNode& node : m_.object_nodes) {
      if (node.joint == ObjectJoint::Free) m_.neutral[node.q + 6] = 1;
      const Dof& first = m_.dofs[at(node.v)];
      if (node.n_v == 1) m_.neutral[node.q] = nearest_to_zero(first.lower, first.upper);
    }
  }

  bool geometry_matches(const std::string& pattern, const Geometry& geometry) const {
    const Body& body = m_.bodies[at(geometry.body)];
    if (matches_pattern(pattern, body.name) || matches_pattern(pattern, geometry.name)) return true;
    return body.kind == BodyKind::Robot && matches_pattern(pattern, m_.robots[at(body.owner)].name);
  }

  void check_filters() {
    std::vector<std::string> names;
    for (const auto& robot : m_.robots) names.push_back(robot.name);
    for (const auto& body : m_.bodies) names.push_back(body.name);
    for (const auto& geometry : m_.geometries) names.push_back(geometry.name);
    for (std::size_t i = 0; i < m_.scene.filters.size(); ++i) {
      const FilterSpec& filter = m_.scene.filters[i];
      guard(fmt::format("filters[{}]", i), [&] {
        for (const std::string& pattern : {filter.a, filter.b}) {
          if (std::none_of(names.begin(), names.end(), [&](const std::string& name) { return matches_pattern(pattern, name); })) {
            core::throw_invalid("name", fmt::format("unknown body or geometry '{}'", pattern), "one of " + list_with_hint(pattern, names));
          }
        }
        if (filter.max_distance) core::require_nonnegative("max_distance", *filter.max_distance);
      });
    }
  }

  bool may_touch(const Geometry& a, const Geometry& b) const {
    const Body& body_a = m_.bodies[at(a.body)];
    const Body& body_b = m_.bodies[at(b.body)];
    if (body_a.dofs.empty() && body_b.dofs.empty()) return false;
    const ContactMask& mask_a = masks_[static_cast<std::size_t>(&a - m_.geometries.data())];
    const ContactMask& mask_b = masks_[static_cast<std::size_t>(&b - m_.geometries.data())];
    if (((mask_a.type & mask_b.affinity) | (mask_b.type & mask_a.affinity)) == 0) return false;
    const int group_a = group_[at(a.body)], group_b = group_[at(b.body)];
    return group_a != group_b && !adjacent_.contains({group_a, group_b}) && !adjacent_.contains({group_b, group_a});
  }

  /// Links that a robot does not push with and objects.
  bool may_push(const Geometry& a, const Geometry& b) const {
    const Body &object = m_.bodies[at(a.body)], &link = m_.bodies[at(b.body)];
    if (object.kind != BodyKind::Object || link.kind != BodyKind::Robot) return true;
    const RobotSpec& robot = m_.scene.robots[at(link.owner)];
    const std::string_view name = std::string_view(link.name).substr(robot.name.size() + 1);
    return robot.push_with.empty() ||
           std::any_of(robot.push_with.begin(), robot.push_with.end(), [&](const auto& pattern) { return matches_pattern(pattern, name); });
  }

  /// Links of one robot that overlap at rest are made so: they never touch.
  bool overlap_at_rest(const Geometry& a, const Geometry& b, const Kinematics& rest) {
    const Body &body_a = m_.bodies[at(a.body)], &body_b = m_.bodies[at(b.body)];
    if (body_a.kind != BodyKind::Robot || body_b.kind != BodyKind::Robot || body_a.owner != body_b.owner) return false;
    if (!overlap(a.shape, rest.X_WB[at(a.body)] * a.X_BG, b.shape, rest.X_WB[at(b.body)] * b.X_BG)) return false;
    const std::string& robot = m_.robots[at(body_a.owner)].name;
    const auto link = [&](const Body& body) { return std::string_view(body.name).substr(robot.size() + 1); };
    auto& names = overlapping_[robot];
    if (const std::string pair = fmt::format("{} and {}", link(body_a), link(body_b)); names.empty() || names.back() != pair)
      names.push_back(pair);
    return true;
  }

  Kinematics calc_rest() const {
    Eigen::VectorXd q = m_.neutral;
    if (!m_.scene.rest.empty()) {
      core::require_size("rest", static_cast<long>(m_.scene.rest.size()), m_.n_a);
      core::require_finite("rest", m_.scene.rest);
      q.tail(m_.n_a) = Eigen::Map<const Eigen::VectorXd>(m_.scene.rest.data(), m_.n_a);
    }
    Kinematics out;
    calc_kinematics(m_, q, out);
    return out;
  }

  void add_pairs() {
    check_filters();
    Kinematics rest;
    guard("scene", [&] { rest = calc_rest(); });
    std::map<std::vector<int>, int> support_index;
    for (std::size_t i = 0; i < m_.geometries.size(); ++i) {
      for (std::size_t j = i + 1; j < m_.geometries.size(); ++j) {
        const Geometry& a = m_.geometries[i];  // bodies stand in the order objects, robots, fixed: a comes first
        const Geometry& b = m_.geometries[j];
        if (!may_touch(a, b) || !may_push(a, b)) continue;
        Pair pair{static_cast<int>(i), static_cast<int>(j), 0, m_.scene.contact_distance, -1};
        bool excluded = false;
        for (const FilterSpec& filter : m_.scene.filters) {
          const bool hit = (geometry_matches(filter.a, a) && geometry_matches(filter.b, b)) ||
                           (geometry_matches(filter.a, b) && geometry_matches(filter.b, a));
          if (!hit) continue;
          if (filter.max_distance)
            pair.max_distance = *filter.max_distance;
          else
            excluded = true;
        }
        if (excluded || overlap_at_rest(a, b, rest)) continue;
        pair.friction = a.friction + b.friction > 0 ? 2 * a.friction * b.friction / (a.friction + b.friction) : 0.0;
        std::vector<int> support;
        const auto& dofs_a = m_.bodies[at(a.body)].dofs;
        const auto& dofs_b = m_.bodies[at(b.body)].dofs;
        std::set_union(dofs_a.begin(), dofs_a.end(), dofs_b.begin(), dofs_b.end(), std::back_inserter(support));
        const auto [found, added] = support_index.emplace(support, static_cast<int>(m_.supports.size()));
        if (added) m_.supports.push_back(std::move(support));
        pair.support = found->second;
        m_.pairs.push_back(pair);
      }
    }
    for (const auto& [robot, names] : overlapping_) {
      add_note(robot,
               fmt::format("{} pair{} of its links overlap{} at rest and never touch{}: {}", names.size(), names.size() == 1 ? "" : "s",
                           names.size() == 1 ? "s" : "", names.size() == 1 ? "es" : "", list_some(names)));
    }
  }

  /// Turning about a fixed direction and sliding across it keeps both properties, so that one configuration decides.
  void find_planar_axis() {
    if (m_.n_v == 0) return;
    Kinematics kinematics;
    calc_kinematics(m_, m_.neutral, kinematics);
    for (int k = 0; k < 3; ++k) {
      bool all = true;
      const auto require = [&](int column, DofKind kind) {
        const double along = std::abs(kinematics.axis_W(k, column));
        all = all && (kind == DofKind::Revolute ? along > 1 - 1e-9 : along < 1e-9);
      };
      for (int i = 0; i < m_.n_v; ++i) require(i, m_.dofs[at(i)].kind);
      for (std::size_t i = 0; i < m_.followers.size(); ++i) require(m_.n_v + static_cast<int>(i), m_.followers[i].kind);
      if (all) m_.planar_axis = k;
      if (all) return;
    }
  }

  std::unique_ptr<Model::Impl> impl_;
  Model::Impl& m_;
  std::set<std::string> owner_names_, geometry_names_;
  std::vector<ContactMask> masks_;          ///< per geometry
  std::vector<int> group_;                  ///< per body: bodies with the same number are welded together
  std::set<std::pair<int, int>> adjacent_;  ///< groups joined by a movable joint
  std::vector<double> reach_;
  std::map<std::string, std::vector<std::string>> overlapping_;  ///< pairs of links per robot
  std::vector<std::string> chosen_;                              ///< joints of a robot whose stiffness nobody states, and it
  std::vector<std::string> unbounded_;                           ///< joints of a robot whose effort nobody states
};

int find_name(std::string_view what, std::string_view name, const std::vector<std::string>& full) {
  int found = -1;
  for (std::size_t i = 0; i < full.size(); ++i) {
    if (full[i] == name) return static_cast<int>(i);
    const auto slash = full[i].find('/');
    if (slash == std::string::npos || full[i].substr(slash + 1) != name) continue;
    if (found >= 0)
      core::throw_invalid(what, fmt::format("'{}', which several robots have", name),
                          fmt::format("'{}' or '{}'", full[at(found)], full[i]));
    found = static_cast<int>(i);
  }
  if (found < 0)
    core::throw_invalid(what, fmt::format("unknown name '{}'", name),
                        full.empty() ? "none (there are none)" : "one of " + list_with_hint(name, full));
  return found;
}

}  // namespace

Model::Model(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Model::~Model() = default;

std::shared_ptr<const Model> Model::make(const Scene& scene) {
  std::shared_ptr<Model> model(new Model(Builder(scene).build()));
  model->impl_->scales.emplace(*model);
  return model;
}

const Scene& Model::scene() const { return impl_->scene; }
int Model::n_q() const { return impl_->n_q; }
int Model::n_v() const { return impl_->n_v; }
int Model::n_vu() const { return impl_->n_vu; }
int Model::n_qu() const { return impl_->n_qu; }
int Model::n_a() const { return impl_->n_a; }
std::span<const Body> Model::bodies() const { return impl_->bodies; }
std::span<const Geometry> Model::geometries() const { return impl_->geometries; }
std::span<const Pair> Model::pairs() const { return impl_->pairs; }
std::span<const Dof> Model::dofs() const { return impl_->dofs; }
std::span<const Follower> Model::followers() const { return impl_->followers; }
std::span<const ObjectInfo> Model::objects() const { return impl_->objects; }
std::span<const RobotInfo> Model::robots() const { return impl_->robots; }
std::span<const Link> Model::links() const { return impl_->links; }
std::span<const std::string> Model::notes() const { return impl_->notes; }
std::span<const BodyInertia> Model::inertias() const { return impl_->inertias; }
const std::vector<std::vector<int>>& Model::supports() const { return impl_->supports; }
std::optional<int> Model::planar_axis() const { return impl_->planar_axis; }
const Eigen::VectorXd& Model::stiffness() const { return impl_->stiffness; }
const Eigen::VectorXd& Model::effort() const { return impl_->effort; }
const Eigen::VectorXd& Model::lower() const { return impl_->lower; }
const Eigen::VectorXd& Model::upper() const { return impl_->upper; }
const Eigen::VectorXd& Model::reach() const { return impl_->reach; }
const Scales& Model::scales() const { return *impl_->scales; }
Eigen::VectorXd Model::neutral() const { return impl_->neutral; }

int Model::joint_index(std::string_view name) const {
  std::vector<std::string> names;
  for (int i = impl_->n_vu; i < impl_->n_v; ++i) names.push_back(impl_->dofs[at(i)].name);
  return find_name("joint", name, names);
}

int Model::object_index(std::string_view name) const {
  std::vector<std::string> names;
  for (const auto& object : impl_->objects) names.push_back(object.name);
  return find_name("object", name, names);
}

}  // namespace stiction::world
