#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "stiction/world/model_parts.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

/// Adds the links and joints of one robot to a model.
class RobotAdder {
 public:
  RobotAdder(ModelParts& parts, const RobotSpec& spec, int index) : parts_(parts), m_(parts.m), spec_(spec), index_(index) {}

  void add() {
    parts_.add_owner_name(spec_.name);
    if (!is_rotation(spec_.X_WBase.R) || !spec_.X_WBase.p.allFinite()) core::throw_invalid("base", "no rigid transform", "one");
    const RobotTree& tree = spec_.contents->robot;
    RobotInfo info{.name = spec_.name, .v_begin = m_.n_v, .n_v = 0, .q_begin = m_.n_q, .chains = {}};
    for (const auto& [link, value] : spec_.link_friction) {
      if (std::none_of(tree.links.begin(), tree.links.end(), [&](const RobotLink& l) { return l.name == link; })) {
        core::throw_invalid("link_friction", fmt::format("unknown link '{}'", link),
                            spec_.mjcf.empty() ? "a link of the URDF" : "a body of the MJCF");
      }
    }
    const auto joints = tree.movable_joints();
    const PerJoint stiffness = take_per_joint("stiffness", spec_.stiffness, joints),
                   effort = take_per_joint("effort", spec_.effort, joints);
    for (const auto& [joint, value] : stiffness) core::require_positive(fmt::format("stiffness.{}", joint), value);
    for (const auto& [joint, value] : effort) {
      if (!(value > 0))
        core::throw_invalid(fmt::format("effort.{}", joint), fmt::format("{}", value), "a number > 0, or infinity for none");
    }

    const int base = static_cast<int>(m_.bodies.size());
    const std::vector<int> v_of_joint = number_joints(tree, m_.n_v);
    const int q_ahead = m_.n_q - m_.n_v;  // index of a joint in q minus its index in v
    for (std::size_t i = 0; i < tree.links.size(); ++i) {
      add_link(tree, i, base, i == 0 ? -1 : v_of_joint[i - 1], q_ahead, stiffness, effort);
    }
    for (const std::string& note : tree.notes) parts_.add_note(spec_.name, note);
    for (const std::string& note : spec_.notes) parts_.add_note(spec_.name, note);
    if (!chosen_.empty()) {
      parts_.add_note(spec_.name,
                      fmt::format("stiffness of joints without one, which bear their effort at 1/40 of their range [N·m/rad, N/m]: {}",
                                  list_some(chosen_)));
    }
    if (!soft_.empty()) {
      parts_.add_note(spec_.name, fmt::format("springs that are softer than this are left out [N·m/rad, N/m]: {}", list_some(soft_)));
    }
    if (!heavy_.empty()) {
      parts_.add_note(spec_.name, fmt::format("armatures that springs move at less than {} rad/s are smaller here [kg·m², kg]: {}",
                                              kLeastFrequency, list_some(heavy_)));
    }
    if (!unbounded_.empty()) {
      parts_.add_note(spec_.name,
                      fmt::format("motors whose effort nobody states (or states as 0), and which may bear anything, of joints: {}",
                                  list_some(unbounded_)));
    }
    info.n_v = m_.n_v - info.v_begin;
    info.chains = calc_chains(tree, info.v_begin);
    m_.robots.push_back(std::move(info));
  }

 private:
  using PerJoint = std::map<std::string, double>;

  /// Collects the values that a scene gives for joints by name.
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

  /// Effort of a joint: from the scene, else from the robot's file, else infinite.
  double effort_of(const RobotJoint& joint, const PerJoint& given) {
    if (const auto found = given.find(joint.name); found != given.end()) return found->second;
    if (!joint.effort) unbounded_.push_back(joint.name);
    return joint.effort.value_or(kInfinity);
  }

  /// A link of the robot's file and its joint (nullptr for the root), with their indices in the model.
  struct LinkPlace {
    const RobotLink& link;
    const RobotJoint* joint = nullptr;
    int body = -1, parent = -1;
    int v = -1;            ///< velocity index of the joint, or of the leader if it is a follower
    int axis = -1;         ///< column of Kinematics
    bool between = false;  ///< the parent stands between two joints of a body of an MJCF

    bool moves() const { return joint != nullptr && joint->moves(); }
    bool follows() const { return moves() && joint->leader >= 0; }
  };

  void add_link(const RobotTree& tree, std::size_t i, int base, int v, int q_ahead, const PerJoint& stiffness, const PerJoint& effort) {
    LinkPlace place{.link = tree.links[i], .joint = i == 0 ? nullptr : &tree.joints[i - 1]};
    if (place.joint != nullptr) {
      const RobotLink& above = tree.links[at(place.joint->parent)];
      place.parent = base + place.joint->parent;
      place.between = !spec_.mjcf.empty() && above.collisions.empty() && !above.inertia;
    }
    place.v = v;
    // Columns of followers come after the columns of all coordinates, and the number of coordinates is not known yet.
    place.axis = place.follows() ? kFollowers + static_cast<int>(m_.followers.size()) : v;
    const bool constant = add_body(place);
    add_geometries(place);
    if (constant) {
      const Pose X_WB = place.joint != nullptr ? constant_pose(place.parent) * place.joint->X_PJ : spec_.X_WBase;
      m_.constant_poses.emplace_back(place.body, X_WB);
      return;
    }
    m_.link_nodes.push_back(make_node(place, q_ahead));
    if (place.follows()) {
      const RobotJoint& joint = *place.joint;
      m_.followers.push_back({joint_name(joint), kind_of(joint), v, joint.ratio, joint.offset});
    } else if (place.moves()) {
      add_coordinate(tree, i, stiffness, effort);
    }
  }

  /// Adds the body of a link. @returns whether the body never moves
  bool add_body(LinkPlace& place) {
    std::vector<int> dofs, axes;
    if (place.parent >= 0) dofs = m_.bodies[at(place.parent)].dofs, axes = m_.bodies[at(place.parent)].axes;
    if (place.moves()) {
      axes.push_back(place.axis);
      if (const auto here = std::lower_bound(dofs.begin(), dofs.end(), place.v); here == dofs.end() || *here != place.v)
        dofs.insert(here, place.v);
    }
    const bool constant = dofs.empty();
    place.body = parts_.add_body(fmt::format("{}/{}", spec_.name, place.link.name), BodyKind::Robot, index_, std::move(dofs));
    m_.bodies.back().axes = std::move(axes);
    m_.inertias.back() = place.link.inertia ? *place.link.inertia : calc_inertia(place.link);
    m_.links.push_back({.body = place.body,
                        .parent = place.parent,
                        .dof = place.moves() ? place.v : -1,
                        .X_PJ = place.joint != nullptr ? place.joint->X_PJ : spec_.X_WBase});
    if (place.moves()) m_.links.back().axis = place.joint->axis;
    if (place.follows()) m_.links.back().follower = static_cast<int>(m_.followers.size());
    if (place.joint != nullptr && !place.moves()) parts_.group[at(place.body)] = parts_.group[at(place.parent)];
    if (place.moves()) parts_.join(place.parent, place.body, place.between);
    return constant;
  }

  void add_geometries(const LinkPlace& place) {
    std::optional<double> friction;
    for (const auto& [name, value] : spec_.link_friction) {
      if (name == place.link.name) friction = value;
    }
    for (const auto& c : place.link.collisions) {
      ContactMask mask = c.mask;
      mask.file = fmt::format("{}/{}", spec_.name, mask.file);
      parts_.add_geometry(place.body, {.name = c.name,
                                       .shape = c.shape,
                                       .X_BG = c.X_LG,
                                       .friction = friction.value_or(c.friction.value_or(spec_.friction)),
                                       .mask = std::move(mask),
                                       .rule = c.rule.value_or(spec_.rule)});
    }
  }

  static DofKind kind_of(const RobotJoint& joint) {
    return joint.kind == RobotJoint::Kind::Revolute ? DofKind::Revolute : DofKind::Prismatic;
  }
  std::string joint_name(const RobotJoint& joint) const { return fmt::format("{}/{}", spec_.name, joint.name); }

  /// Makes the data from which calc_kinematics() places a moving link.
  static LinkNode make_node(const LinkPlace& place, int q_ahead) {
    const RobotJoint& joint = *place.joint;  // the root never moves
    LinkNode node{};
    node.body = place.body;
    node.parent = place.parent;
    node.p_PJ = joint.X_PJ.p;
    node.C0 = joint.X_PJ.R;
    if (!place.moves()) return node;
    const bool revolute = joint.kind == RobotJoint::Kind::Revolute;
    node.kind = revolute ? LinkNode::Kind::Revolute : LinkNode::Kind::Prismatic;
    node.v = place.v;
    node.q = place.v + q_ahead;
    node.axis = place.axis;
    node.ratio = joint.ratio;
    node.offset = joint.offset;
    node.axis_P = joint.X_PJ.R * joint.axis;
    if (!revolute) return node;
    const Matrix3d along = joint.axis * joint.axis.transpose();
    node.C0 = joint.X_PJ.R * along;
    node.C1 = joint.X_PJ.R * (Matrix3d::Identity() - along);
    node.C2 = joint.X_PJ.R * cross_matrix(joint.axis);
    return node;
  }

  /// Adds the coordinate of a joint that moves by itself, with its spring and its motor. @param i  the link that the joint moves
  void add_coordinate(const RobotTree& tree, std::size_t i, const PerJoint& stiffness, const PerJoint& effort) {
    const RobotJoint& joint = tree.joints[i - 1];
    const auto found = stiffness.find(joint.name);
    double spring = found != stiffness.end() ? found->second : joint.stiffness.value_or(0);
    if (spring == 0) {
      spring = calc_default_stiffness(tree, i);
      if (joint.spring > 0 && joint.spring < spring) soft_.push_back(fmt::format("{} {:.3g}", joint.name, joint.spring));
      if (joint.spring >= spring)
        spring = joint.spring;
      else
        chosen_.push_back(fmt::format("{} {:.3g}", joint.name, spring));
    }
    const DofKind kind = kind_of(joint);
    parts_.add_dof(joint_name(joint), kind, BodyKind::Robot, index_, joint.lower, joint.upper, spring, effort_of(joint, effort));
    Dof& dof = m_.dofs.back();
    dof.command_lower = std::min(joint.lower, joint.command_lower);
    dof.command_upper = std::max(joint.upper, joint.command_upper);
    dof.speed_limit = joint.speed_limit;
    parts_.set_joint_friction(joint.friction, joint.damping);
    m_.motors.push_back(joint.motor);
    JointMotor& motor = m_.motors.back();
    if (found != stiffness.end()) motor.damping = 0;  // of a servo with another stiffness
    if (const double most = spring / (kLeastFrequency * kLeastFrequency); motor.armature > most) {
      heavy_.push_back(fmt::format("{} {:.3g} in place of {:.3g}", joint.name, most, motor.armature));
      motor.armature = most;
    }
    parts_.reach.push_back(kind == DofKind::Revolute ? calc_reach(tree, i) : 1.0);
    ++m_.n_v;
    ++m_.n_q;
  }

  Pose constant_pose(int body) const {
    for (const auto& [index, pose] : m_.constant_poses) {
      if (index == body) return pose;
    }
    return {};
  }

  ModelParts& parts_;
  Model::Impl& m_;
  const RobotSpec& spec_;
  int index_;                             ///< index of the robot
  std::vector<std::string> chosen_{};     ///< joints whose stiffness is the default, with its value
  std::vector<std::string> soft_{};       ///< joints whose spring in the file is softer than the chosen stiffness
  std::vector<std::string> heavy_{};      ///< joints whose armature is limited, with that of the file
  std::vector<std::string> unbounded_{};  ///< joints without a stated effort
};

}  // namespace

void add_robot(ModelParts& parts, const RobotSpec& spec, int index) { RobotAdder(parts, spec, index).add(); }

}  // namespace stiction::world
