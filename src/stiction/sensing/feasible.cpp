#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/sensing/discriminate.hpp"

namespace stiction::sensing {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Positive below the lower bound, negative above the upper one.
VectorXd calc_violations(const LinearRows& rows, const VectorXd& Cx) {
  return (rows.lower - Cx).cwiseMax(0) + (rows.upper - Cx).cwiseMin(0);
}

/// The minimum over a ≥ 0 of F(x + a p) along which F is convex and piecewise quadratic: a root of its slope, by Newton inside a bracket.
double search_line(const LinearRows& rows, const VectorXd& Cx, const VectorXd& Cp) {
  const auto slope = [&](double a, double& curvature) {
    const VectorXd v = calc_violations(rows, Cx + a * Cp);
    curvature = (v.array() != 0).select(Cp.array().square(), 0).sum();
    return -v.dot(Cp);
  };
  double low = 0, high = std::numeric_limits<double>::infinity(), a = 1, curvature = 0;
  constexpr int kMost = 60;
  for (int i = 0; i < kMost; ++i) {
    const double s = slope(a, curvature);
    if (s == 0) return a;
    (s < 0 ? low : high) = a;
    double next = curvature > 0 ? a - s / curvature : 2 * a;
    if (!(next > low && next < high)) next = std::isfinite(high) ? 0.5 * (low + high) : 2 * a;
    if (std::abs(next - a) <= 1e-15 * a) return next;
    a = next;
  }
  return a;
}

}  // namespace

Feasibility find_feasible(const LinearRows& rows, double tolerance) {
  const Index n = rows.C.cols();
  Feasibility out;
  out.x = VectorXd::Zero(n);
  const double size = std::max(rows.lower.cwiseAbs().maxCoeff(), rows.upper.cwiseAbs().maxCoeff());
  VectorXd Cx = VectorXd::Zero(rows.C.rows());
  constexpr int kMostSteps = 200;
  for (int step = 0; step < kMostSteps; ++step) {
    const VectorXd v = calc_violations(rows, Cx);
    out.weights = v;
    if (v.cwiseAbs().maxCoeff() <= tolerance * size) {
      out.feasible = true;
      out.weights.resize(0);
      return out;
    }
    const VectorXd gradient = -rows.C.transpose() * v;
    if (gradient.norm() <= 1e-12 * v.norm() * rows.C.norm()) return out;
    const VectorXd active = (v.array() != 0).cast<double>();
    MatrixXd H = rows.C.transpose() * active.asDiagonal() * rows.C;
    H.diagonal().array() += 1e-12 * (H.trace() / static_cast<double>(n));
    const VectorXd p = -H.ldlt().solve(gradient);
    const VectorXd Cp = rows.C * p;
    const double a = search_line(rows, Cx, Cp);
    out.x += a * p;
    Cx += a * Cp;
  }
  return out;
}

}  // namespace stiction::sensing
