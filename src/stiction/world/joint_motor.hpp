#pragma once

#include <span>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Least frequency √(K_a/armature) of a joint in a Model [rad/s]. At 20 rad/s a spring that its motor strains by the whole range of the joint moves the
/// joint through this range in about a tenth of a second. Joints with more armature have stronger commands in their maker's program: metaworld moves its
/// fingers of 100 kg with 390 N, which a spring of 400 N/m within their range of 40 mm does not give.
inline constexpr double kLeastFrequency = 20;

/// Inertia and damping that the file of a robot states for the motor of a joint; 0 where it states none. Only an MJCF states them. A leader has those
/// of its followers as well. The damping of the joint itself is Dof::damping.
struct JointMotor {
  double armature = 0;  ///< inertia at the joint, in a Model at most K_a/kLeastFrequency² [kg or kg·m²]
  double damping = 0;   ///< k_v of the position servo, its least damping; 0 if the scene gives another K_a [N·s/m or N·m·s/rad]
};

/// Motors of all robot joints (n_a).
std::span<const JointMotor> joint_motors(const Model& model);

}  // namespace stiction::world
