#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Fast kinematics if only a few joints move and only a few bodies matter, as in a search that brings one finger into contact.
class MovingLinks {
 public:
  /// Selects the links that the moving joints move, among the given bodies and the links that carry them.
  /// @param moving  per joint of the robots (n_a): 1 if it moves, else 0
  void select(const Model& model, std::span<const char> moving, std::span<const int> bodies);

  /// Updates `out` for the selected links, with the same bits as calc_kinematics(); the rest of `out` stays unchanged. Joints that do not move must
  /// have the values with which `out` was computed.
  void update(const Model& model, const Eigen::VectorXd& q, Kinematics& out) const;

 private:
  std::vector<int> links_;
  std::vector<char> marked_;  // per body: selected
};

}  // namespace stiction::world
