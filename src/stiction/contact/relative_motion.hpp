#pragma once

#include <Eigen/Geometry>
#include <algorithm>

#include "stiction/contact/contact.hpp"
#include "stiction/world/axis.hpp"

namespace stiction::contact {

/// Calls add(axis, v, w) for every axis that moves a body of the contact. v = v_A(p_WA) − v_B(p_WB) and w = ω_A − ω_B are the relative
/// velocities due to this axis. An axis that moves both bodies only turns the gap.
/// @param kinematics  kinematics at the configuration of the contact
template <class Add>
void visit_relative_motion(const world::Model& model, const world::Kinematics& kinematics, const Contact& contact, const Add& add) {
  const world::Pair& pair = model.pairs()[static_cast<std::size_t>(contact.pair)];
  const auto axes_of = [&](int geometry) -> const std::vector<int>& {
    return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(geometry)].body)].axes;
  };
  const std::vector<int>&axes_a = axes_of(pair.geometry_a), &axes_b = axes_of(pair.geometry_b);
  const auto has = [](const std::vector<int>& axes, int column) { return std::find(axes.begin(), axes.end(), column) != axes.end(); };
  const auto visit = [&](int column, bool moves_a, bool moves_b) {
    const world::Axis axis = world::axis_at(model, column);
    const Eigen::Vector3d direction = kinematics.axis_W.col(column), origin = kinematics.origin_W.col(column);
    Eigen::Vector3d v = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();
    if (axis.kind == world::DofKind::Prismatic) {
      if (moves_a != moves_b) v = moves_a ? direction : Eigen::Vector3d(-direction);
    } else if (moves_a && moves_b) {
      v = direction.cross(contact.p_WA - contact.p_WB);
    } else {
      v = moves_a ? direction.cross(contact.p_WA - origin) : direction.cross(origin - contact.p_WB);
      w = moves_a ? direction : Eigen::Vector3d(-direction);
    }
    add(axis, v, w);
  };
  for (const int column : axes_a) visit(column, true, has(axes_b, column));
  for (const int column : axes_b) {
    if (!has(axes_a, column)) visit(column, false, true);
  }
}

}  // namespace stiction::contact
