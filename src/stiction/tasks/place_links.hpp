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

/// Bodies of moving links by that name, "robot/link" or "link": more than one where several robots have it.
std::vector<int> find_links(const world::Model& model, std::string_view name);

struct PlaceLinksOptions {
  int postures = 96;     ///< that the search starts from, ≥ 1; q alone where a link is dragged, whose joints should not leap
  bool overlap = false;  ///< postures in which something overlaps are as good as others
};

/// Joints with which links have poses, nearest to those of q in the sum of squares, without overlap: damped least squares
///
///     δ = Jᵀ (J Jᵀ + λ² I)⁻¹ e + (I − J⁺ J) (q₀ − q) ,
///
/// joints clamped to their limits, from q and from postures that are drawn around it farther and farther away, always the same ones.
/// @param q  configuration (n_q): objects stay, joints are the ones to be near to
/// @returns where no posture has the poses, the one that was found nearest to them
/// @throws core::InvalidInput: a body that no joint of a robot moves, no postures, a wrong size of q
/// Tests: tests/tasks/place_links_test.cpp
PlacedLinks place_links(const world::Model& model, const Eigen::VectorXd& q, std::span<const LinkTarget> targets,
                        const PlaceLinksOptions& options = {});

}  // namespace stiction::tasks
