#pragma once

#include <optional>
#include <span>
#include <vector>

#include "stiction/dynamics/step.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::planning {

/// Share of the force that a fragile thing bears which a plan may use. Forces differ in the checker's replay, which has other steps.
inline constexpr double kMostPress = 0.95;

/// Limits on how hard a plan may press, the same for tree, regrasps and refinement.
class PressLimits {
 public:
  PressLimits(const world::Model& model, const world::RobotChains& chains, double brace_force);

  /// Largest ratio of the summed normal forces of a pair to the force that it bears (world::Pair::max_force); 0 if nothing is fragile.
  /// @param h  time step to which the impulses belong [s]
  double share(std::span<const dynamics::ContactImpulse> contacts, double h) const;
  bool fragile() const { return fragile_; }  ///< something in the scene is fragile
  /// True if the robot presses on itself or on fixed bodies with more than brace_force.
  bool braces(std::span<const dynamics::ContactImpulse> contacts, double h) const;

 private:
  const world::Model& model_;
  double brace_force_;
  bool fragile_ = false;
  std::vector<char> may_brace_;  ///< per pair: of the robot with itself or with a fixed body
};

/// Largest share() at the knots of a plan that has its contact forces; nullopt if nothing is fragile.
std::optional<double> largest_press(const world::Model& model, const Plan& plan);

}  // namespace stiction::planning
