#pragma once

#include <optional>
#include <span>
#include <vector>

#include "stiction/dynamics/step.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::planning {

/// Share of what a fragile thing bears that a plan uses: its replay at other steps, which the checker judges, has other forces.
inline constexpr double kMostPress = 0.95;

/// How hard a plan may press: one verdict of tree, regrasps and refinement.
class PressLimits {
 public:
  PressLimits(const world::Model& model, const world::RobotChains& chains, double brace_force);

  /// Largest sum of the normal forces of a pair as a share of what it bears (world::Pair::max_force); 0 where nothing is fragile.
  /// @param h  of the step that the impulses are of [s]
  double share(std::span<const dynamics::ContactImpulse> contacts, double h) const;
  bool fragile() const { return fragile_; }  ///< something is
  /// The robot presses on itself or on what does not move with more than brace_force.
  bool braces(std::span<const dynamics::ContactImpulse> contacts, double h) const;

 private:
  const world::Model& model_;
  double brace_force_;
  bool fragile_ = false;
  std::vector<char> may_brace_;  ///< per pair: of the robot with itself or with what does not move
};

/// Largest share at the knots of a plan that has its forces; nullopt where nothing is fragile.
std::optional<double> largest_press(const world::Model& model, const Plan& plan);

}  // namespace stiction::planning
