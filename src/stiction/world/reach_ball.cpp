#include "stiction/world/reach_ball.hpp"

#include <cmath>
#include <limits>
#include <ranges>

#include "stiction/world/axis.hpp"

namespace stiction::world {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Index in q of the value of a velocity coordinate.
int index_in_q(const Model::Impl& m, int dof) {
  if (dof >= m.n_vu) return m.n_qu + dof - m.n_vu;
  const ObjectInfo& object = m.objects[at(m.dofs[at(dof)].owner)];
  return object.q_begin + dof - object.v_begin;
}

}  // namespace

Ball calc_reach_ball(const Model::Impl& m, const Kinematics& kinematics, const VectorRef& q, const Body& body, const Eigen::Vector3d& p_W,
                     std::span<const char> moving) {
  Ball ball{p_W, 0};
  for (const int axis : body.axes | std::views::reverse) {  // from the body towards the root
    const auto [v, kind, ratio] = axis_at(m.dofs, m.followers, axis);
    if (!moving.empty() && (v < m.n_vu || moving[at(v - m.n_vu)] == 0)) continue;
    const Dof& dof = m.dofs[at(v)];
    const Eigen::Vector3d along = kinematics.axis_W.col(axis);
    if (kind == DofKind::Revolute) {
      const Eigen::Vector3d origin = kinematics.origin_W.col(axis);
      const Eigen::Vector3d on_axis = origin + along * along.dot(ball.center - origin);
      ball.radius += (ball.center - on_axis).norm();
      ball.center = on_axis;
    } else {
      const double middle = 0.5 * (dof.lower + dof.upper);
      ball.radius += std::abs(ratio) * 0.5 * (dof.upper - dof.lower);
      if (!std::isfinite(ball.radius)) return {p_W, std::numeric_limits<double>::infinity()};
      ball.center += ratio * (middle - q[index_in_q(m, v)]) * along;
    }
  }
  return ball;
}

}  // namespace stiction::world
