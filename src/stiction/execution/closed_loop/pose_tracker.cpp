#include "stiction/execution/closed_loop/pose_tracker.hpp"

#include <algorithm>

#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double kBeside = 5;       ///< w_u
constexpr double kChange = 20;      ///< w_du
constexpr double kMostStep = 0.15;  ///< largest δ, in d

}  // namespace

PoseTracker::PoseTracker(const std::shared_ptr<const world::Model>& model, const planning::Goal& goal, const dynamics::StepOptions& options)
    : model_(model), exact_(options), smoothed_(options), exact_work_(model), smoothed_work_(model) {
  exact_.smoothing = dynamics::Exact{};
  exact_.with_A = exact_.with_B = exact_.with_force_derivatives = false;
  smoothed_ = exact_;
  smoothed_.smoothing = dynamics::Analytic{.kappa = model->scales().kappa(goal.object)};
  smoothed_.friction_law = dynamics::FrictionLaw::Anitescu;
  smoothed_.contacts_within_reach = false;
  smoothed_.with_B = true;
  const Index n = model->n_a();
  const world::ObjectInfo& object = model->objects()[static_cast<std::size_t>(goal.object)];
  weight_ = VectorXd::Zero(model->n_vu());
  weight_.segment(object.v_begin, object.n_v) = planning::inverse_tolerances(*model, goal).segment(object.v_begin, object.n_v);
  delta_ = gradient_ = VectorXd::Zero(n);
  error_.resize(model->n_v());
  qp_.reserve(n, 0);
  qp_work_.reserve(n, 0);
}

Status PoseTracker::update(const VectorXd& q, const VectorXd& q_plan, const VectorXd& u_plan) {
  const VectorXd& d = model_->scales().joints();
  const VectorXd u = u_plan + delta_;
  if (const Status status = dynamics::step(*model_, {q, u}, exact_, exact_work_, next_); status != Status::Solved) return status;
  if (const Status status = dynamics::step(*model_, {q, u}, smoothed_, smoothed_work_, slope_); status != Status::Solved) return status;
  world::local(*model_, q_plan, next_.q_next, error_);
  qp_.H.setZero();
  for (Index j = 0; j < d.size(); ++j) {
    qp_.H(j, j) = (kBeside + kChange) / (d[j] * d[j]);
    gradient_[j] = kBeside * delta_[j] / (d[j] * d[j]);
    qp_.lower[j] = std::max(-kMostStep * d[j], model_->command_lower()[j] - u_plan[j]) - delta_[j];
    qp_.upper[j] = std::max(qp_.lower[j], std::min(kMostStep * d[j], model_->command_upper()[j] - u_plan[j]) - delta_[j]);
  }
  for (Index i = 0; i < weight_.size(); ++i) {
    if (weight_[i] == 0) continue;
    const double w = weight_[i] * weight_[i];
    qp_.H.noalias() += w * slope_.B.row(i).transpose() * slope_.B.row(i);
    gradient_ += w * error_[i] * slope_.B.row(i).transpose();
  }
  qp_work_.factor = qp_.H;  // x̂ = −H⁻¹ g
  if (!control::factor_cholesky(qp_work_.factor, d.size())) return Status::NumericalFailure;
  qp_.center = -gradient_;
  control::solve_cholesky(qp_work_.factor, d.size(), qp_.center.data());
  if (const Status status = control::solve_bounded_qp(qp_, {}, qp_work_, solution_); status != Status::Solved) return status;
  delta_ += solution_.x;
  return Status::Solved;
}

}  // namespace stiction::execution
