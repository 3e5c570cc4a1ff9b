#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Kinematics where few joints move and few bodies matter, as in a search that brings one finger into contact.
class MovingLinks {
 public:
  /// The links that these joints move on the way to the given bodies.
  /// @param moving  joints of the robots, 0 or 1 each (n_a)
  void select(const Model& model, std::span<const char> moving, std::span<const int> bodies);

  /// calc_kinematics() for the links selected, to the bit; the rest of `out` stays. Joints that are not moving are where they were when `out`
  /// was computed.
  void update(const Model& model, const Eigen::VectorXd& q, Kinematics& out) const;

 private:
  std::vector<int> links_;
  std::vector<char> marked_;  // per body
};

}  // namespace stiction::world
