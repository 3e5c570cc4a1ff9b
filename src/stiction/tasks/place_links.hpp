#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/core/status.hpp"
#include "stiction/world/model.hpp"

namespace stiction::tasks {

/// Target pose of a link; without a rotation its orientation is free.
struct LinkTarget {
  int body = -1;  ///< body of a robot link
  Eigen::Vector3d p_WB = Eigen::Vector3d::Zero();
  std::optional<Eigen::Matrix3d> R_WB{};
};

struct PlacedLinks {
  /// Solved; MaxIterations: no posture inside the limits reaches the poses; NumericalFailure: all postures that reach them overlap
  /// something
  core::Status status = core::Status::MaxIterations;
  Eigen::VectorXd q;               ///< the posture found, otherwise the one nearest to the poses
  double position = 0, angle = 0;  ///< largest error of a link in this posture [m, rad]
  int pair = -1;                   ///< pair with the deepest overlap in this posture
  double depth = 0;                ///< depth of this overlap [m]
};

/// Bodies of moving links with the name "robot/link" or "link"; more than one if several robots have such a link.
std::vector<int> find_links(const world::Model& model, std::string_view name);

struct PlaceLinksOptions {
  int postures = 96;     ///< number of start postures of the search, ≥ 1; with 1 only q, for dragging a link without joint jumps
  bool overlap = false;  ///< accept postures with overlaps
};

/// Finds joint positions that bring links to their poses without overlap, nearest to those of q in the sum of squares (inverse kinematics
/// by damped least squares):
///
///     δ = Jᵀ (J Jᵀ + λ² I)⁻¹ e + (I − J⁺ J) (q₀ − q) ,
///
/// with joints clamped to their limits. The search starts from q and from postures drawn around it at growing distances, always the same
/// ones.
/// @param q  configuration (n_q): objects stay; its joints are the reference to stay near to
/// @returns the posture; if none reaches the poses, the one nearest to them
/// @throws core::InvalidInput: a body that no joint of a robot moves, no postures, a wrong size of q
/// Tests: tests/tasks/place_links_test.cpp
PlacedLinks place_links(const world::Model& model, const Eigen::VectorXd& q, std::span<const LinkTarget> targets,
                        const PlaceLinksOptions& options = {});

}  // namespace stiction::tasks
