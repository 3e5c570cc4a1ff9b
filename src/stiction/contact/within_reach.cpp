#include "stiction/contact/within_reach.hpp"

#include <cmath>
#include <limits>

namespace stiction::contact {
namespace {

using world::Model;

/// Moves `center` to the middle of all its places. @returns how far it may be from there; infinite where nothing is known
double calc_reach(const Model& model, const world::Kinematics& kinematics, const Eigen::VectorXd& q, const std::vector<char>& moving,
                  const world::Body& body, Eigen::Vector3d& center) {
  double reach = 0;
  for (auto axis = body.axes.rbegin(); axis != body.axes.rend(); ++axis) {     // from the body towards the root
    if (*axis >= model.n_v()) return std::numeric_limits<double>::infinity();  // of a joint that follows another one
    const int j = *axis - model.n_vu();
    if (j < 0 || moving[static_cast<std::size_t>(j)] == 0) continue;
    if (model.dofs()[static_cast<std::size_t>(*axis)].kind == world::DofKind::Revolute) {
      const Eigen::Vector3d origin = kinematics.origin_W.col(*axis);
      reach += (center - origin).norm();
      center = origin;
    } else {
      const double middle = 0.5 * (model.lower()[j] + model.upper()[j]);
      if (!std::isfinite(middle)) return std::numeric_limits<double>::infinity();
      reach += model.upper()[j] - middle;
      center += (middle - q[model.n_qu() + j]) * kinematics.axis_W.col(*axis);
    }
  }
  return reach;
}

}  // namespace

bool may_touch(const Model& model, const world::Kinematics& kinematics, const Eigen::VectorXd& q, const std::vector<char>& moving,
               int pair) {
  const world::Pair& of = model.pairs()[static_cast<std::size_t>(pair)];
  Eigen::Vector3d centers[2];
  double reach = 0;
  for (int side = 0; side < 2; ++side) {
    const auto& geometry = model.geometries()[static_cast<std::size_t>(side == 0 ? of.geometry_a : of.geometry_b)];
    const auto& body = model.bodies()[static_cast<std::size_t>(geometry.body)];
    centers[side] = kinematics.X_WB[static_cast<std::size_t>(geometry.body)] * geometry.p_BCenter;
    reach += geometry.bounding_radius;
    if (body.kind == world::BodyKind::Robot) reach += calc_reach(model, kinematics, q, moving, body, centers[side]);
  }
  return !((centers[0] - centers[1]).norm() > reach);
}

}  // namespace stiction::contact
