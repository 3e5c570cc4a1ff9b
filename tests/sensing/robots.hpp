#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "stiction/world/model.hpp"

namespace stiction::sensing::test {

inline constexpr const char* kUr5 = "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf";
inline constexpr const char* kPanda = "package://example-robot-data/robots/panda_description/urdf/panda.urdf";
inline constexpr const char* kIiwa = "models/iiwa_primitives.urdf";

/// A robot named "robot" of a URDF in memory.
std::shared_ptr<const world::Model> make_robot(const std::string& urdf);

/// A robot named "arm" of a package or of the source tree.
std::shared_ptr<const world::Model> make_arm(const std::string& urdf);

int body_index(const world::Model& model, std::string_view name);

}  // namespace stiction::sensing::test
