#include "stiction/planning/drag.hpp"

#include <algorithm>

namespace stiction::planning {
namespace {

constexpr double kLeastInterval = 1e-3;  // of a command that moves nothing [s]
constexpr int kPauses = 4;               // steps in which a pause is looked at

}  // namespace

Drag::Drag(const world::Model& model, const Eigen::VectorXd& q, double rest_time)
    : model_(&model), speeds_(limits_.of_joints(model)), damping_(Eigen::VectorXd::Zero(model.n_v())) {
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  for (std::size_t i = 0; i < model.objects().size(); ++i) {
    if (model.scene().objects[i].joint == world::ObjectJoint::Free) continue;
    const auto& object = model.objects()[i];
    Eigen::MatrixXd M(object.n_v, object.n_v);
    world::calc_object_mass(model, kinematics, static_cast<int>(i), M);
    damping_.segment(object.v_begin, object.n_v) = M.diagonal() / rest_time;
    acts_ = true;
  }
}

core::Status Drag::push(const Eigen::MatrixXd& commands, const dynamics::StepOptions& options, dynamics::StepWorkspace& work,
                        dynamics::StepResult& result, Eigen::VectorXd& q, Eigen::VectorXd& u, long& steps) const {
  Eigen::VectorXd damping;  // such that −damping δq/h is the force −D δq/Δt
  const auto go = [&](const Eigen::VectorXd& to, double duration) {
    damping = options.h / duration * damping_;
    ++steps;
    const core::Status status = dynamics::step(*model_, {q, to, nullptr, acts_ ? &damping : nullptr}, options, work, result);
    if (status == core::Status::Solved) {
      q = result.q_next;
      u = to;
    }
    return status;
  };
  work.forget();
  for (Eigen::Index k = 0; k < commands.cols(); ++k) {
    const Eigen::VectorXd to = commands.col(k);
    if (const core::Status status = go(to, std::max(calc_duration(u, to, speeds_), kLeastInterval)); status != core::Status::Solved)
      return status;
  }
  for (int k = 0; acts_ && k < kPauses; ++k) {
    const Eigen::VectorXd to = u;
    if (const core::Status status = go(to, limits_.pause / kPauses); status != core::Status::Solved) return status;
  }
  return core::Status::Solved;
}

}  // namespace stiction::planning
