#include "stiction/control/closed_form.hpp"

#include <algorithm>
#include <limits>

namespace stiction::control {

using Eigen::Index;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Root y of  a x(y) − y/ω − b  for one row; 0 if the value at y = 0 is negative.
double find_multiplier(const BoundedQp& qp, Index row, BoundedQpWorkspace& w) {
  const Index n = qp.center.size();
  const auto calc_value = [&](double y) {
    double sum = -qp.b[row] - y * w.omega_inverse[row];
    for (Index j = 0; j < n; ++j) sum += qp.A(row, j) * std::clamp(qp.center[j] - y * qp.A(row, j) / qp.H(j, j), qp.lower[j], qp.upper[j]);
    return sum;
  };
  double y = 0, value = calc_value(0);
  if (!(value > 0)) return 0;
  for (Index j = 0; j < n; ++j) {
    const double speed = -qp.A(row, j) / qp.H(j, j);  // derivative of x_j by y
    const double from = speed > 0 ? qp.lower[j] : qp.upper[j], to = speed > 0 ? qp.upper[j] : qp.lower[j];
    w.enters[j] = speed == 0 ? kInfinity : (from - qp.center[j]) / speed;
    w.leaves[j] = speed == 0 ? kInfinity : (to - qp.center[j]) / speed;
  }
  for (;;) {
    double steepness = w.omega_inverse[row], next = kInfinity;
    for (Index j = 0; j < n; ++j) {
      if (w.enters[j] <= y && y < w.leaves[j]) steepness += qp.A(row, j) * qp.A(row, j) / qp.H(j, j);
      if (w.enters[j] > y) next = std::min(next, w.enters[j]);
      if (w.leaves[j] > y) next = std::min(next, w.leaves[j]);
    }
    const double root = y + value / steepness;
    if (root <= next) return root;
    y = next, value = calc_value(next);
    if (!(value > 0)) return y;  // because of rounding
  }
}

}  // namespace

bool has_closed_form(const BoundedQp& qp) {
  if (!qp.diagonal || qp.m > 2) return false;
  if (qp.m < 2) return true;
  for (Index j = 0; j < qp.center.size(); ++j)
    if (qp.A(1, j) != -qp.A(0, j)) return false;
  return qp.b[0] + qp.b[1] >= 0;
}

void solve_closed_form(const BoundedQp& qp, BoundedQpWorkspace& work, BoundedQpResult& out) {
  Index felt = -1;
  for (Index i = 0; i < qp.m; ++i) {
    out.y[i] = felt < 0 ? find_multiplier(qp, i, work) : 0;
    out.slack[i] = out.y[i] * work.omega_inverse[i];
    if (out.y[i] > 0) felt = i;
  }
  for (Index j = 0; j < qp.center.size(); ++j) {
    const double unbounded = felt < 0 ? qp.center[j] : qp.center[j] - out.y[felt] * qp.A(felt, j) / qp.H(j, j);
    out.x[j] = std::clamp(unbounded, qp.lower[j], qp.upper[j]);
    out.z[j] = qp.H(j, j) * (unbounded - out.x[j]);
  }
  out.iterations = 0;
}

}  // namespace stiction::control
