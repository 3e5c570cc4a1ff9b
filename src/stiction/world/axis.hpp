#pragma once

#include <span>

#include "stiction/world/model.hpp"

namespace stiction::world {

/// Meaning of a column of Kinematics: the axis of a velocity coordinate, or the axis of a joint that follows another one.
struct Axis {
  int dof;       ///< velocity coordinate that moves the axis
  DofKind kind;  ///< revolute or prismatic
  double ratio;  ///< motion about the axis per motion of the coordinate
};

/// Looks up the meaning of a column. @param column  column of Kinematics, as in Body::axes
inline Axis axis_at(std::span<const Dof> dofs, std::span<const Follower> followers, int column) {
  const auto at = static_cast<std::size_t>(column);
  if (at < dofs.size()) return {column, dofs[at].kind, 1};
  const Follower& follower = followers[at - dofs.size()];
  return {follower.dof, follower.kind, follower.ratio};
}

inline Axis axis_at(const Model& model, int column) { return axis_at(model.dofs(), model.followers(), column); }

}  // namespace stiction::world
