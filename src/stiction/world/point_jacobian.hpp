#pragma once

#include <Eigen/Core>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Computes the Jacobian of a point of `body` by the robot joints: rows 0–2 of J are J(p) with ṗ = J(p) q̇ᵃ [m/rad], rows 3–5 are J(ω) of the body
/// [rad/rad], all in W. The motion of followers counts for their leader.
/// @param p_W  the point [m]    @param J  (6 × n_a), filled
/// Tests: tests/control/point_jacobian_test.cpp (central differences)
void calc_point_jacobian(const Model& model, const Kinematics& kinematics, int body, const Eigen::Vector3d& p_W,
                         Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& J);

}  // namespace stiction::world
