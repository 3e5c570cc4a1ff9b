#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>

#include "stiction/core/status.hpp"
#include "stiction/world/model.hpp"

namespace stiction::tasks {

/// Where a link is to be; its orientation is free without one.
struct LinkTarget {
  int body = -1;  ///< of a robot
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  std::optional<Eigen::Matrix3d> R_WB{};
};

struct PlacedLinks {
  /// Solved; MaxIterations: no posture inside the limits has the poses; NumericalFailure: those that have them overlap something
  core::Status status = core::Status::MaxIterations;
  Eigen::VectorXd q;               ///< the posture that was found; else the nearest to one
  double position = 0, angle = 0;  ///< how far a link is from where it is to be there, at most [m, rad]
  int pair = -1;                   ///< that overlaps there most
  double depth = 0;                ///< by how much [m]
};

/// Joints with which links have poses, nearest to those of q in the sum of squares, without overlap: damped least squares
///
///     δ = Jᵀ (J Jᵀ + λ² I)⁻¹ e + (I − J⁺ J) (q₀ − q) ,
///
/// joints clamped to their limits, from q and from postures that are drawn around it farther and farther away, always the same ones.
/// @param q  configuration (n_q): objects stay, joints are the ones to be near to
/// Tests: tests/tasks/place_links_test.cpp
PlacedLinks place_links(const world::Model& model, const Eigen::VectorXd& q, std::span<const LinkTarget> targets);

}  // namespace stiction::tasks
