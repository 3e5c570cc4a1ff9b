#include "stiction/world/robot_tree.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/mjcf.hpp"
#include "stiction/world/mount.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/urdf.hpp"
#include "stiction/world/urdf_scene.hpp"

namespace stiction::world {
namespace {

double slide(const RobotJoint& joint) {
  if (joint.kind != RobotJoint::Kind::Prismatic) return 0;
  const double most = std::max(std::abs(joint.lower), std::abs(joint.upper));
  return std::isfinite(most) ? most : 0;
}

/// Bound on the distance from the origin of a link to any point of the geometry it moves, over all joint angles.
double calc_extent(const RobotTree& tree, int link) {
  double extent = 0;
  for (const auto& c : tree.links[static_cast<std::size_t>(link)].collisions) {
    const BoundingSphere sphere = calc_bounding_sphere(c.shape);
    extent = std::max(extent, (c.X_LG * sphere.center).norm() + sphere.radius);
  }
  for (const auto& joint : tree.joints) {
    if (joint.parent == link) extent = std::max(extent, joint.X_PJ.p.norm() + slide(joint) + calc_extent(tree, joint.child));
  }
  return extent;
}

/// Mass of a link and of all links that hang on it [kg].
double calc_carried_mass(const RobotTree& tree, int link) {
  const RobotLink& here = tree.links[static_cast<std::size_t>(link)];
  double mass = here.inertia ? here.inertia->mass : calc_inertia(here).mass;
  for (const auto& joint : tree.joints) {
    if (joint.parent == link) mass += calc_carried_mass(tree, joint.child);
  }
  return mass;
}

}  // namespace

std::vector<std::string> RobotTree::movable_joints() const {
  std::vector<std::string> names;
  for (const auto& joint : joints) {
    if (joint.moves_by_itself()) names.push_back(joint.name);
  }
  return names;
}

BodyInertia calc_inertia(const RobotLink& link) {
  std::vector<GeometrySpec> solids;
  for (const auto& c : link.collisions) {
    if (!std::holds_alternative<HalfSpace>(c.shape)) solids.push_back({c.name, c.shape, c.X_LG, 0});
  }
  const VolumeProperties volume = calc_volume_properties(solids);
  return {kLinkDensity * volume.volume, volume.center, kLinkDensity * volume.inertia};
}

double calc_reach(const RobotTree& tree, std::size_t link) {
  const Eigen::Vector3d axis = tree.joints[link - 1].axis;
  const auto from_axis = [&](const Eigen::Vector3d& p) { return axis.cross(p).norm(); };
  double reach = 0;
  for (const auto& c : tree.links[link].collisions) {
    const BoundingSphere sphere = calc_bounding_sphere(c.shape);
    reach = std::max(reach, from_axis(c.X_LG * sphere.center) + sphere.radius);
  }
  for (const auto& joint : tree.joints) {
    if (joint.parent == static_cast<int>(link))
      reach = std::max(reach, from_axis(joint.X_PJ.p) + slide(joint) + calc_extent(tree, joint.child));
  }
  for (const auto& joint : tree.joints) {  // followers of the joint may be in other branches
    if (joint.leader == static_cast<int>(link) - 1)
      reach = std::max(reach, std::abs(joint.ratio) * calc_reach(tree, static_cast<std::size_t>(joint.child)));
  }
  return reach > 0 ? reach : 1.0;
}

double calc_default_stiffness(const RobotTree& tree, std::size_t link) {
  constexpr double kShare = 1.0 / 40, kMargin = 2, kGravity = 9.81;
  const RobotJoint& joint = tree.joints[link - 1];
  const bool revolute = joint.kind == RobotJoint::Kind::Revolute;
  double range = joint.upper - joint.lower;
  if (!std::isfinite(range) || range <= 0) range = revolute ? 2 * std::numbers::pi : calc_reach(tree, link);
  const double weight = kMargin * kGravity * calc_carried_mass(tree, static_cast<int>(link));
  const double effort = joint.effort.value_or(weight * (revolute ? calc_reach(tree, link) : 1.0));
  return effort > 0 ? effort / (kShare * range) : 1.0;  // a joint that carries no mass may have any stiffness
}

std::vector<int> number_joints(const RobotTree& tree, int v_begin) {
  std::vector<int> out(tree.joints.size(), -1);
  for (std::size_t j = 0; j < out.size(); ++j) {
    if (tree.joints[j].moves_by_itself()) out[j] = v_begin++;
  }
  for (std::size_t j = 0; j < out.size(); ++j) {
    if (tree.joints[j].leader >= 0) out[j] = out[static_cast<std::size_t>(tree.joints[j].leader)];
  }
  return out;
}

std::vector<std::vector<int>> calc_chains(const RobotTree& tree, int v_begin) {
  std::vector<int> v_of_joint = number_joints(tree, v_begin);
  for (std::size_t j = 0; j < v_of_joint.size(); ++j) {
    if (!tree.joints[j].moves_by_itself()) v_of_joint[j] = -1;
  }
  std::vector<std::vector<int>> chains;
  // Nearest movable joints below a link.
  const auto below = [&](auto&& self, int link) -> std::vector<std::size_t> {
    std::vector<std::size_t> out;
    for (std::size_t j = 0; j < tree.joints.size(); ++j) {
      if (tree.joints[j].parent != link) continue;
      if (v_of_joint[j] >= 0) {
        out.push_back(j);
      } else {
        const auto more = self(self, tree.joints[j].child);
        out.insert(out.end(), more.begin(), more.end());
      }
    }
    return out;
  };
  const auto visit = [&](auto&& self, std::size_t joint) -> void {
    std::vector<int> chain{v_of_joint[joint]};
    auto next = below(below, tree.joints[joint].child);
    while (next.size() == 1) {
      chain.push_back(v_of_joint[next[0]]);
      next = below(below, tree.joints[next[0]].child);
    }
    for (const std::size_t j : next) self(self, j);
    chains.push_back(std::move(chain));
  };
  for (const std::size_t j : below(below, 0)) visit(visit, j);
  return chains;
}

namespace {

/// Fixes a joint at a value.
void weld(RobotJoint& joint, double value) {
  const bool revolute = joint.kind == RobotJoint::Kind::Revolute;
  joint.X_PJ = joint.X_PJ * (revolute ? Pose{Eigen::AngleAxisd(value, joint.axis).toRotationMatrix(), Eigen::Vector3d::Zero()}
                                      : Pose{Eigen::Matrix3d::Identity(), value * joint.axis});
  joint.kind = RobotJoint::Kind::Fixed;
  joint.leader = -1;
}

/// Replaces each leader that follows another joint by that joint.
void shorten_chains(RobotTree& tree) {
  for (auto& joint : tree.joints) {
    std::size_t hops = 0;
    while (joint.leader >= 0 && tree.joints[static_cast<std::size_t>(joint.leader)].leader >= 0) {
      const RobotJoint& next = tree.joints[static_cast<std::size_t>(joint.leader)];
      if (++hops > tree.joints.size())
        core::throw_invalid("robot", fmt::format("joint '{}', which follows itself", joint.name), "a leader that moves by itself");
      joint.offset += joint.ratio * next.offset;
      joint.ratio *= next.ratio;
      joint.leader = next.leader;
    }
  }
}

}  // namespace

void release_placeholder_limits(RobotTree& tree) {
  std::vector<std::string> names;
  for (RobotJoint& joint : tree.joints) {
    const auto is_placeholder = [](double limit) { return std::isfinite(limit) && std::abs(limit) >= kNoLimit; };
    if (!is_placeholder(joint.lower) && !is_placeholder(joint.upper)) continue;
    names.push_back(joint.name);
    if (is_placeholder(joint.lower) && joint.lower < 0) joint.lower = -std::numeric_limits<double>::infinity();
    if (is_placeholder(joint.upper) && joint.upper > 0) joint.upper = std::numeric_limits<double>::infinity();
  }
  if (!names.empty()) tree.notes.push_back("limits of 1000 rad or m and more mean none, of joints: " + list_some(names));
}

void resolve_followers(RobotTree& tree) {
  shorten_chains(tree);
  for (const auto& joint :
       tree.joints) {  // add the followers' friction at equal power, their armature at equal energy, and their speed limits, to the leader
    if (joint.leader < 0) continue;
    RobotJoint& leader = tree.joints[static_cast<std::size_t>(joint.leader)];
    leader.friction += std::abs(joint.ratio) * joint.friction;
    leader.damping += joint.ratio * joint.ratio * joint.damping;
    leader.motor.armature += joint.ratio * joint.ratio * joint.motor.armature;
    if (joint.ratio != 0) leader.speed_limit = std::min(leader.speed_limit, joint.speed_limit / std::abs(joint.ratio));
  }
  std::vector<std::string> outside;
  for (auto& joint : tree.joints) {
    if (joint.leader < 0 || joint.ratio == 0) continue;
    RobotJoint& leader = tree.joints[static_cast<std::size_t>(joint.leader)];
    const double ends[] = {(joint.lower - joint.offset) / joint.ratio, (joint.upper - joint.offset) / joint.ratio};
    const double lower = std::max(leader.lower, std::min(ends[0], ends[1])), upper = std::min(leader.upper, std::max(ends[0], ends[1]));
    if (lower < upper)
      leader.lower = lower, leader.upper = upper;
    else if (leader.moves() && leader.lower < leader.upper)
      outside.push_back(joint.name);
  }
  if (!outside.empty()) {
    tree.notes.push_back(
        fmt::format("limits that leave no range to the joints that they follow are left out, of joints: {}", list_some(outside)));
  }
  // A joint whose range is one point does not move, and neither do its followers.
  std::vector<std::optional<double>> still(tree.joints.size());
  std::vector<std::string> names;
  for (std::size_t j = 0; j < tree.joints.size(); ++j) {
    RobotJoint& joint = tree.joints[j];
    if (!joint.moves()) still[j] = 0;
    if (!joint.moves_by_itself() || joint.lower != joint.upper) continue;
    still[j] = joint.lower;
    names.push_back(joint.name);
    weld(joint, joint.lower);
  }
  for (auto& joint : tree.joints) {
    if (joint.leader < 0) continue;
    if (const auto& value = still[static_cast<std::size_t>(joint.leader)]) weld(joint, joint.ratio * *value + joint.offset);
  }
  if (!names.empty()) {
    tree.notes.push_back(fmt::format("lower and upper limit are the same, so that these joints stand still: {}", list_some(names)));
  }
}

std::string list_some(std::span<const std::string> names) {
  constexpr std::size_t kMost = 6;
  const auto shown = names.first(names.size() > kMost ? kMost - 1 : names.size());
  const std::string more = shown.size() < names.size() ? fmt::format(" and {} more", names.size() - shown.size()) : "";
  return fmt::format("{}{}", fmt::join(shown, ", "), more);
}

namespace {

/// True if all keys that affect the reading of the file are equal.
bool reads_the_same(const RobotSpec& a, const RobotSpec& b) {
  const auto same_parts = [](const Decomposition& x, const Decomposition& y) {
    return x.threshold == y.threshold && x.max_parts == y.max_parts;
  };
  if (a.decomposition.has_value() != b.decomposition.has_value()) return false;
  if (a.decomposition && !same_parts(*a.decomposition, *b.decomposition)) return false;
  const auto same_mounts = [](const MountSpec& x, const MountSpec& y) {
    return x.name == y.name && x.file == y.file && x.on == y.on && x.X_LM.R == y.X_LM.R && x.X_LM.p == y.X_LM.p;
  };
  if (!std::equal(a.mounts.begin(), a.mounts.end(), b.mounts.begin(), b.mounts.end(), same_mounts)) return false;
  return a.urdf == b.urdf && a.mjcf == b.mjcf && a.text == b.text && a.package_dirs == b.package_dirs && a.convex_hulls == b.convex_hulls &&
         a.split == b.split && a.fixed_base == b.fixed_base;
}

RobotContents read_contents(const RobotSpec& robot) {
  if (!robot.mjcf.empty())
    return robot.text.empty() ? read_mjcf(robot.mjcf, robot) : read_mjcf_text(robot.text, robot.mjcf.parent_path(), robot);
  MeshOptions options{robot.convex_hulls ? NonConvex::TakeHull : NonConvex::TakeHulls, {}};
  if (robot.decomposition) options = {NonConvex::Decompose, *robot.decomposition};
  const bool whole = robot.split.by_actuators;
  RobotContents out = robot.text.empty() ? read_urdf(robot.urdf, robot.package_dirs, options, whole)
                                         : read_urdf_text(robot.text, robot.urdf.parent_path(), robot.package_dirs, options, whole);
  if (whole) split_urdf(robot.split, out);
  return out;
}

}  // namespace

std::shared_ptr<const RobotContents> contents_of(const RobotSpec& robot) {
  if (robot.contents != nullptr && reads_the_same(robot.contents->spec, robot)) return robot.contents;
  RobotContents contents = read_contents(robot);
  mount_all(robot, contents);
  contents.spec = robot;
  contents.spec.contents = nullptr;
  return std::make_shared<const RobotContents>(std::move(contents));
}

}  // namespace stiction::world
