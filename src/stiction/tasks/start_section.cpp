#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "stiction/core/faults.hpp"
#include "stiction/tasks/file_start.hpp"
#include "stiction/tasks/place_links.hpp"
#include "stiction/tasks/task_sections.hpp"
#include "stiction/world/joint_values.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::tasks {

using world::Model;
using world::YamlNode;

Eigen::Matrix3d rotation_of_rpy(const Eigen::Vector3d& rpy) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(rpy[2], Vector3d::UnitZ()) * AngleAxisd(rpy[1], Vector3d::UnitY()) * AngleAxisd(rpy[0], Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Quaterniond read_rotation(const YamlNode& pose) {
  const auto quaternion = pose.find("quaternion_wxyz");
  const auto rpy = pose.find("rpy");
  if (quaternion && rpy) pose.fail("both 'quaternion_wxyz' and 'rpy'", "one of the two");
  if (quaternion) {
    const Eigen::VectorXd c = quaternion->vector(4);
    if (std::abs(c.norm() - 1) > 1e-3) quaternion->fail(fmt::format("norm {:.6g}", c.norm()), "a unit quaternion");
    return Eigen::Quaterniond(c[0], c[1], c[2], c[3]).normalized();
  }
  return rpy ? Eigen::Quaterniond(rotation_of_rpy(rpy->vector3())) : Eigen::Quaterniond::Identity();
}

bool is_free(const Model& model, int object) {
  return model.scene().objects[static_cast<std::size_t>(object)].joint == world::ObjectJoint::Free;
}

void read_object_pose(const YamlNode& node, const Model& model, int object, Eigen::VectorXd& q) {
  const auto& info = model.objects()[static_cast<std::size_t>(object)];
  if (is_free(model, object)) {
    node.require_map({"position", "quaternion_wxyz", "rpy"});
    const Eigen::Quaterniond rotation = read_rotation(node);
    q.segment<3>(info.q_begin) = node.at("position").vector3();
    q.segment<4>(info.q_begin + 3) = rotation.coeffs();
    return;
  }
  node.require_map({"coordinates"});
  q.segment(info.q_begin, info.n_q) = node.at("coordinates").vector(info.n_q);
}

int find_object(const YamlNode& entry, const std::string& name, const Model& model) {
  std::vector<std::string> known;
  for (const auto& object : model.objects()) known.push_back(object.name);
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end()) entry.fail_unknown("object", name, known);
  return static_cast<int>(found - known.begin());
}

void require_in_limits(const YamlNode& node, const Model& model, int object, double x, std::string_view what) {
  const auto& spec = model.scene().objects[static_cast<std::size_t>(object)];
  if (!spec.limits || (x >= (*spec.limits)[0] && x <= (*spec.limits)[1])) return;
  node.fail(fmt::format("{} = {}", spec.name, x),
            fmt::format("a {} inside the limits [{}, {}]", what, (*spec.limits)[0], (*spec.limits)[1]));
}

namespace {

/// "jx, jy and 4 more" of a robot's joints.
template <class Joints>
std::string names_of(const Joints& joints) {
  std::vector<std::string> names;
  for (const auto& joint : joints) names.push_back(joint.name);
  return world::list_some(names);
}

/// How far the file of a robot lets a joint be from where its leader takes it. Limits are soft where such values come from, and give way.
double room_of(const Model& model, const world::Follower& follower) {
  constexpr double kSoft = 1.1;
  for (const auto& robot : model.scene().robots) {
    for (const auto& joint : robot.contents->robot.joints) {
      if (follower.name == fmt::format("{}/{}", robot.name, joint.name)) return kSoft * joint.room;
    }
  }
  return 0;
}

/// A joint that follows another one is where that takes it, or as near as its file lets it be.
/// @param q  configuration with the joints that move by themselves
void require_follows(const YamlNode& node, const Model& model, const world::Follower& follower, double value, const Eigen::VectorXd& q) {
  const double expected = follower.ratio * q[model.n_qu() + follower.dof - model.n_vu()] + follower.offset;
  const double unit = follower.kind == world::DofKind::Revolute ? 1 : model.scales().robots().length;
  if (std::abs(value - expected) <= room_of(model, follower) + world::share::kMotionless * unit) return;
  node.fail(fmt::format("{} = {:g}", follower.name, value), fmt::format("{:g}, as it follows {}, or no number for it", expected,
                                                                        model.dofs()[static_cast<std::size_t>(follower.dof)].name));
}

/// A list has a number for each joint that moves by itself, or for those that follow others as well.
void read_joint_list(const YamlNode& node, const Model& model, Eigen::VectorXd& q) {
  const Eigen::VectorXd given = node.vector();
  const auto own = world::own_joint_values(model.links(), model.n_vu(), model.n_a(), given);
  if (!own) {
    std::string expected =
        fmt::format("a list of {} numbers ({})", model.n_a(), names_of(model.dofs().subspan(static_cast<std::size_t>(model.n_vu()))));
    if (!model.followers().empty())
      expected += fmt::format(", or of {} with the joints that follow others ({})", world::number_of_joints(model.links()),
                              names_of(model.followers()));
    if (given.size() > world::number_of_joints(model.links()))
      expected += "; a joint whose limits are the same stands still and has no number";
    node.fail(expected);
  }
  q.tail(model.n_a()) = *own;
  if (given.size() == model.n_a()) return;
  Eigen::Index i = 0;
  for (const auto& link : model.links()) {
    if (link.dof < 0) continue;
    if (link.follower >= 0) require_follows(node, model, model.followers()[static_cast<std::size_t>(link.follower)], given[i], q);
    ++i;
  }
}

const world::Follower* find_follower(const Model& model, const std::string& name) {
  for (const auto& follower : model.followers()) {
    if (follower.name == name || follower.name.ends_with("/" + name)) return &follower;
  }
  return nullptr;
}

void read_named_joints(const YamlNode& node, const Model& model, Eigen::VectorXd& q) {
  std::vector<std::pair<const world::Follower*, YamlNode>> followers;
  for (const auto& [name, value] : node.entries()) {
    if (const auto* follower = find_follower(model, name)) {
      followers.emplace_back(follower, value);
      continue;
    }
    int joint = -1;
    try {
      joint = model.joint_index(name);
    } catch (const core::InvalidInput& e) {
      throw core::InvalidInput(fmt::format("{}: {}", value.where(), e.what()));
    }
    q[model.n_qu() + joint] = value.number();
  }
  for (const auto& [follower, value] : followers) require_follows(value, model, *follower, value.number(), q);
}

void read_joints(const YamlNode& node, const Model& model, Eigen::VectorXd& q) {
  if (node.is_sequence())
    read_joint_list(node, model, q);
  else
    read_named_joints(node, model, q);
  for (int j = 0; j < model.n_a(); ++j) {
    const double value = q[model.n_qu() + j], lower = model.lower()[j], upper = model.upper()[j];
    if (value >= lower && value <= upper) continue;
    const auto& dof = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)];
    const double radians = value * std::numbers::pi / 180;
    const bool degrees = dof.kind == world::DofKind::Revolute && std::abs(value) > std::numbers::pi && radians >= lower && radians <= upper;
    node.fail(fmt::format("{} = {}", dof.name, value),
              fmt::format("a start inside the joint limits [{}, {}]", lower, upper) +
                  (degrees ? fmt::format("; angles are in radians, {:g}° = {:.4g} rad", value, radians) : ""));
  }
}

/// The body of a link, as "robot/link", or "link" where one robot has it.
int find_link(const YamlNode& entry, const std::string& name, const Model& model) {
  const std::vector<int> found = find_links(model, name);
  if (found.empty()) {
    std::vector<std::string> known;
    for (const auto& link : model.links()) {
      const auto& body = model.bodies()[static_cast<std::size_t>(link.body)];
      if (!body.dofs.empty()) known.push_back(body.name);
    }
    entry.fail_unknown("link that moves", name, known);
  }
  if (found.size() > 1) entry.fail(fmt::format("link '{}', which {} robots have", name, found.size()), "ROBOT/LINK");
  return found[0];
}

/// Finds joint positions that bring links to their given poses, nearest to those of q.
void read_poses(const YamlNode& node, const Model& model, Eigen::VectorXd& q) {
  std::vector<LinkTarget> targets;
  std::string names;
  for (const auto& [name, value] : node.entries()) {
    value.require_map({"position", "quaternion_wxyz", "rpy"});
    LinkTarget target{.body = find_link(value, name, model), .p_WB = value.at("position").vector3()};
    if (value.has("quaternion_wxyz") || value.has("rpy")) target.R_WB = read_rotation(value).toRotationMatrix();
    targets.push_back(target);
    names += fmt::format("{}'{}'", names.empty() ? "" : " and ", name);
  }
  if (targets.empty()) node.fail("no link", "links with their poses");
  const PlacedLinks placed = place_links(model, q, targets);
  if (placed.status == core::Status::MaxIterations)
    node.fail(fmt::format("poses of {} that were not reached: the nearest posture found is {:.3g} m and {:.3g} rad off", names,
                          placed.position, placed.angle),
              "poses inside the reach of the robot and the limits of its joints, or joints nearer to them in `joints`");
  if (placed.status != core::Status::Solved) {
    const auto& pair = model.pairs()[static_cast<std::size_t>(placed.pair)];
    const auto geometry = [&](int i) { return model.geometries()[static_cast<std::size_t>(i)].name; };
    node.fail(fmt::format("poses of {} that are reached in contact alone: '{}' and '{}' overlap by {:.3g} mm in the best posture found",
                          names, geometry(pair.geometry_a), geometry(pair.geometry_b), 1e3 * placed.depth),
              "poses in which nothing touches, or joints nearer to such a posture in `joints`");
  }
  q = placed.q;
}

}  // namespace

Eigen::VectorXd read_start(const YamlNode& node, const Model& model, std::vector<std::string>* notes) {
  node.require_map();
  core::Faults faults;
  faults.collect([&] { node.require_map({"objects", "joints", "keyframe", "poses"}); });
  Eigen::VectorXd q = model.neutral();
  std::vector<bool> seen(model.objects().size(), false);
  start_as_written(model, q, seen);
  faults.collect([&] {
    if (const auto keyframe = node.find("keyframe")) start_at_keyframe(*keyframe, model, q, seen, notes);
  });
  faults.collect([&] {
    if (!node.has("objects") && std::find(seen.begin(), seen.end(), false) == seen.end()) return;
    const YamlNode objects = node.at("objects");
    for (const auto& [name, value] : objects.entries()) {
      faults.collect([&] {
        const int object = find_object(value, name, model);
        seen[static_cast<std::size_t>(object)] = true;
        read_object_pose(value, model, object, q);
        require_in_limits(value, model, object, q[model.objects()[static_cast<std::size_t>(object)].q_begin], "start");
      });
    }
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!seen[i])
        faults.collect([&] { objects.fail(fmt::format("no start of object '{}'", model.objects()[i].name), "one for every object"); });
    }
  });
  faults.collect([&] {
    if (const auto joints = node.find("joints")) read_joints(*joints, model, q);
  });
  faults.raise();  // what a posture must not touch is known then
  if (const auto poses = node.find("poses")) read_poses(*poses, model, q);
  return q;
}

}  // namespace stiction::tasks
