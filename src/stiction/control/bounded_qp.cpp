#include "stiction/control/bounded_qp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/control/closed_form.hpp"

namespace stiction::control {

using core::Status;
using Eigen::Index;

void BoundedQp::reserve(Index n, Index rows) {
  H.setZero(n, n);
  center.setZero(n), lower.setZero(n), upper.setZero(n);
  A.setZero(rows, n);
  b.setZero(rows), priority.setOnes(rows);
  m = 0;
}

void BoundedQpWorkspace::reserve(Index n, Index rows) {
  omega_inverse.setZero(rows);
  factor.setZero(n, n), V.setZero(rows, n), S.setZero(rows, rows);
  for (Eigen::VectorXd* v : {&z, &dx, &dz, &enters, &leaves}) v->setZero(n);
  for (Eigen::VectorXd* v : {&y, &dy}) v->setZero(rows);
  side.reserve(static_cast<std::size_t>(n));
  free.reserve(static_cast<std::size_t>(n));
  active.reserve(static_cast<std::size_t>(rows));
}

namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

double row_dot(const RowMatrix& A, Index i, const Eigen::VectorXd& x) {
  const double* row = A.data() + i * A.cols();
  double sum = 0;
  for (Index j = 0; j < A.cols(); ++j) sum += row[j] * x[j];
  return sum;
}

/// Fills 1/ω_i. A row of zeros constrains nothing; its slack has the scale of its bound.
bool calc_weights(const BoundedQp& qp, BoundedQpWorkspace& w) {
  const Index n = qp.center.size();
  if (qp.diagonal) {
    for (Index j = 0; j < n; ++j)
      if (!(qp.H(j, j) > 0)) return false;
  } else {
    w.factor = qp.H;
    if (!factor_cholesky(w.factor, n)) return false;
  }
  for (Index i = 0; i < qp.m; ++i) {
    double curvature = 0;
    if (qp.diagonal) {
      for (Index j = 0; j < n; ++j) curvature += qp.A(i, j) * qp.A(i, j) / qp.H(j, j);
    } else {
      for (Index j = 0; j < n; ++j) w.dx[j] = qp.A(i, j);
      solve_cholesky(w.factor, n, w.dx.data());
      curvature = row_dot(qp.A, i, w.dx);
    }
    w.omega_inverse[i] = (curvature > 0 ? curvature : 1.0) / qp.priority[i];
  }
  return true;
}

/// Constraints are numbered: 0 … n−1 the box, n … n+m−1 the rows. Stationarity  H (x − x̂) + Aᵀ y + z = 0  holds at all times.
class DualActiveSet {
 public:
  DualActiveSet(const BoundedQp& qp, const BoundedQpOptions& options, BoundedQpWorkspace& work, BoundedQpResult& out)
      : qp_(qp), options_(options), w_(work), x_(out.x), n_(qp.center.size()) {
    x_ = qp.center;
    w_.side.assign(at(n_), 0);
    w_.active.clear();
    for (Index i = 0; i < qp.m; ++i) w_.y[i] = 0;
    w_.z.setZero();
  }

  Status run(int& iterations) {
    const int limit = options_.max_iterations > 0 ? options_.max_iterations : 20 + 10 * static_cast<int>(n_ + qp_.m);
    iterations = 0;
    for (;;) {
      const Index k = most_violated();
      if (k < 0 && !cut_short_) return refine() ? Status::Solved : Status::NumericalFailure;
      if (iterations >= limit) return Status::MaxIterations;
      if (!add(k, limit, iterations)) return Status::NumericalFailure;
    }
  }

 private:
  bool is_row(Index k) const { return k >= n_; }
  bool is_row_active(Index i) const { return std::find(w_.active.begin(), w_.active.end(), i) != w_.active.end(); }
  bool is_fixed(Index j) const { return qp_.lower[j] == qp_.upper[j]; }

  /// Violation of constraint k (> 0 if violated), and the side on which it is violated.
  double calc_violation(Index k, int& side) const {
    if (!is_row(k)) {
      side = x_[k] > qp_.upper[k] ? 1 : -1;
      return side > 0 ? x_[k] - qp_.upper[k] : qp_.lower[k] - x_[k];
    }
    side = 1;
    const Index i = k - n_;
    return row_dot(qp_.A, i, x_) - qp_.b[i] - w_.y[i] * w_.omega_inverse[i];
  }

  /// The inactive constraint with the largest violation beyond rounding, in the norm of H; −1: none.
  Index most_violated() const {
    Index best = -1;
    double worst = 0;
    int side = 0;
    const auto consider = [&](Index k, double magnitude, double scale) {
      const double over = calc_violation(k, side);
      if (over > options_.tolerance * magnitude && over / scale > worst) worst = over / scale, best = k;
    };
    for (Index j = 0; j < n_; ++j)
      if (w_.side[at(j)] == 0) consider(j, std::abs(x_[j]), 1 / std::sqrt(qp_.H(j, j)));
    for (Index i = 0; i < qp_.m; ++i) {
      if (is_row_active(i)) continue;
      double magnitude = std::abs(qp_.b[i]);
      for (Index j = 0; j < n_; ++j) magnitude = std::max(magnitude, std::abs(qp_.A(i, j) * x_[j]));
      consider(n_ + i, magnitude, std::sqrt(w_.omega_inverse[i] * qp_.priority[i]));
    }
    return best;
  }

  /// H over the free coordinates, and S = A_f H_ff⁻¹ A_fᵀ + 1/ω over the active rows.
  bool factor() {
    w_.free.clear();
    for (Index j = 0; j < n_; ++j)
      if (w_.side[at(j)] == 0) w_.free.push_back(j);
    const auto n_f = static_cast<Index>(w_.free.size()), m = static_cast<Index>(w_.active.size());
    if (!qp_.diagonal) {
      for (Index a = 0; a < n_f; ++a)
        for (Index b = 0; b <= a; ++b) w_.factor(a, b) = qp_.H(w_.free[at(a)], w_.free[at(b)]);
      if (!factor_cholesky(w_.factor, n_f)) return false;
    }
    for (Index r = 0; r < m; ++r) {
      const Index row = w_.active[at(r)];
      for (Index a = 0; a < n_f; ++a) w_.V(r, a) = qp_.A(row, w_.free[at(a)]);
      solve_free(w_.V.data() + r * n_);
      for (Index c = 0; c <= r; ++c) {
        double sum = 0;
        for (Index a = 0; a < n_f; ++a) sum += w_.V(r, a) * qp_.A(w_.active[at(c)], w_.free[at(a)]);
        w_.S(r, c) = sum;
      }
      w_.S(r, r) += w_.omega_inverse[row];
    }
    return factor_cholesky(w_.S, m);
  }

  /// v ← H_ff⁻¹ v
  void solve_free(double* v) const {
    if (qp_.diagonal) {
      for (std::size_t a = 0; a < w_.free.size(); ++a) v[a] /= qp_.H(w_.free[a], w_.free[a]);
    } else {
      solve_cholesky(w_.factor, static_cast<Index>(w_.free.size()), v);
    }
  }

  /// Solves  H_ff e + A_fᵀ y = p ,  A_f e − y/ω = r  for the active rows: p (in w.dx) becomes e, r (in w.dy) becomes y.
  void solve_reduced() {
    const auto n_f = static_cast<Index>(w_.free.size()), m = static_cast<Index>(w_.active.size());
    double *e = w_.dx.data(), *y = w_.dy.data();
    solve_free(e);
    for (Index r = 0; r < m; ++r) {
      double sum = -y[r];
      for (Index a = 0; a < n_f; ++a) sum += qp_.A(w_.active[at(r)], w_.free[at(a)]) * e[a];
      y[r] = sum;
    }
    solve_cholesky(w_.S, m, y);
    for (Index r = 0; r < m; ++r)
      for (Index a = 0; a < n_f; ++a) e[a] -= w_.V(r, a) * y[r];
  }

  /// Pushes against the broken constraint k until it holds; constraints whose multiplier would change its sign are dropped on the way.
  bool add(Index k, int limit, int& iterations) {
    int side = 0;
    double left = calc_violation(k, side);
    double y_k = is_row(k) ? w_.y[k - n_] : w_.z[k];
    while (iterations < limit) {
      ++iterations;
      if (!factor()) return false;
      const double steepness = calc_direction(k, side);
      if (!(steepness > 0)) return false;
      double step = std::max(0.0, left) / steepness;
      Index blocking = -1;
      find_blocking(step, blocking);
      move(step);
      y_k += side * step;
      left -= step * steepness;
      if (blocking < 0) {
        if (is_row(k)) {
          w_.active.push_back(k - n_);
        } else {
          w_.side[at(k)] = side;
        }
        return resolve();
      }
      drop(blocking);
    }
    cut_short_ = true;
    if (is_row(k)) {  // keeps stationarity
      w_.y[k - n_] = y_k;
    } else {
      w_.z[k] = y_k;
    }
    return true;
  }

  /// dx (over the free), dy (over the active rows) and dz (of all bounds) for a unit of the multiplier of k; the change of its violation.
  double calc_direction(Index k, int side) {
    const auto n_f = static_cast<Index>(w_.free.size()), m = static_cast<Index>(w_.active.size());
    const auto gradient = [&](Index j) { return is_row(k) ? qp_.A(k - n_, j) : (j == k ? static_cast<double>(side) : 0.0); };
    for (Index a = 0; a < n_f; ++a) w_.dx[a] = -gradient(w_.free[at(a)]);
    for (Index r = 0; r < m; ++r) w_.dy[r] = 0;
    solve_reduced();
    double steepness = is_row(k) ? w_.omega_inverse[k - n_] : 0;
    for (Index a = 0; a < n_f; ++a) steepness -= gradient(w_.free[at(a)]) * w_.dx[a];
    for (Index j = 0; j < n_; ++j) {
      if (w_.side[at(j)] == 0) continue;
      double force = gradient(j);
      for (Index r = 0; r < m; ++r) force += qp_.A(w_.active[at(r)], j) * w_.dy[r];
      if (!qp_.diagonal)
        for (Index a = 0; a < n_f; ++a) force += qp_.H(j, w_.free[at(a)]) * w_.dx[a];
      w_.dz[j] = -force;
    }
    return steepness;
  }

  void find_blocking(double& step, Index& blocking) const {
    for (Index j = 0; j < n_; ++j) {
      const int side = w_.side[at(j)];
      if (side == 0 || is_fixed(j) || !(side * w_.dz[j] < 0)) continue;
      const double most = std::max(0.0, side * w_.z[j]) / -(side * w_.dz[j]);
      if (most < step) step = most, blocking = j;
    }
    for (std::size_t r = 0; r < w_.active.size(); ++r) {
      const double dy = w_.dy[static_cast<Index>(r)];
      if (!(dy < 0)) continue;
      const double most = std::max(0.0, w_.y[w_.active[r]]) / -dy;
      if (most < step) step = most, blocking = n_ + w_.active[r];
    }
  }

  void move(double step) {
    for (std::size_t a = 0; a < w_.free.size(); ++a) x_[w_.free[a]] += step * w_.dx[static_cast<Index>(a)];
    for (std::size_t r = 0; r < w_.active.size(); ++r) w_.y[w_.active[r]] += step * w_.dy[static_cast<Index>(r)];
    for (Index j = 0; j < n_; ++j)
      if (w_.side[at(j)] != 0) w_.z[j] += step * w_.dz[j];
  }

  void drop(Index k) {
    if (is_row(k)) {
      w_.y[k - n_] = 0;
      w_.active.erase(std::find(w_.active.begin(), w_.active.end(), k - n_));
    } else {
      w_.z[k] = 0;
      w_.side[at(k)] = 0;
    }
  }

  /// Computes x, y and z of the active set from scratch, so that rounding does not accumulate from set to set.
  bool resolve() {
    if (!factor()) return false;
    const auto n_f = static_cast<Index>(w_.free.size()), m = static_cast<Index>(w_.active.size());
    for (Index j = 0; j < n_; ++j) x_[j] = w_.side[at(j)] > 0 ? qp_.upper[j] : w_.side[at(j)] < 0 ? qp_.lower[j] : qp_.center[j];
    for (Index a = 0; a < n_f; ++a) {
      double sum = 0;
      if (!qp_.diagonal)
        for (Index j = 0; j < n_; ++j)
          if (w_.side[at(j)] != 0) sum += qp_.H(w_.free[at(a)], j) * (x_[j] - qp_.center[j]);
      w_.dx[a] = -sum;
    }
    for (Index r = 0; r < m; ++r) w_.dy[r] = qp_.b[w_.active[at(r)]] - row_dot(qp_.A, w_.active[at(r)], x_);
    solve_reduced();
    for (Index a = 0; a < n_f; ++a) x_[w_.free[at(a)]] += w_.dx[a];
    for (Index r = 0; r < m; ++r) w_.y[w_.active[at(r)]] = w_.dy[r];
    calc_bound_forces();
    return true;
  }

  /// One step of iterative refinement of the rows. If rows contradict each other, multipliers are as large as the priorities and x is their
  /// small difference.
  bool refine() {
    if (w_.active.empty()) return true;
    if (!factor()) return false;
    for (std::size_t a = 0; a < w_.free.size(); ++a) w_.dx[static_cast<Index>(a)] = 0;
    for (std::size_t r = 0; r < w_.active.size(); ++r) {
      const Index row = w_.active[r];
      w_.dy[static_cast<Index>(r)] = qp_.b[row] - row_dot(qp_.A, row, x_) + w_.y[row] * w_.omega_inverse[row];
    }
    solve_reduced();
    for (std::size_t a = 0; a < w_.free.size(); ++a) x_[w_.free[a]] += w_.dx[static_cast<Index>(a)];
    for (std::size_t r = 0; r < w_.active.size(); ++r) w_.y[w_.active[r]] += w_.dy[static_cast<Index>(r)];
    calc_bound_forces();
    return true;
  }

  /// Multipliers of the active bounds, from stationarity.
  void calc_bound_forces() {
    for (Index j = 0; j < n_; ++j) {
      w_.z[j] = 0;
      if (w_.side[at(j)] == 0) continue;
      double force = qp_.H(j, j) * (x_[j] - qp_.center[j]);
      if (!qp_.diagonal)
        for (Index k = 0; k < n_; ++k)
          if (k != j) force += qp_.H(j, k) * (x_[k] - qp_.center[k]);
      for (const Index row : w_.active) force += qp_.A(row, j) * w_.y[row];
      w_.z[j] = -force;
    }
  }

  const BoundedQp& qp_;
  const BoundedQpOptions& options_;
  BoundedQpWorkspace& w_;
  Eigen::VectorXd& x_;
  Index n_;
  bool cut_short_ = false;  ///< iterations ran out before a constraint held
};

void solve_active_set(const BoundedQp& qp, const BoundedQpOptions& options, BoundedQpWorkspace& w, BoundedQpResult& out) {
  out.status = DualActiveSet(qp, options, w, out).run(out.iterations);
  for (Index j = 0; j < qp.center.size(); ++j) {
    out.z[j] = w.z[j];
    out.x[j] = std::clamp(out.x[j], qp.lower[j], qp.upper[j]);  // changes free coordinates by rounding only, unless iterations ran out
  }
  for (Index i = 0; i < qp.m; ++i) {
    out.y[i] = std::max(0.0, w.y[i]);
    out.slack[i] = out.status == Status::Solved ? out.y[i] * w.omega_inverse[i] : std::max(0.0, row_dot(qp.A, i, out.x) - qp.b[i]);
  }
}

}  // namespace

Status solve_bounded_qp(const BoundedQp& qp, const BoundedQpOptions& options, BoundedQpWorkspace& work, BoundedQpResult& out) {
  const Index n = qp.center.size();
  if (work.factor.rows() != n || work.S.rows() < qp.m) work.reserve(n, std::max(qp.m, work.S.rows()));
  if (out.x.size() != n) out.x.setZero(n), out.z.setZero(n);
  if (out.y.size() < qp.m) out.y.setZero(qp.m), out.slack.setZero(qp.m);
  if (!calc_weights(qp, work)) return out.status = Status::NumericalFailure;
  if (options.closed_form && has_closed_form(qp)) {
    solve_closed_form(qp, work, out);
    return out.status = Status::Solved;
  }
  solve_active_set(qp, options, work, out);
  return out.status;
}

}  // namespace stiction::control
