#pragma once

#include <Eigen/Core>
#include <optional>

#include "stiction/world/model.hpp"

namespace stiction::execution {

/// How far a link would have to be moved along a direction so that its distance from a fixed body is `gap`, with everything else where it is [m]; negative: back.
/// nullopt: that direction leads past the body. Newton's method on the distance of the two, whose derivative is the normal along the direction.
/// @param start  where Newton's method begins [m]: where the two overlap, the shortest way out may be another one  @param q  (n_q)  @param link, body  of the model  @param direction_W  unit
/// Tests: tests/execution/guarded_test.cpp
std::optional<double> calc_approach(const world::Model& model, const Eigen::VectorXd& q, int link, int body,
                                    const Eigen::Vector3d& direction_W, double gap, double start = 0);

}  // namespace stiction::execution
