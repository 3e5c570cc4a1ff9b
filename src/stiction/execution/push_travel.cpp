#include "stiction/execution/push_travel.hpp"

#include <algorithm>

#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using world::BodyKind;
using world::Model;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

int body_of(const Model& model, int geometry) { return model.geometries()[at(geometry)].body; }

BodyKind kind_of(const Model& model, int geometry) { return model.bodies()[at(body_of(model, geometry))].kind; }

std::vector<int> pairs_of_robots_with_objects(const Model& model) {
  std::vector<int> out;
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    const BodyKind a = kind_of(model, model.pairs()[at(i)].geometry_a), b = kind_of(model, model.pairs()[at(i)].geometry_b);
    if ((a == BodyKind::Robot && b == BodyKind::Object) || (a == BodyKind::Object && b == BodyKind::Robot)) out.push_back(i);
  }
  return out;
}

}  // namespace

PushTravel::PushTravel(const Model& model)
    : model_(model), pairs_(pairs_of_robots_with_objects(model)), kinematics_work_(model), contact_work_(model) {}

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
    const world::Pair& pair = model_.pairs()[at(c.pair)];
    const bool a = kind_of(model_, pair.geometry_a) == BodyKind::Robot;
    const std::size_t body = at(body_of(model_, a ? pair.geometry_a : pair.geometry_b));
    const Eigen::Vector3d& p_W = a ? c.p_WA : c.p_WB;
    const world::Pose& X_WB = at_end.X_WB[body];
    most = std::max(most, (other.X_WB[body] * (X_WB.R.transpose() * (p_W - X_WB.p)) - p_W).norm());
  }
  return most;
}

}  // namespace stiction::execution
