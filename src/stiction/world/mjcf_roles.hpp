#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <string>
#include <vector>

#include "stiction/world/mjcf_names.hpp"
#include "stiction/world/scene.hpp"

namespace stiction::world {

enum class MjcfRole {
  Fixed,
  Robot,
  Object
};

/// Assigns a role to every joint and body of a compiled MJCF: moved by a robot's motor, part of an object, or fixed. In the rule of MjcfSplit, a
/// tree is a topmost body with joints and all bodies below it.
class MjcfRoles {
 public:
  /// @param spec  robot whose `split` and `fixed_base` apply
  /// @throws core::InvalidInput: a named body does not exist or cannot have the stated role
  MjcfRoles(const mjModel& m, const RobotSpec& spec, const std::filesystem::path& file);

  const MjcfNames& names() const { return names_; }
  MjcfRole of_joint(int joint) const { return joints_[static_cast<std::size_t>(joint)]; }
  bool moves(int joint) const { return of_joint(joint) != MjcfRole::Fixed; }
  /// Role of the joint that moves the body. A fixed body belongs to the robot if links of the robot hang on it.
  MjcfRole of_body(int body) const { return bodies_[static_cast<std::size_t>(body)]; }
  /// The nearest body at or above this one whose joints move; 0 if no joint moves it.
  int top(int body) const { return top_[static_cast<std::size_t>(body)]; }
  bool is_object(int body) const { return of_body(body) == MjcfRole::Object; }
  /// Joints of the body that move, in the order of the file.
  std::vector<int> joints_of(int body) const;
  bool has_robot() const;
  bool by_actuators() const { return by_actuators_; }
  /// Joints that count as motors of the robot although their tree has no actuator.
  const std::vector<int>& silent_motors() const { return silent_motors_; }

 private:
  struct Builder;
  const mjModel& m_;
  MjcfNames names_;
  bool by_actuators_;
  std::vector<MjcfRole> joints_{}, bodies_{};
  std::vector<int> top_{}, silent_motors_{};
};

/// Joints that the transmission of an actuator acts on: its own joint, the joints of its tendon, or the joints of the bodies that it pulls on.
std::vector<int> joints_of_actuator(const mjModel& m, int actuator);

}  // namespace stiction::world
