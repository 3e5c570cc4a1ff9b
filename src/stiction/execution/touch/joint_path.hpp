#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Σ_j ℓ_j |Δq_j|: no point of the robots travels farther on the straight line between two postures [m].
double calc_travel(const world::Model& model, const Eigen::VectorXd& from, const Eigen::VectorXd& to);

/// A polyline of postures, followed from rest to rest so that no point of the robots is faster than `speed`, (G.1). Corners are not stopped at.
class JointPath {
 public:
  /// @param postures  (n_a) each, at least one    @param speed  [m/s], > 0
  JointPath(const world::Model& model, std::vector<Eigen::VectorXd> postures, double speed);

  double duration() const { return duration_; }  ///< [s]
  /// The posture at a time since its start; the ends are held.
  Eigen::VectorXd at(double time) const;

 private:
  std::vector<Eigen::VectorXd> postures_;
  std::vector<double> travelled_;  ///< up to each posture [m]
  double duration_ = 0;
};

}  // namespace stiction::execution
