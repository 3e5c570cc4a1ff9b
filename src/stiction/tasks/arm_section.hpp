#pragma once

#include <filesystem>
#include <span>

#include "stiction/execution/contact_control/control_scenario.hpp"
#include "stiction/world/yaml.hpp"

// Internal to the layer: what scenarios of an arm have in common.

namespace stiction::tasks {

/// The keys name, description, scene, start, controller, plant, estimator of a map; where `out` has a model, that and its start stay. @throws core::InvalidInput
void read_arm(const world::YamlNode& top, std::span<const std::filesystem::path> package_dirs, execution::ControlScenario& out);

/// Joints within their limits (n_a). @throws core::InvalidInput
Eigen::VectorXd read_posture(const world::YamlNode& node, const world::Model& model);

/// The body of a link of a robot, by its name. @throws core::InvalidInput with the names that there are
int find_link(const world::Model& model, const world::YamlNode& node);

}  // namespace stiction::tasks
