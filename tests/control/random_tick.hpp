#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/control/contact_qp.hpp"
#include "stiction/core/random.hpp"

namespace stiction::control::test {

/// A robot, its state and contacts that belong together, as one tick has them.
struct RandomTick {
  RobotLimits robot;
  Eigen::VectorXd q, q_cmd, q_ref, lambda, lambda_max;
  RowMatrix J_u, task_jacobian;
  Eigen::VectorXd task_error;
  bool of_task = false;
  double damping = 0;

  ContactQpInput input() const {
    ContactQpInput in{q, q_cmd, q_ref, J_u, lambda, lambda_max, damping, {}};
    if (of_task) in.task_jacobian = &task_jacobian, in.task_error = &task_error;
    return in;
  }
};

/// States as they come and as they should not: parallel, opposed and too many contacts, points that no joint moves, commands far from the robot, outside its
/// limits, with more torque than there is; forces above their bound.
inline RandomTick random_tick(core::Random& random) {
  RandomTick t;
  const Eigen::Index n = random.chance(0.6) ? 7 : 1 + random.index(9), m = random.index(random.chance(0.2) ? 9 : 4);
  const auto normal = [&](Eigen::Index size, double scale) {
    Eigen::VectorXd v(size);
    for (double& x : v) x = scale * random.normal();
    return v;
  };
  const auto positive = [&](Eigen::Index size, double scale) { return (scale * normal(size, 0.6).array().exp()).matrix().eval(); };
  t.robot.stiffness = positive(n, 500);
  t.robot.rate = positive(n, 0.01);
  t.robot.torque = random.chance(0.5) ? positive(n, 50) : Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity()).eval();
  t.q = normal(n, 0.5);
  t.robot.lower = t.q - positive(n, random.chance(0.2) ? 0.01 : 1.0);
  t.robot.upper = t.q + positive(n, random.chance(0.2) ? 0.01 : 1.0);
  t.q_cmd = t.q + normal(n, random.chance(0.1) ? 0.5 : 0.02);
  t.q_ref = t.q_cmd + normal(n, random.chance(0.3) ? 0.5 : 0.01);
  t.J_u.resize(m, n);
  for (Eigen::Index i = 0; i < m; ++i) {
    t.J_u.row(i) = normal(n, 0.4).transpose();
    if (i == 0) continue;
    const double kind = random.uniform();
    if (kind < 0.12) t.J_u.row(i) = t.J_u.row(i - 1);
    if (kind > 0.12 && kind < 0.24) t.J_u.row(i) = -t.J_u.row(i - 1);
    if (kind > 0.24 && kind < 0.3) t.J_u.row(i).setZero();
    if (kind > 0.3 && kind < 0.36) t.J_u.row(i) += 1e-6 * t.J_u.row(i - 1);
  }
  t.lambda = normal(m, 20).cwiseAbs();
  t.lambda_max = positive(m, 15);
  t.damping = random.chance(0.5) ? 0 : random.uniform(0, 10);
  t.of_task = random.chance(0.3);
  t.task_jacobian.resize(6, n);
  for (Eigen::Index r = 0; r < 6; ++r) t.task_jacobian.row(r) = normal(n, 0.4).transpose();
  t.task_error = normal(6, 0.02);
  return t;
}

/// Largest violation of the optimality conditions of the tick, each relative to the largest of its terms: cost, forces and bounds from their definitions, multipliers
/// as found.
inline double kkt_residual(const RandomTick& t, const ContactQpOptions& options, const ContactQpResult& r,
                           const BoundedQpResult& solution) {
  const Eigen::Index n = t.q.size(), m = t.J_u.rows();
  const Eigen::MatrixXd J = t.J_u, I = Eigen::MatrixXd::Identity(n, n), K_inverse = t.robot.stiffness.cwiseInverse().asDiagonal();
  Eigen::MatrixXd G = J * K_inverse * J.transpose();
  Eigen::VectorXd compliance(m);
  for (Eigen::Index i = 0; i < m; ++i)
    compliance[i] =
        options.contact_compliance * std::max(G(i, i), options.least_lever * options.least_lever / t.robot.stiffness.maxCoeff());
  G.diagonal() += compliance;
  const Eigen::MatrixXd LJ = G.ldlt().solve(J);
  const Eigen::VectorXd lambda = G.ldlt().solve(Eigen::VectorXd(compliance.cwiseProduct(t.lambda) - J * (r.q_cmd - t.q)));
  double worst = 0;
  const auto judge = [&](double error, double scale) { worst = std::max(worst, error / std::max(1.0, scale)); };
  const double size = (LJ.cwiseAbs() * (r.q_cmd - t.q).cwiseAbs()).size() > 0 ? (LJ.cwiseAbs() * (r.q_cmd - t.q).cwiseAbs()).maxCoeff() : 0;
  if (m > 0) judge((lambda - r.lambda).cwiseAbs().maxCoeff(), size);
  // Cost.
  const Eigen::MatrixXd P = options.cost == TrackingCost::Equilibrium ? (I - K_inverse * J.transpose() * LJ).eval() : I;
  const Eigen::MatrixXd E = (t.of_task ? Eigen::MatrixXd(t.task_jacobian) : I) * P;
  const Eigen::VectorXd e = t.of_task ? t.task_error : (t.q_ref - t.q).eval();
  const bool plain = !t.of_task && (options.cost == TrackingCost::Command || m == 0);
  const double pull = plain ? 0 : t.of_task ? options.posture_weight : options.epsilon;
  const Eigen::VectorXd gradient = E.transpose() * (E * (r.q_cmd - t.q) - e) + pull * (r.q_cmd - t.q_ref) + t.damping * (r.q_cmd - t.q_cmd);
  // Rows −λ ≤ …, multipliers of the rows in units of λ_max.
  const Eigen::MatrixXd A = -(t.lambda_max.cwiseInverse().asDiagonal() * LJ);
  Eigen::VectorXd push = Eigen::VectorXd::Zero(n), y = Eigen::VectorXd::Zero(m);
  double forces = 0;
  Eigen::Index row = m;
  for (Eigen::Index i = 0; i < m; ++i) {
    y[i] = solution.y[i];
    judge(std::max(0.0, r.lambda[i] - t.lambda_max[i] - r.slack[i]) / t.lambda_max[i],
          std::abs(r.lambda[i]) / t.lambda_max[i] + size / t.lambda_max[i]);
    judge(std::min(solution.y[i],
                   std::max(0.0, t.lambda_max[i] + r.slack[i] - r.lambda[i]) / t.lambda_max[i] / std::max(1.0, size / t.lambda_max[i])),
          0);
    const Eigen::VectorXd wanted = t.of_task ? Eigen::VectorXd() : (t.q_ref - t.q).eval();
    if (!t.of_task && options.unilateral && J.row(i).dot(wanted) < 0) {
      judge(std::max(0.0, -r.lambda[i] - r.pull[i]) / t.lambda_max[i], std::abs(r.lambda[i]) / t.lambda_max[i] + size / t.lambda_max[i]);
      y[i] -= solution.y[row++];
    }
  }
  if (m > 0) push = A.transpose() * y, forces = (A.cwiseAbs().transpose() * solution.y.head(m)).maxCoeff();
  judge((gradient + push + solution.z).cwiseAbs().maxCoeff(),
        std::max({forces, solution.z.cwiseAbs().maxCoeff(), gradient.cwiseAbs().maxCoeff()}));
  for (Eigen::Index j = 0; j < n; ++j) judge(std::max(0.0, std::abs(r.q_cmd[j] - t.q_cmd[j]) - t.robot.rate[j]), 0);
  return worst;
}

}  // namespace stiction::control::test
