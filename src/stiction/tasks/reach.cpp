#include "stiction/tasks/reach.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stiction::tasks {
namespace {

using Eigen::Vector3d;

/// Half the edges of the box, along the axes, around a box with half edges h turned by R.
Vector3d turned(const Eigen::Matrix3d& R, const Vector3d& h) { return R.cwiseAbs() * h; }

}  // namespace

Reach::Reach(const world::Model& model) {
  std::vector<const world::Link*> link_of(model.bodies().size(), nullptr);
  for (const auto& link : model.links()) link_of[static_cast<std::size_t>(link.body)] = &link;
  for (const auto& geometry : model.geometries()) {
    const auto& body = model.bodies()[static_cast<std::size_t>(geometry.body)];
    if (body.kind != world::BodyKind::Robot || body.dofs.empty()) continue;
    Bound b{geometry.p_BCenter, geometry.bounding_radius, {}, {}};
    Vector3d middle = b.centre, half = Vector3d::Constant(b.radius);
    for (int at = geometry.body; at >= 0;) {
      const world::Link& link = *link_of[static_cast<std::size_t>(at)];
      if (link.dof >= 0) {
        const auto& dof = model.dofs()[static_cast<std::size_t>(link.dof)];
        const Vector3d& a = link.axis;
        if (dof.kind == world::DofKind::Prismatic) {
          const double travel = 0.5 * (dof.upper - dof.lower);
          b.centre += 0.5 * (dof.lower + dof.upper) * a;
          b.radius += travel;
          middle += 0.5 * (dof.lower + dof.upper) * a;
          half += travel * a.cwiseAbs();
        } else {
          const double along = a.dot(b.centre);
          b.radius += (b.centre - along * a).norm();
          b.centre = along * a;
          const double height = a.dot(middle), spread = a.cwiseAbs().dot(half);  // along the axis
          const double ring = (middle - height * a).norm() + half.norm();        // away from it
          for (int i = 0; i < 3; ++i) half[i] = std::abs(a[i]) * spread + ring * std::sqrt(std::max(0.0, 1 - a[i] * a[i]));
          middle = height * a;
        }
      }
      b.centre = link.X_PJ * b.centre;
      middle = link.X_PJ * middle;
      half = turned(link.X_PJ.R, half);
      at = link.parent;
    }
    b.lower = middle - half;
    b.upper = middle + half;
    bounds_.push_back(b);
  }
}

double Reach::distance(const Vector3d& centre, double radius) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Bound& b : bounds_) {
    const double ball = (centre - b.centre).norm() - b.radius;
    const double box = (centre - centre.cwiseMax(b.lower).cwiseMin(b.upper)).norm();
    const double bound = std::max(ball, box) - radius;
    nearest = std::min(nearest, std::isnan(bound) ? 0.0 : bound);  // ∞ − ∞: a slide without end
  }
  return nearest;
}

double Reach::radius() const {
  double largest = 0;
  for (const Bound& b : bounds_) largest = std::max(largest, b.radius);
  return largest;
}

}  // namespace stiction::tasks
