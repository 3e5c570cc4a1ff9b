#include "stiction/execution/closed_loop/active_hold.hpp"

#include <algorithm>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double kNear = 0.1;         ///< s, in L
constexpr double kChange = 50;        ///< w_du
constexpr double kStrain = 4e-5;      ///< w_s
constexpr double kGap = 0.026;        ///< w_φ
constexpr double kRate = 0.5;         ///< largest rate of a command, in d per second [1/s]
constexpr double kEffort = 0.9;       ///< share of a motor's effort that a command may ask for
constexpr double kBallRadius = 1.55;  ///< L of a ball in multiples of its radius

/// Branches of a robot that carry no other branch.
std::vector<const std::vector<int>*> find_tips(const world::Model& model, int robot) {
  std::vector<const std::vector<int>*> out;
  for (const std::vector<int>& chain : model.robots()[static_cast<std::size_t>(robot)].chains) {
    const bool carries = std::any_of(model.bodies().begin(), model.bodies().end(), [&](const world::Body& body) {
      return body.kind == world::BodyKind::Robot && body.owner == robot && !body.dofs.empty() && body.dofs.back() != chain.back() &&
             std::find(body.dofs.begin(), body.dofs.end(), chain.back()) != body.dofs.end();
    });
    if (!carries) out.push_back(&chain);
  }
  return out;
}

std::vector<int> find_pairs(const world::Model& model, int object, int last_dof) {
  std::vector<int> out;
  const auto body_of = [&](int geometry) -> const world::Body& {
    return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(geometry)].body)];
  };
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    const world::Pair& pair = model.pairs()[static_cast<std::size_t>(i)];
    const world::Body &a = body_of(pair.geometry_a), &b = body_of(pair.geometry_b);
    if (a.kind != world::BodyKind::Object || a.owner != object || b.kind != world::BodyKind::Robot) continue;
    if (!b.dofs.empty() && b.dofs.back() == last_dof) out.push_back(i);
  }
  return out;
}

dynamics::StepOptions make_step(double friction) {
  dynamics::StepOptions out;
  out.friction_scale = friction;
  return out;
}

}  // namespace

Fingers find_fingers(const world::Model& model, int object) {
  Fingers out;
  if (model.scene().objects[static_cast<std::size_t>(object)].joint != world::ObjectJoint::Free) return out;
  for (int robot = 0; robot < static_cast<int>(model.robots().size()); ++robot) {
    const auto tips = find_tips(model, robot);
    if (tips.size() < 2) continue;
    for (const std::vector<int>* chain : tips) {
      std::vector<int> joints;
      for (const int dof : *chain) joints.push_back(dof - model.n_vu());
      out.joints.insert(out.joints.end(), joints.begin(), joints.end());
      auto pairs = find_pairs(model, object, chain->back());
      if (pairs.empty()) continue;
      out.pairs.push_back(std::move(pairs));
      out.chains.push_back(std::move(joints));
    }
  }
  return out;
}

ActiveHold::ActiveHold(const std::shared_ptr<const world::Model>& model, int object, double friction)
    : model_(model),
      object_(object),
      v_begin_(model->objects()[static_cast<std::size_t>(object)].v_begin),
      fingers_(find_fingers(*model, object)),
      s_(kNear * model->scales().object(object).length),
      r_(model->scales().object(object).length / kBallRadius),
      exact_(make_step(friction)),
      smoothed_(make_step(friction)),
      exact_work_(model),
      smoothed_work_(model),
      geometry_(*model),
      kinematics_work_(*model),
      q_ref_(model->n_q()),
      error_(model->n_v()) {
  smoothed_.smoothing = dynamics::Analytic{.kappa = model->scales().kappa(object)};
  smoothed_.with_B = true;
  const auto n = static_cast<Index>(fingers_.joints.size());
  d_.resize(n), lift_.resize(n), row_.resize(n), gradient_.resize(n);
  const world::Scale scale = model->scales().object(object);
  for (Index j = 0; j < n; ++j) {
    const int joint = fingers_.joints[static_cast<std::size_t>(j)];
    const bool turns = model->dofs()[static_cast<std::size_t>(model->n_vu() + joint)].kind == world::DofKind::Revolute;
    d_[j] = turns ? 1 : scale.length;
    lift_[j] = turns ? scale.force * scale.length : scale.force;
  }
  qp_.reserve(n, 0);
  qp_work_.reserve(n, 0);
  std::size_t largest = 0;
  for (const std::vector<int>& support : model->supports()) largest = std::max(largest, support.size());
  jacobian_.resize(3 * largest);
}

void ActiveHold::start(VectorRef q) { q_ref_ = q; }

void ActiveHold::leave(int finger) { left_ = finger; }

bool ActiveHold::is_left(int joint) const {
  if (left_ < 0) return false;
  const std::vector<int>& chain = fingers_.chains[static_cast<std::size_t>(left_)];
  return std::find(chain.begin(), chain.end(), joint) != chain.end();
}

/// Moves the reference towards the object until it is within s.
void ActiveHold::draw_along(VectorRef q) {
  world::local(*model_, q, q_ref_, error_);
  const auto e = error_.segment<6>(v_begin_);
  const double far = std::max(e.head<3>().norm(), r_ * e.tail<3>().norm()) / s_;
  if (far <= 1) return;
  error_ /= far;
  world::retract(*model_, q, error_, q_ref_);
}

Status ActiveHold::predict(VectorRef q, const VectorXd& u) {
  if (const Status status = dynamics::step(*model_, {q, u}, exact_, exact_work_, next_); status != Status::Solved) return status;
  return dynamics::step(*model_, {q, u}, smoothed_, smoothed_work_, slope_);
}

/// Adds the cost weight (row · du + offset)².
void ActiveHold::add_row(double weight, double offset) {
  qp_.H.noalias() += weight * row_ * row_.transpose();
  gradient_ += weight * offset * row_;
}

void ActiveHold::add_pose() {
  world::local(*model_, q_ref_, next_.q_next, error_);
  for (int i = 0; i < 6; ++i) {
    const double scale = (i < 3 ? 1 : r_) / s_;
    for (Index j = 0; j < row_.size(); ++j) row_[j] = slope_.B(v_begin_ + i, fingers_.joints[static_cast<std::size_t>(j)]);
    add_row(scale * scale, error_[v_begin_ + i]);
  }
}

void ActiveHold::add_strain(const VectorXd& u) {
  const Index n = row_.size();
  for (Index i = 0; i < n; ++i) {
    const int joint = fingers_.joints[static_cast<std::size_t>(i)];
    const double K = model_->stiffness()[joint] / lift_[i];
    for (Index j = 0; j < n; ++j) row_[j] = -K * slope_.B(model_->n_vu() + joint, fingers_.joints[static_cast<std::size_t>(j)]);
    row_[i] += K;
    add_row(kStrain, K * (u[joint] - next_.q_next[model_->n_qu() + joint]));
  }
}

std::optional<FingerGap> ActiveHold::find_gap(int finger) {
  const std::vector<int>& pairs = fingers_.pairs[static_cast<std::size_t>(finger)];
  contact::query_pairs(*model_, kinematics_, pairs, std::numeric_limits<double>::infinity(), geometry_, contacts_);
  if (contacts_.empty()) return std::nullopt;
  const contact::Contact& nearest = *std::ranges::min_element(contacts_, {}, &contact::Contact::phi);
  contact::calc_jacobian(*model_, kinematics_, nearest, jacobian_.data());
  const std::vector<int>& dofs =
      model_->supports()[static_cast<std::size_t>(model_->pairs()[static_cast<std::size_t>(nearest.pair)].support)];
  return FingerGap{nearest.phi, dofs, {jacobian_.data(), 3, static_cast<Index>(dofs.size())}};
}

std::optional<FingerGap> ActiveHold::find_gap(VectorRef q, int finger) {
  world::calc_kinematics(*model_, q, kinematics_work_, kinematics_);
  return find_gap(finger);
}

void ActiveHold::add_gaps(VectorRef q) {
  world::calc_kinematics(*model_, q, kinematics_work_, kinematics_);
  for (int finger = 0; finger < static_cast<int>(fingers_.pairs.size()); ++finger) {
    if (finger == left_) continue;
    const std::optional<FingerGap> gap = find_gap(finger);
    if (!gap) continue;
    double next = gap->phi;
    row_.setZero();
    for (std::size_t k = 0; k < gap->dofs.size(); ++k) {
      const double slope = gap->J(0, static_cast<Index>(k));
      const int dof = gap->dofs[k];
      next += slope * next_.delta[dof];
      for (Index j = 0; j < row_.size(); ++j) row_[j] += slope * slope_.B(dof, fingers_.joints[static_cast<std::size_t>(j)]);
    }
    add_row(kGap / (s_ * s_), next);
  }
}

void ActiveHold::set_box(VectorRef q, const VectorXd& u, double period) {
  for (Index j = 0; j < row_.size(); ++j) {
    const int joint = fingers_.joints[static_cast<std::size_t>(j)];
    const double most = is_left(joint) ? 0 : kRate * d_[j] * period,
                 strain = kEffort * model_->effort()[joint] / model_->stiffness()[joint];
    const double at = q[model_->n_qu() + joint];
    // A command that is already beyond its bounds returns at the allowed rate.
    const double lower = std::max(model_->command_lower()[joint], at - strain) - u[joint],
                 upper = std::min(model_->command_upper()[joint], at + strain) - u[joint];
    qp_.lower[j] = std::clamp(lower, -most, most);
    qp_.upper[j] = std::max(qp_.lower[j], std::clamp(upper, -most, most));
  }
}

Status ActiveHold::update(VectorRef q, double period, VectorXd& u) {
  draw_along(q);
  if (const Status status = predict(q, u); status != Status::Solved) return status;
  qp_.H.setZero();
  gradient_.setZero();
  for (Index j = 0; j < d_.size(); ++j) qp_.H(j, j) = kChange / (d_[j] * d_[j]);
  add_pose();
  add_strain(u);
  add_gaps(q);
  set_box(q, u, period);
  qp_work_.factor = qp_.H;  // x̂ = −H⁻¹ g
  if (!control::factor_cholesky(qp_work_.factor, d_.size())) return Status::NumericalFailure;
  qp_.center = -gradient_;
  control::solve_cholesky(qp_work_.factor, d_.size(), qp_.center.data());
  if (const Status status = control::solve_bounded_qp(qp_, {}, qp_work_, solution_); status != Status::Solved) return status;
  for (Index j = 0; j < d_.size(); ++j) u[fingers_.joints[static_cast<std::size_t>(j)]] += solution_.x[j];
  return Status::Solved;
}

}  // namespace stiction::execution
