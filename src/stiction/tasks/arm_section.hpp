#pragma once

#include <filesystem>
#include <span>

#include "stiction/execution/contact_control/control_scenario.hpp"
#include "stiction/world/yaml.hpp"

// Internal to the layer: sections shared by all scenarios of an arm.

namespace stiction::tasks {

/// Reads the keys name, description, scene, start, controller, plant, estimator of a map. If `out` already has a model, the model and its
/// start stay. @throws core::InvalidInput
void read_arm(const world::YamlNode& top, std::span<const std::filesystem::path> package_dirs, execution::ControlScenario& out);

/// Reads joint positions within their limits (n_a). @throws core::InvalidInput
Eigen::VectorXd read_posture(const world::YamlNode& node, const world::Model& model);

/// Finds the body of a robot link by its name. @throws core::InvalidInput listing the known names
int find_link(const world::Model& model, const world::YamlNode& node);

}  // namespace stiction::tasks
