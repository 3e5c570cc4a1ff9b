#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "stiction/execution/contact_control/control_scenario.hpp"
#include "stiction/world/scene.hpp"

namespace stiction::execution {

/// A fixed body that is in the world and not in the model. Where it is may differ from seed to seed.
struct UnknownBody {
  world::FixedSpec body;
  Eigen::Vector3d position_spread = Eigen::Vector3d::Zero();  ///< its place is drawn uniformly within ± this [m], ≥ 0
  double yaw_spread = 0;                                      ///< and its turn about z of W, through its place [rad], ≥ 0
};

/// An arm that goes to a posture among things that it does not know, as a YAML file says (tasks/touch_scenario_file.hpp).
struct TouchScenario {
  ControlScenario arm;      ///< what is known: model, start, controller, plant, estimator. Without a reference; contacts are estimated
  Eigen::VectorXd goal;     ///< joints (n_a)
  double speed = 0.15;      ///< of any point of the arm, at most [m/s]
  int max_touches = 20;     ///< after which the arm gives up, ≥ 1
  double tolerance = 0.01;  ///< of the largest joint at the goal [rad, L of the robots]
  std::vector<UnknownBody> unknown;
};

/// The known scene and what is not known, in the places of this seed.
/// @throws core::InvalidInput: the arm at its start touches something
std::shared_ptr<const world::Model> make_world(const TouchScenario& scenario, std::uint64_t seed);

}  // namespace stiction::execution
