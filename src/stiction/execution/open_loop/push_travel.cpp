#include "stiction/execution/open_loop/push_travel.hpp"

#include <algorithm>

#include "stiction/world/robot_chains.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using world::Model;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

PushTravel::PushTravel(const Model& model) : model_(model), kinematics_work_(model), contact_work_(model) {
  const world::RobotChains chains(model);
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    if (chains.touches_object(i) && chains.mask_of_pair(i) != 0) pairs_.push_back(i);
  }
}

double PushTravel::calc(const Eigen::VectorXd& q0, const Eigen::VectorXd& q1) {
  world::calc_kinematics(model_, q0, kinematics_work_, from_);
  world::calc_kinematics(model_, q1, kinematics_work_, to_);
  return std::max({calc_of_objects(), calc_of_contacts(from_, to_), calc_of_contacts(to_, from_)});
}

double PushTravel::calc_of_objects() const {
  double most = 0;
  for (int o = 0; o < static_cast<int>(model_.objects().size()); ++o) {
    const int body = model_.objects()[at(o)].body;
    const world::Pose &X0 = from_.X_WB[at(body)], &X1 = to_.X_WB[at(body)];
    const double turn = Eigen::AngleAxisd(X0.R.transpose() * X1.R).angle();
    for (const world::Geometry& g : model_.geometries()) {
      if (g.body != body) continue;
      const double radius = std::min(g.bounding_radius, 0.5 * model_.scales().object(o).length);
      most = std::max(most, (X1 * g.p_BCenter - X0 * g.p_BCenter).norm() + turn * radius);
    }
  }
  return most;
}

double PushTravel::calc_of_contacts(const world::Kinematics& at_end, const world::Kinematics& other) {
  double most = 0;
  contact::query_pairs(model_, at_end, pairs_, world::share::kContact * model_.scales().robots().length, contact_work_, contacts_);
  for (const contact::Contact& c : contacts_) {
    const int robot = model_.pairs()[at(c.pair)].geometry_b;  // in a pair, the object comes first
    const std::size_t body = at(model_.geometries()[at(robot)].body);
    const world::Pose& X_WB = at_end.X_WB[body];
    most = std::max(most, (other.X_WB[body] * (X_WB.R.transpose() * (c.p_WB - X_WB.p)) - c.p_WB).norm());
  }
  return most;
}

}  // namespace stiction::execution
