#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/world/scene.hpp"
#include "stiction/world/shapes.hpp"

namespace stiction::world {

struct UrdfCollision {
  std::string name;  ///< of the element, or KIND_NUMBER; unique within its link
  Shape shape;
  Pose X_LG;  ///< geometry in link
};

struct UrdfLink {
  std::string name;
  std::vector<UrdfCollision> collisions;
};

struct UrdfJoint {
  enum class Kind {
    Fixed,
    Revolute,
    Prismatic
  };
  std::string name;
  Kind kind = Kind::Fixed;
  int parent = -1, child = -1;                      ///< links
  Pose X_PJ;                                        ///< joint in parent link at zero
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< unit, in the child frame
  double lower = 0, upper = 0;                      ///< [rad or m]; infinite for continuous joints
};

/// What a URDF says about kinematics and collision geometry (robots are gravity compensated, so that masses do not matter).
/// Links and joints come depth first, children in the order of the file: link i > 0 is the child of joint i − 1.
struct UrdfRobot {
  std::string name;
  std::filesystem::path file;
  std::vector<UrdfLink> links;
  std::vector<UrdfJoint> joints;

  std::vector<std::string> movable_joints() const;  ///< names, in order
};

/// Reads revolute, continuous, prismatic and fixed joints; sphere, box, cylinder, capsule and (convex) mesh collisions.
/// @throws core::InvalidInput "FILE:LINE: element: got …, expected …"
UrdfRobot read_urdf(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs,
                    NonConvex non_convex = NonConvex::Refuse);

/// The file of "package://PKG/REST", "file://PATH" or a path relative to `base_dir`. A package is looked for in package_dirs and
/// in the folders above base_dir, as a folder PKG or as a folder that is itself called PKG. Empty when nothing is there.
std::filesystem::path find_resource(std::string_view uri, const std::filesystem::path& base_dir,
                                    std::span<const std::filesystem::path> package_dirs);

}  // namespace stiction::world
