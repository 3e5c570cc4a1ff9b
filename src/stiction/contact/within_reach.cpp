#include "stiction/contact/within_reach.hpp"

#include "stiction/world/reach_ball.hpp"

namespace stiction::contact {

bool may_touch(const world::Model& model, const world::Kinematics& kinematics, const Eigen::VectorXd& q, const std::vector<char>& moving,
               int pair) {
  const world::Pair& of = model.pairs()[static_cast<std::size_t>(pair)];
  Eigen::Vector3d between = Eigen::Vector3d::Zero();
  double reach = 0;
  for (const int g : {of.geometry_a, of.geometry_b}) {
    const auto& geometry = model.geometries()[static_cast<std::size_t>(g)];
    const auto& body = model.bodies()[static_cast<std::size_t>(geometry.body)];
    const Eigen::Vector3d center = kinematics.X_WB[static_cast<std::size_t>(geometry.body)] * geometry.p_BCenter;
    const world::Ball ball = world::calc_reach_ball(model.impl(), kinematics, q, body, center, moving);
    between = ball.center - between;
    reach += ball.radius + geometry.bounding_radius;
  }
  return !(between.norm() > reach);
}

}  // namespace stiction::contact
