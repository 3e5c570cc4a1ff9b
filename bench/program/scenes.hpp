#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::app {

/// Where a step is timed, and the step before it.
struct State {
  Eigen::VectorXd q_before, u_before, q, u;
};

struct Scenario {
  std::shared_ptr<const world::Model> model;
  std::vector<State> states;
};

/// The stacking motion (models/stacking.yaml and its commands) rolled out with exact steps of h [s]: every step is a state.
/// @param models_dir  folder of stacking.yaml and stacking_commands.csv
Scenario make_stacking(const std::filesystem::path& models_dir, double h);

/// One body of 6 degrees of freedom that rests on the ground on n balls.
Scenario make_feet(int n);

/// A tower of n boxes that rests on the ground, four contacts each.
Scenario make_tower(int n);

}  // namespace stiction::app
