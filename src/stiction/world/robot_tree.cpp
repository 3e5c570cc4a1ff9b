#include "stiction/world/robot_tree.hpp"

#include "stiction/world/mjcf.hpp"
#include "stiction/world/shapes.hpp"
#include "stiction/world/urdf.hpp"

namespace stiction::world {

std::vector<std::string> RobotTree::movable_joints() const {
  std::vector<std::string> names;
  for (const auto& joint : joints) {
    if (joint.kind != RobotJoint::Kind::Fixed) names.push_back(joint.name);
  }
  return names;
}

RobotTree read_robot_tree(const RobotSpec& robot) {
  if (!robot.mjcf.empty()) return read_mjcf(robot.mjcf).robot;
  MeshOptions options;
  if (robot.convex_hulls) options.non_convex = NonConvex::TakeHull;
  if (robot.decomposition) options = {NonConvex::Decompose, *robot.decomposition};
  return read_urdf(robot.urdf, robot.package_dirs, options);
}

}  // namespace stiction::world
