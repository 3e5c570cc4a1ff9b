#pragma once

#include <Eigen/Core>
#include <cmath>

#include "stiction/world/model.hpp"

// Rotations from their rotation vectors θ, with K = [θ]×. Shared with trajopt.

namespace stiction::dynamics {

/// exp(θ) = 1 + sin‖θ‖/‖θ‖ K + (1 − cos‖θ‖)/‖θ‖² K² and its right Jacobian J_r: exp(θ + dθ) ≈ exp(θ) exp(J_r dθ).
struct So3 {
  explicit So3(const Eigen::Vector3d& theta) {
    const double angle2 = theta.squaredNorm();
    const double angle = std::sqrt(angle2);
    const bool small = angle < 1e-4;
    const double s = small ? 1 - angle2 / 6 : std::sin(angle) / angle;
    const double a = small ? 0.5 - angle2 / 24 : (1 - std::cos(angle)) / angle2;
    const double b = small ? 1.0 / 6 - angle2 / 120 : (angle - std::sin(angle)) / (angle2 * angle);
    Eigen::Matrix3d K;
    K << 0, -theta.z(), theta.y(), theta.z(), 0, -theta.x(), -theta.y(), theta.x(), 0;
    const Eigen::Matrix3d K2 = K * K;
    exp = Eigen::Matrix3d::Identity() + s * K + a * K2;
    right_jacobian = Eigen::Matrix3d::Identity() - a * K + b * K2;
  }
  Eigen::Matrix3d exp, right_jacobian;
};

inline Eigen::Matrix3d exp_so3(const Eigen::Vector3d& theta) { return So3(theta).exp; }
inline Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& theta) { return So3(theta).right_jacobian; }

/// Calls visit(row) with the first velocity index of every free rotation. Only there do tangent spaces turn.
template <class Visit>
void for_each_free_rotation(const world::Model& model, Visit&& visit) {
  for (const auto& object : model.objects()) {
    if (object.n_v == 6) visit(object.v_begin + 3);
  }
}

}  // namespace stiction::dynamics
