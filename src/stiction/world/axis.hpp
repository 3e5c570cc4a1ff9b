#pragma once

#include <span>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// What a column of Kinematics stands for: an axis of its own, or that of a joint that follows another one.
struct Axis {
  int dof;       ///< coordinate by which it moves
  DofKind kind;  ///< it turns, or slides
  double ratio;  ///< of its motion to that of the coordinate
};

/// @param column  of Kinematics, as in Body::axes
inline Axis axis_at(std::span<const Dof> dofs, std::span<const Follower> followers, int column) {
  const auto at = static_cast<std::size_t>(column);
  if (at < dofs.size()) return {column, dofs[at].kind, 1};
  const Follower& follower = followers[at - dofs.size()];
  return {follower.dof, follower.kind, follower.ratio};
}

inline Axis axis_at(const Model& model, int column) { return axis_at(model.dofs(), model.followers(), column); }

}  // namespace stiction::world
