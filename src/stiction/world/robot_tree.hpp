#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

struct RobotCollision {
  std::string name;  ///< of the element, or KIND_NUMBER; unique within its link
  Shape shape;
  Pose X_LG;                         ///< geometry in link
  std::optional<double> friction{};  ///< μ, where the file states it
  ContactMask mask{};
};

struct RobotLink {
  std::string name;
  std::vector<RobotCollision> collisions;
  std::optional<BodyInertia> inertia;  ///< as the file states it; nullopt where it states none or a mass of 0
};

struct RobotJoint {
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
  std::optional<double> stiffness{};                ///< K_a, where the file states it [N/m or N·m/rad]
};

/// What a robot file says about kinematics, collision geometry and inertia.
/// Links and joints come depth first, children in the order of the file: link i > 0 is the child of joint i − 1.
struct RobotTree {
  std::string name;
  std::filesystem::path file;
  std::vector<RobotLink> links;
  std::vector<RobotJoint> joints;

  std::vector<std::string> movable_joints() const;  ///< names, in order
};

/// Reads the file of a robot, URDF or MJCF. @throws core::InvalidInput
RobotTree read_robot_tree(const RobotSpec& robot);

}  // namespace stiction::world
