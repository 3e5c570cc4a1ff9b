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
    const int q_ahead = m_.n_q - m_.n_v;  // of a joint's configuration number, of its velocity index
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

  void add_link(const RobotTree& tree, std::size_t i, int base, int v, int q_ahead, const PerJoint& stiffness, const PerJoint& effort) {
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
    const int body = parts_.add_body(fmt::format("{}/{}", spec_.name, link.name), BodyKind::Robot, index_, std::move(dofs));
    m_.bodies.back().axes = std::move(axes);
    m_.inertias.back() = link.inertia ? *link.inertia : calc_inertia(link);
    m_.links.push_back({.body = body, .parent = parent, .dof = movable ? v : -1, .X_PJ = joint ? joint->X_PJ : spec_.X_WBase});
    if (movable) m_.links.back().axis = joint->axis;
    if (follows) m_.links.back().follower = static_cast<int>(m_.followers.size());

    std::optional<double> friction;
    for (const auto& [name, value] : spec_.link_friction) {
      if (name == link.name) friction = value;
    }
    for (const auto& c : link.collisions) {
      parts_.add_geometry(body, c.name, c.shape, c.X_LG, friction.value_or(c.friction.value_or(spec_.friction)), c.mask);
    }

    if (joint != nullptr && !movable) parts_.group[at(body)] = parts_.group[at(parent)];
    if (movable) parts_.adjacent.insert({parts_.group[at(parent)], parts_.group[at(body)]});
    if (constant) {
      const Pose X_WB = joint != nullptr ? constant_pose(parent) * joint->X_PJ : spec_.X_WBase;
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
      const std::string name = fmt::format("{}/{}", spec_.name, joint->name);
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
      parts_.add_dof(name, kind, BodyKind::Robot, index_, joint->lower, joint->upper, spring, effort_of(*joint, effort));
      m_.dofs.back().speed_limit = joint->speed_limit;
      parts_.set_joint_friction(joint->friction, joint->damping);
      parts_.reach.push_back(revolute ? calc_reach(tree, i) : 1.0);
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

  ModelParts& parts_;
  Model::Impl& m_;
  const RobotSpec& spec_;
  int index_;                             ///< of the robot
  std::vector<std::string> chosen_{};     ///< joints whose stiffness nobody states, and it
  std::vector<std::string> unbounded_{};  ///< joints whose effort nobody states
};

}  // namespace

void add_robot(ModelParts& parts, const RobotSpec& spec, int index) { RobotAdder(parts, spec, index).add(); }

}  // namespace stiction::world
