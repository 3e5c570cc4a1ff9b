#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Upper bound Σ_j ℓ_j |Δq_j| of the travel of any point of the robots on the straight line between two postures [m].
double calc_travel(const world::Model& model, const Eigen::VectorXd& from, const Eigen::VectorXd& to);

/// A polyline of postures in time, from rest to rest, on which no point of the robots is faster than `speed` (G.1). It does not stop at corners.
class JointPath {
 public:
  /// @param postures  at least one (n_a each)    @param speed  [m/s], > 0
  JointPath(const world::Model& model, std::vector<Eigen::VectorXd> postures, double speed);

  double duration() const { return duration_; }  ///< [s]
  /// Posture at a time since the start (n_a); the ends are held.
  Eigen::VectorXd at(double time) const;

 private:
  std::vector<Eigen::VectorXd> postures_;
  std::vector<double> travelled_;  ///< travel up to each posture [m]
  double duration_ = 0;
};

}  // namespace stiction::execution
