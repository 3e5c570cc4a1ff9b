#pragma once

#include <span>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Inertia and damping that the file of a robot states for the motor of a joint; 0 where it states none. Only an MJCF states them. A leader has those
/// of its followers as well. The damping of the joint itself is Dof::damping.
struct JointMotor {
  double armature = 0;  ///< inertia at the joint, in a Model at most K_a/(20 rad/s)² [kg or kg·m²]
  double damping = 0;   ///< k_v of the position servo, its least damping [N·s/m or N·m·s/rad]
};

/// Motors of all robot joints (n_a).
std::span<const JointMotor> joint_motors(const Model& model);

}  // namespace stiction::world
