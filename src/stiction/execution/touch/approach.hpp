#pragma once

#include <Eigen/Core>
#include <optional>

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// Computes how far a link would have to move along a direction until its distance from a fixed body is `gap`, with everything else in place [m]; negative:
/// back. Uses Newton's method on the distance of the two bodies, whose derivative is the normal along the direction.
/// @param q  configuration (n_q)  @param link, body  bodies of the model  @param direction_W  unit
/// @param start  start of Newton's method [m]; needed if the two overlap and the shortest way out would be another one
/// @returns nullopt if the direction leads past the body
/// Tests: tests/execution/guarded_test.cpp
std::optional<double> calc_approach(const world::Model& model, const Eigen::VectorXd& q, int link, int body,
                                    const Eigen::Vector3d& direction_W, double gap, double start = 0);

}  // namespace stiction::execution
