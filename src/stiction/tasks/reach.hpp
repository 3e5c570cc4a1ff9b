#pragma once

#include "stiction/world/model.hpp"

namespace stiction::tasks {

/// Lower bounds on the distance between robot shapes and a ball, over all joint positions inside their limits.
///
/// The space that a shape can reach is carried from its link to the world, joint by joint, as a ball and as an axis-aligned box:
///   revolute   ball: centre on the axis, radius r + distance from it; box: around the ring that the box sweeps
///   prismatic  both grow by the travel (the box along the axis only)
/// The distance is the larger one of the two bounds; each is valid by itself. Half-spaces reach everything.
class Reach {
 public:
  explicit Reach(const world::Model& model);
  /// Lower bound for the nearest moving robot shape [m]; ∞ if there is none. @param centre in W [m]  @param radius [m]
  double distance(const Eigen::Vector3d& centre, double radius) const;
  /// Radius of the largest ball that bounds what a shape reaches [m]; 0 without robots.
  double radius() const;

 private:
  struct Bound {
    Eigen::Vector3d centre;  ///< of the ball
    double radius;
    Eigen::Vector3d lower, upper;  ///< of the box
  };
  std::vector<Bound> bounds_;
};

}  // namespace stiction::tasks
