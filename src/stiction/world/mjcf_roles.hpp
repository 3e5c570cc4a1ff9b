#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <string>
#include <vector>

#include "stiction/world/scene.hpp"

namespace stiction::world {

enum class MjcfRole {
  Fixed,
  Robot,
  Object
};

/// Which joints of a compiled MJCF motors move, which objects hang on, and which stand still. By the rule of MjcfSplit, a tree is a topmost
/// body with joints and all below.
class MjcfRoles {
 public:
  /// @param spec  its split and fixed_base  @throws core::InvalidInput: bodies that are not there or cannot be what they are said to be
  MjcfRoles(const mjModel& m, const RobotSpec& spec, const std::filesystem::path& file);

  MjcfRole of_joint(int joint) const { return joints_[static_cast<std::size_t>(joint)]; }
  bool moves(int joint) const { return of_joint(joint) != MjcfRole::Fixed; }
  /// Of what moves the body; a body that stands still is the robot's where links of the robot hang on it.
  MjcfRole of_body(int body) const { return bodies_[static_cast<std::size_t>(body)]; }
  /// The nearest body at or above this one whose joints move; 0 where nothing moves it.
  int top(int body) const { return top_[static_cast<std::size_t>(body)]; }
  bool is_object(int body) const { return of_body(body) == MjcfRole::Object; }
  /// Joints of the body that move, in the order of the file.
  std::vector<int> joints_of(int body) const;
  bool has_robot() const;
  bool by_actuators() const { return by_actuators_; }
  /// Joints in trees without an actuator that are motors of the robot all the same.
  const std::vector<int>& silent_motors() const { return silent_motors_; }

 private:
  struct Builder;
  const mjModel& m_;
  bool by_actuators_;
  std::vector<MjcfRole> joints_{}, bodies_{};
  std::vector<int> top_{}, silent_motors_{};
};

/// Joints that the transmission of an actuator acts on: its own, those of its tendon, those of the bodies that it pulls on.
std::vector<int> joints_of_actuator(const mjModel& m, int actuator);

}  // namespace stiction::world
