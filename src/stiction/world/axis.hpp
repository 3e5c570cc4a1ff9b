#pragma once

#include "stiction/world/model.hpp"

namespace stiction::world {

/// What a column of Kinematics stands for: an axis of its own, or that of a joint that follows another one.
struct Axis {
  int dof;       ///< coordinate by which it moves
  DofKind kind;  ///< it turns, or slides
  double ratio;  ///< of its motion to that of the coordinate
};

/// @param column  of Kinematics, as in Body::axes
inline Axis axis_at(const Model& model, int column) {
  if (column < model.n_v()) return {column, model.dofs()[static_cast<std::size_t>(column)].kind, 1};
  const Follower& follower = model.followers()[static_cast<std::size_t>(column - model.n_v())];
  return {follower.dof, follower.kind, follower.ratio};
}

}  // namespace stiction::world
