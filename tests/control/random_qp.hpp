#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "stiction/control/bounded_qp.hpp"
#include "stiction/core/random.hpp"

namespace stiction::control::test {

/// Programs as they come and as they should not: equal, opposed and zero rows, bounds of one point, rows that the box forbids.
inline BoundedQp random_qp(core::Random& random, Eigen::Index n, Eigen::Index m, bool diagonal) {
  BoundedQp qp;
  qp.reserve(n, m);
  qp.m = m;
  qp.diagonal = diagonal;
  const auto normal = [&](auto&& M) {
    for (Eigen::Index i = 0; i < M.size(); ++i) M.data()[i] = random.normal();
  };
  if (diagonal) {
    for (Eigen::Index j = 0; j < n; ++j) qp.H(j, j) = std::exp(random.normal());
    qp.H(0, n - 1) += n > 1 ? 7.0 : 0.0;  // nobody reads what is off the diagonal
  } else {
    RowMatrix B(n, n);
    normal(B);
    qp.H = B.transpose() * B;
    qp.H.diagonal().array() += random.chance(0.3) ? 1e-3 : 1.0;
  }
  normal(qp.center);
  normal(qp.A);
  qp.A *= std::exp(2 * random.normal());
  normal(qp.b);
  for (Eigen::Index j = 0; j < n; ++j) {
    const double a = random.normal(), b = random.chance(0.1) ? a : random.normal();
    qp.lower[j] = std::min(a, b), qp.upper[j] = std::max(a, b);
  }
  for (Eigen::Index i = 1; i < m; ++i) {
    const double kind = random.uniform();
    if (kind < 0.15) qp.A.row(i) = qp.A.row(i - 1);
    if (kind > 0.15 && kind < 0.3) qp.A.row(i) = -qp.A.row(i - 1);
    if (kind > 0.3 && kind < 0.35) qp.A.row(i).setZero();
    if (kind > 0.35 && kind < 0.45) qp.A.row(i) += 1e-7 * qp.A.row(i - 1);
  }
  for (Eigen::Index i = 0; i < m; ++i) qp.priority[i] = random.chance(0.5) ? 1e6 : 1e3;
  return qp;
}

/// H as it counts.
inline Eigen::MatrixXd hessian(const BoundedQp& qp) {
  return qp.diagonal ? Eigen::MatrixXd(qp.H.diagonal().asDiagonal()) : Eigen::MatrixXd(qp.H);
}

/// 1/ω_i of (C.10), by its definition.
inline Eigen::VectorXd softness(const BoundedQp& qp) {
  Eigen::VectorXd out(qp.m);
  for (Eigen::Index i = 0; i < qp.m; ++i) {
    const Eigen::VectorXd a = qp.A.row(i);
    const double curvature = a.dot(hessian(qp).ldlt().solve(a));
    out[i] = (curvature > 0 ? curvature : 1.0) / qp.priority[i];
  }
  return out;
}

/// Largest violation of the optimality conditions of (C.10), each relative to the largest of its terms.
inline double kkt_residual(const BoundedQp& qp, const BoundedQpResult& r) {
  const Eigen::Index n = qp.center.size();
  const Eigen::MatrixXd A = qp.A.topRows(qp.m);
  const Eigen::VectorXd y = r.y.head(qp.m), s = r.slack.head(qp.m), omega_inverse = softness(qp);
  const Eigen::VectorXd pull = hessian(qp) * (r.x - qp.center), push = A.transpose() * y;
  double worst = 0;
  const auto judge = [&](double error, double scale) { worst = std::max(worst, error / std::max(1.0, scale)); };
  const double forces =
      std::max({pull.cwiseAbs().maxCoeff(), y.size() > 0 ? (A.cwiseAbs().transpose() * y).maxCoeff() : 0.0, r.z.cwiseAbs().maxCoeff()});
  judge((pull + push + r.z).cwiseAbs().maxCoeff(), forces);
  for (Eigen::Index j = 0; j < n; ++j) {
    judge(std::max({0.0, qp.lower[j] - r.x[j], r.x[j] - qp.upper[j]}), 0);
    if (r.z[j] > 0) judge(std::min(r.z[j] / std::max(1.0, forces), qp.upper[j] - r.x[j]), 0);
    if (r.z[j] < 0) judge(std::min(-r.z[j] / std::max(1.0, forces), r.x[j] - qp.lower[j]), 0);
  }
  for (Eigen::Index i = 0; i < qp.m; ++i) {
    const double size = A.row(i).cwiseAbs().dot(r.x.cwiseAbs()) + std::abs(qp.b[i]);
    const double gap = qp.b[i] + s[i] - A.row(i).dot(r.x);
    judge(std::max(0.0, -gap), size);
    judge(std::max(0.0, -y[i]), 0);
    judge(std::abs(s[i] - omega_inverse[i] * y[i]), std::abs(s[i]));
    judge(std::min(y[i] / std::max(1.0, forces), std::max(0.0, gap) / std::max(1.0, size)), 0);
  }
  return worst;
}

}  // namespace stiction::control::test
