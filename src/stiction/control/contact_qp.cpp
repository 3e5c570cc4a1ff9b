#include "stiction/control/contact_qp.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "stiction/core/invalid_input.hpp"

namespace stiction::control {

using core::Status;
using Eigen::Index;

void RobotLimits::validate() const {
  const Index n = stiffness.size();
  const auto require_size = [n](const char* field, const Eigen::VectorXd& v) { core::require_size(field, v.size(), n); };
  require_size("rate", rate), require_size("lower", lower), require_size("upper", upper), require_size("torque", torque);
  for (Index j = 0; j < n; ++j) {
    core::require_positive("stiffness", stiffness[j]);
    core::require_positive("rate", rate[j]);
    if (!(torque[j] > 0)) core::throw_invalid("torque", std::to_string(torque[j]), "a number > 0, or infinity");
    if (!(lower[j] <= upper[j])) core::throw_invalid("lower", std::to_string(lower[j]), "at most `upper`, " + std::to_string(upper[j]));
  }
}

void ContactQpOptions::validate() const {
  core::require_positive("epsilon", epsilon);
  core::require_positive("posture_weight", posture_weight);
  core::require_positive("contact_compliance", contact_compliance);
  core::require_positive("least_lever", least_lever);
  core::require_positive("unilateral_priority", unilateral_priority);
  if (!(force_priority > unilateral_priority && force_priority <= 1e7))
    core::throw_invalid("force_priority", std::to_string(force_priority), "a number above unilateral_priority, at most 1e7");
  if (!(solver.tolerance > 0 && solver.tolerance <= 1e-6))
    core::throw_invalid("solver.tolerance", std::to_string(solver.tolerance), "a number in (0, 1e-6]");
}

bool ContactQpResult::within_limits(double force) const {
  const auto at_most = [](const auto& v, double most) { return v.size() == 0 || v.maxCoeff() <= most; };
  return at_most(slack, force) && at_most(torque_slack, 0) && at_most(limit_slack, 0);
}

void ContactQpWorkspace::reserve(Index n, Index contacts) {
  qp.reserve(n, 2 * contacts);
  solver.reserve(n, 2 * contacts);
  solution.x.setZero(n), solution.z.setZero(n);
  solution.y.setZero(2 * contacts), solution.slack.setZero(2 * contacts);
  G.setZero(contacts, contacts), LJ.setZero(contacts, n);
  compliance.setZero(contacts), lambda0.setZero(contacts), column.setZero(contacts);
  offset.setZero(n), residual.setZero(n);
}

namespace {

std::span<const double> span(VectorRef v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

void require(const RobotLimits& robot, const ContactQpInput& in) {
  const Index n = robot.stiffness.size(), m = in.J_u.rows();
  core::require_size("q", in.q.size(), n);
  core::require_size("q_cmd", in.q_cmd.size(), n);
  core::require_size("q_ref", in.q_ref.size(), n);
  if (m > 0) core::require_size("J_u.cols", in.J_u.cols(), n);
  if (m > kMaxContacts) core::throw_invalid("J_u.rows", std::to_string(m), "at most " + std::to_string(kMaxContacts));
  core::require_size("lambda", in.lambda.size(), m);
  core::require_size("lambda_max", in.lambda_max.size(), m);
  core::require_finite("q", span(in.q));
  core::require_finite("q_cmd", span(in.q_cmd));
  core::require_finite("q_ref", span(in.q_ref));
  core::require_finite("lambda", span(in.lambda));
  for (const double bound : in.lambda_max) core::require_positive("lambda_max", bound);
  for (Index i = 0; i < m; ++i)
    for (Index j = 0; j < n; ++j) core::require_finite("J_u", in.J_u(i, j));
  if (!in.groups.empty()) core::require_size("groups", static_cast<long>(in.groups.size()), m);
  core::require_nonnegative("damping", in.damping);
  if (in.task_jacobian == nullptr) return;
  core::require_size("task_jacobian.cols", in.task_jacobian->cols(), n);
  core::require_size("task_error", in.task_error == nullptr ? 0 : in.task_error->size(), in.task_jacobian->rows());
  if (!in.task_jacobian->allFinite()) core::throw_invalid("task_jacobian", "a number that is not finite", "finite numbers");
  core::require_finite("task_error", span(*in.task_error));
}

/// Builds and solves the program of one tick: (C.10) in d = q_cmd − q_cmd⁻.
class Tick {
 public:
  Tick(const RobotLimits& robot, const ContactQpInput& in, const ContactQpOptions& options, ContactQpWorkspace& work, ContactQpResult& out)
      : robot_(robot), in_(in), options_(options), w_(work), out_(out), n_(robot.stiffness.size()), m_(in.J_u.rows()) {
    if (w_.offset.size() != n_ || w_.compliance.size() < m_) w_.reserve(n_, std::max(m_, w_.compliance.size()));
    for (Eigen::VectorXd* v : {&out.q_cmd, &out.q_next, &out.torque_slack, &out.limit_slack}) v->setZero(n_);
    for (ContactVector* v : {&out.lambda, &out.slack, &out.pull}) v->setZero(m_);
  }

  Status run() {
    for (Index j = 0; j < n_; ++j) w_.offset[j] = in_.q_cmd[j] - in_.q[j];
    calc_box();
    if (!calc_forces()) return Status::NumericalFailure;
    if (!calc_cost()) return Status::NumericalFailure;
    write_rows();
    const Status status = solve_bounded_qp(w_.qp, options_.solver, w_.solver, w_.solution);
    if (status != Status::NumericalFailure) write_result();
    out_.iterations = w_.solution.iterations;
    return status;
  }

 private:
  int group_of(Index contact) const { return in_.groups.empty() ? 0 : in_.groups[static_cast<std::size_t>(contact)]; }
  bool may_be_gone(Index contact) const { return group_of(contact) != 0; }

  /// Intersects the intervals of rate, torque and joint limits in this order. If an interval does not meet the next one, it shrinks to its
  /// nearest point.
  void calc_box() {
    for (Index j = 0; j < n_; ++j) {
      double low = -robot_.rate[j], high = robot_.rate[j];
      const auto intersect = [&](double from, double to) {
        low = std::clamp(from, low, high);
        high = std::clamp(to, low, high);
      };
      const double stretch = robot_.torque[j] / robot_.stiffness[j];
      intersect(-stretch - w_.offset[j], stretch - w_.offset[j]);
      intersect(robot_.lower[j] - in_.q_cmd[j], robot_.upper[j] - in_.q_cmd[j]);
      w_.qp.lower[j] = low, w_.qp.upper[j] = high;
    }
  }

  /// λ = λ₀ − (G + C)⁻¹ J_u d, (C.4).
  bool calc_forces() {
    for (Index i = 0; i < m_; ++i) {
      for (Index k = 0; k <= i; ++k) {
        double sum = 0;
        for (Index j = 0; j < n_; ++j) sum += in_.J_u(i, j) * in_.J_u(k, j) / robot_.stiffness[j];
        w_.G(i, k) = group_of(i) == group_of(k) ? sum : 0.0;
      }
      const double least = options_.least_lever * options_.least_lever / robot_.stiffness.maxCoeff();
      w_.compliance[i] = options_.contact_compliance * std::max(w_.G(i, i), least);
      w_.G(i, i) += w_.compliance[i];
    }
    if (!factor_cholesky(w_.G, m_)) return false;
    for (Index i = 0; i < m_; ++i) {
      double moved = 0;
      for (Index j = 0; j < n_; ++j) {
        w_.LJ(i, j) = in_.J_u(i, j);
        moved += in_.J_u(i, j) * w_.offset[j];
      }
      w_.lambda0[i] = w_.compliance[i] * in_.lambda[i] - moved;
    }
    solve_cholesky(w_.G, m_, w_.lambda0.data());
    for (Index j = 0; j < n_ && m_ > 0; ++j) solve_cholesky(w_.G, m_, w_.LJ.data() + j, w_.LJ.outerStride());
    return true;
  }

  /// H and x̂ of the tracking cost.
  bool calc_cost() {
    BoundedQp& qp = w_.qp;
    const bool of_joints = in_.task_jacobian == nullptr;
    qp.diagonal = of_joints && (options_.cost == TrackingCost::Command || m_ == 0);
    if (qp.diagonal) {  // (5.24): d̂ = (q_ref − q_cmd⁻) / (1 + w)
      for (Index j = 0; j < n_; ++j) {
        qp.H(j, j) = 1 + in_.damping;
        qp.center[j] = (in_.q_ref[j] - in_.q_cmd[j]) / (1 + in_.damping);
      }
      return true;
    }
    const double regularisation = of_joints ? options_.epsilon : options_.posture_weight;
    write_tracking_rows();
    qp.H.setZero();
    for (Index j = 0; j < n_; ++j) {
      qp.H(j, j) = regularisation + in_.damping;
      w_.residual[j] = regularisation * (in_.q_ref[j] - in_.q_cmd[j]);
    }
    for (Index r = 0; r < w_.EP.rows(); ++r) {  // H += (EP)ᵀ EP,  residual += (EP)ᵀ (e − EP (q_cmd⁻ − q))
      double error = of_joints ? in_.q_ref[r] - in_.q[r] : (*in_.task_error)[r];
      for (Index j = 0; j < n_; ++j) error -= w_.EP(r, j) * w_.offset[j];
      for (Index j = 0; j < n_; ++j) {
        w_.residual[j] += w_.EP(r, j) * error;
        for (Index k = 0; k < n_; ++k) qp.H(j, k) += w_.EP(r, j) * w_.EP(r, k);
      }
    }
    w_.solver.factor = qp.H;
    if (!factor_cholesky(w_.solver.factor, n_)) return false;
    qp.center = w_.residual;
    solve_cholesky(w_.solver.factor, n_, qp.center.data());
    return true;
  }

  /// Fills EP with E, or with E (I − K⁻¹ J_uᵀ (G + C)⁻¹ J_u) for the equilibrium cost, (5.23).
  void write_tracking_rows() {
    const bool of_joints = in_.task_jacobian == nullptr;
    const Index rows = of_joints ? n_ : in_.task_jacobian->rows();
    if (w_.EP.rows() != rows || w_.EP.cols() != n_) w_.EP.setZero(rows, n_);
    if (of_joints) {
      w_.EP.setIdentity();
    } else {
      w_.EP = *in_.task_jacobian;
    }
    if (options_.cost == TrackingCost::Command) return;
    for (Index r = 0; r < rows; ++r) {
      for (Index i = 0; i < m_; ++i) {
        w_.column[i] = 0;
        for (Index j = 0; j < n_; ++j) w_.column[i] += w_.EP(r, j) / robot_.stiffness[j] * in_.J_u(i, j);
      }
      for (Index j = 0; j < n_; ++j)
        for (Index i = 0; i < m_; ++i) w_.EP(r, j) -= may_be_gone(i) ? 0.0 : w_.column[i] * w_.LJ(i, j);
    }
  }

  /// Rows −LJ d / λ_max ≤ 1 − λ₀/λ_max, and LJ d / λ_max ≤ λ₀/λ_max for contacts that the reference does not leave.
  void write_rows() {
    BoundedQp& qp = w_.qp;
    qp.m = 0;
    const auto add_row = [&](Index contact, double sign, double bound, double priority) {
      for (Index j = 0; j < n_; ++j) qp.A(qp.m, j) = sign * w_.LJ(contact, j) / in_.lambda_max[contact];
      qp.b[qp.m] = bound;
      qp.priority[qp.m++] = priority;
    };
    for (Index i = 0; i < m_; ++i) add_row(i, -1, 1 - w_.lambda0[i] / in_.lambda_max[i], options_.force_priority);
    if (!options_.unilateral) return;
    for (Index i = 0; i < m_; ++i)
      if (must_not_pull(i)) add_row(i, 1, w_.lambda0[i] / in_.lambda_max[i], options_.unilateral_priority);
  }

  /// Whether the reference leaves the contact, (5.30) with its sign corrected: it moves the contact point along the force on the robot.
  /// With a task, the command that tracks the task best takes the place of the reference.
  bool is_left(Index contact) const {
    double along = 0;
    for (Index j = 0; j < n_; ++j) {
      const double wanted = in_.task_jacobian == nullptr ? in_.q_ref[j] - in_.q[j] : w_.qp.center[j] + w_.offset[j];
      along += in_.J_u(contact, j) * wanted;
    }
    return along >= 0;
  }

  /// A contact that may be gone cannot pull. If the command followed the arm to prevent pulling, the joint springs would exert no force.
  bool must_not_pull(Index contact) const { return !may_be_gone(contact) && !is_left(contact); }

  void write_result() {
    const Eigen::VectorXd& d = w_.solution.x;
    const auto excess = [](double value, double rounding_scale) {
      return value > 4 * std::numeric_limits<double>::epsilon() * rounding_scale ? value : 0.0;
    };
    for (Index j = 0; j < n_; ++j) {
      const double command = in_.q_cmd[j] + d[j], torque = robot_.stiffness[j] * (d[j] + w_.offset[j]);
      out_.q_cmd[j] = command;
      out_.torque_slack[j] = excess(std::abs(torque) - robot_.torque[j], std::abs(torque));
      out_.limit_slack[j] = excess(std::max(robot_.lower[j] - command, command - robot_.upper[j]), std::abs(command));
    }
    for (Index i = 0; i < m_; ++i) {
      double lambda = w_.lambda0[i];
      for (Index j = 0; j < n_; ++j) lambda -= w_.LJ(i, j) * d[j];
      out_.lambda[i] = lambda;
      out_.slack[i] = w_.solution.slack[i] * in_.lambda_max[i];
    }
    Index row = m_;
    for (Index i = 0; i < m_ && row < w_.qp.m; ++i)
      if (must_not_pull(i)) out_.pull[i] = w_.solution.slack[row++] * in_.lambda_max[i];
    for (Index j = 0; j < n_; ++j) {  // (5.8a)
      double torque = 0;
      for (Index i = 0; i < m_; ++i) torque += may_be_gone(i) ? 0.0 : in_.J_u(i, j) * out_.lambda[i];
      out_.q_next[j] = out_.q_cmd[j] + torque / robot_.stiffness[j];
    }
  }

  const RobotLimits& robot_;
  const ContactQpInput& in_;
  const ContactQpOptions& options_;
  ContactQpWorkspace& w_;
  ContactQpResult& out_;
  Index n_, m_;
};

}  // namespace

Status solve_contact_qp(const RobotLimits& robot, const ContactQpInput& in, const ContactQpOptions& options, ContactQpWorkspace& work,
                        ContactQpResult& out) {
  require(robot, in);
  return out.status = Tick(robot, in, options, work, out).run();
}

}  // namespace stiction::control
