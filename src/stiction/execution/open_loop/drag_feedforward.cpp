#include "stiction/execution/open_loop/drag_feedforward.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/world/object_space.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

/// Share of a motor's effort for planned torques and damping together.
constexpr double kEffortShare = 0.8;

}  // namespace

Eigen::VectorXd calc_object_damping(const world::Model& model) {
  Eigen::VectorXd damping = Eigen::VectorXd::Zero(model.n_v());
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, model.neutral(), work, kinematics);
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    const auto& object = model.objects()[i];
    if (model.scene().objects[i].joint == world::ObjectJoint::Free) continue;
    for (int v = object.v_begin; v < object.v_begin + object.n_v; ++v) damping[v] = model.dofs()[static_cast<std::size_t>(v)].damping;
    Eigen::MatrixXd M(object.n_v, object.n_v);
    world::calc_object_mass(model, kinematics, static_cast<int>(i), M);
    damping.segment(object.v_begin, object.n_v) += M.diagonal() / kRestTime;
  }
  return damping;
}

DragFeedforward::DragFeedforward(std::shared_ptr<const world::Model> model)
    : model_(std::move(model)), damping_(calc_object_damping(*model_)), work_(model_) {}

double DragFeedforward::speed_within_motors(const Eigen::VectorXd& strain, const Eigen::VectorXd& lead) const {
  double speed = 1;
  for (int j = 0; j < model_->n_a(); ++j) {
    const double bears = kEffortShare * model_->effort()[j] / model_->stiffness()[j] - std::abs(strain[j]);
    const double room = std::isfinite(bears) ? std::max(bears, 0.0) : kStray * model_->scales().joints()[j];
    if (std::abs(lead[j]) * speed > room) speed = room / std::abs(lead[j]);
  }
  return speed;
}

DragFeedforward::Lead DragFeedforward::calc(const planning::Plan& plan, const Eigen::VectorXd& q, const Eigen::VectorXd& u,
                                            const Eigen::VectorXd& q_next, double duration, double unled) {
  Lead out{Eigen::VectorXd::Zero(model_->n_a()), 1};
  Eigen::VectorXd planned(model_->n_v());
  world::local(*model_, q, q_next, planned);
  const Eigen::VectorXd strain = u - q_next.tail(model_->n_a());
  for (double speed = 1; speed >= unled; speed /= 2) {
    const Eigen::VectorXd damping = speed * plan.step.h / duration * damping_;
    Eigen::VectorXd command;
    if (!dynamics::find_command(*model_, {q, u, planned, damping}, plan.step, work_, result_, command)) continue;
    out.strain = (command - u) / speed;
    const double most = speed_within_motors(strain, out.strain);
    out.speed = std::clamp(most, unled, speed);
    out.strain *= std::min(1.0, most / out.speed);
    return out;
  }
  out.speed = unled;
  return out;
}

}  // namespace stiction::execution
