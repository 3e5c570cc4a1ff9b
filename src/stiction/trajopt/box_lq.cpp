#include "stiction/trajopt/box_lq.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "stiction/core/invalid_input.hpp"
#include "stiction/trajopt/riccati.hpp"

namespace stiction::trajopt {
namespace {

using core::Status;
using Eigen::VectorXd;
using Stage = BoxLqWorkspace::Stage;

/// Bounds closer than this are widened to it, because the interior-point method needs an interior.
constexpr double kNarrow = 1e-9;
/// Largest step, as a share of the way to the nearest bound.
constexpr double kToBoundary = 0.995;
/// Distance of the start from the bounds, as a share of their width.
constexpr double kInside = 0.01;

void require_finite(const std::string& field, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  if (!values.allFinite()) core::throw_invalid(field, "a number that is not finite", "finite numbers");
}

void validate(const BoxLqProblem& p) {
  if (p.stages.empty()) core::throw_invalid("stages", "none", "at least one");
  const Eigen::Index n = p.x0.size(), m = p.R.size();
  require_finite("x0", p.x0);
  for (const double r : p.R) core::require_nonnegative("R", r);
  for (std::size_t t = 0; t < p.stages.size(); ++t) {
    const LqStage& s = p.stages[t];
    const auto field = [t](const char* name) { return "stages[" + std::to_string(t) + "]." + name; };
    core::require_size(field("A rows"), s.A.rows(), n);
    core::require_size(field("A columns"), s.A.cols(), n);
    core::require_size(field("B rows"), s.B.rows(), n);
    core::require_size(field("B columns"), s.B.cols(), m);
    core::require_size(field("Q rows"), s.Q.rows(), n);
    core::require_size(field("Q columns"), s.Q.cols(), n);
    core::require_size(field("q"), s.q.size(), n);
    core::require_size(field("r"), s.r.size(), m);
    core::require_size(field("lower"), s.lower.size(), m);
    core::require_size(field("upper"), s.upper.size(), m);
    core::require_size(field("Gx rows"), s.Gx.rows(), s.g.size());
    core::require_size(field("Gu rows"), s.Gu.rows(), s.g.size());
    if (s.g.size() > 0) {
      core::require_size(field("Gx columns"), s.Gx.cols(), n);
      core::require_size(field("Gu columns"), s.Gu.cols(), m);
    }
    require_finite(field("A"), s.A), require_finite(field("B"), s.B);
    require_finite(field("Q"), s.Q), require_finite(field("q"), s.q), require_finite(field("r"), s.r);
    require_finite(field("lower"), s.lower), require_finite(field("upper"), s.upper);
    require_finite(field("Gx"), s.Gx), require_finite(field("Gu"), s.Gu), require_finite(field("g"), s.g);
    for (Eigen::Index i = 0; i < m; ++i) {
      if (s.lower[i] > s.upper[i]) {
        core::throw_invalid(field("lower") + "[" + std::to_string(i) + "]", std::to_string(s.lower[i]),
                            "at most upper = " + std::to_string(s.upper[i]));
      }
    }
  }
}

class Solver {
 public:
  Solver(const BoxLqProblem& problem, const BoxLqOptions& options, BoxLqWorkspace& work)
      : p_(problem), options_(options), w_(work), n_(problem.x0.size()), m_(problem.R.size()), T_(problem.stages.size()) {}

  Status run(BoxLqResult& out) {
    start();
    out.status = Status::MaxIterations;
    for (out.iterations = 0; out.iterations < options_.max_iterations; ++out.iterations) {
      out.gap = gap();
      if (out.gap <= options_.tolerance) {
        out.status = Status::Solved;
        break;
      }
      if (!improve()) {
        if (out.iterations == 0) out.status = Status::NumericalFailure;  // in later iterations: rounding allows no further progress
        break;
      }
    }
    if (out.status == Status::MaxIterations) out.gap = gap();
    if (out.iterations == 0 && !factorise(p_, w_)) out.status = Status::NumericalFailure;
    store(out);
    return out.status;
  }

 private:
  double low(std::size_t t, Eigen::Index i) const {
    const LqStage& s = p_.stages[t];
    return std::min(s.lower[i], 0.5 * (s.lower[i] + s.upper[i] - kNarrow));
  }
  double high(std::size_t t, Eigen::Index i) const {
    const LqStage& s = p_.stages[t];
    return std::max(s.upper[i], 0.5 * (s.lower[i] + s.upper[i] + kNarrow));
  }
  /// Takes one step: a predictor without centring, then the corrector. @returns false if the factorisation or the step failed
  bool improve() {
    if (!factorise(p_, w_)) return false;
    const double mu = complementarity();
    aim(0, false);
    const double to_boundary = try_step();
    if (std::isnan(to_boundary)) return false;
    const double predicted = complementarity_after(std::min(1.0, to_boundary));
    aim(std::pow(predicted / mu, 3) * mu, true);
    const double length = try_step();
    return !std::isnan(length) && take(std::min(1.0, kToBoundary * length));
  }

  /// Visits f(stage data, stage, time).
  template <class F>
  void each(F&& f) {
    for (std::size_t t = 0; t < T_; ++t) f(p_.stages[t], w_.stages[t], t);
  }

  /// Starts with zero inputs, or the nearest inputs inside the bounds, and with multipliers of the size of the gradient there. A start
  /// farther away would let unstable dynamics grow the states until rounding leaves no correct digit.
  void start() {
    w_.stages.resize(T_);
    count_ = 0;
    each([&](const LqStage& d, Stage& s, std::size_t t) {
      const Eigen::Index k = d.g.size();
      s.u = VectorXd::Zero(m_);
      s.s_lower.resize(m_), s.s_upper.resize(m_);
      for (Eigen::Index i = 0; i < m_; ++i) {
        const double margin = kInside * (high(t, i) - low(t, i));
        s.u[i] = std::clamp(0.0, low(t, i) + margin, high(t, i) - margin);
        s.s_lower[i] = s.u[i] - low(t, i);
        s.s_upper[i] = high(t, i) - s.u[i];
      }
      for (VectorXd* v : {&s.z_lower, &s.z_upper}) v->setZero(m_);
      for (VectorXd* v : {&s.s_row, &s.y_row}) v->setZero(k);
      for (VectorXd* v : {&s.dz_lower, &s.dz_upper, &s.du, &s.center_lower, &s.center_upper}) v->resize(m_);
      for (VectorXd* v : {&s.ds_row, &s.dy_row, &s.center_row}) v->resize(k);
      s.dx_next.resize(n_);
      count_ += 2 * static_cast<double>(m_) + static_cast<double>(k);
    });
    simulate();
    calc_gradient();
    double work = 0;  // Σ |gradient| · half of the width between the bounds
    each([&](const LqStage&, Stage& s, std::size_t t) {
      for (Eigen::Index i = 0; i < m_; ++i) work += std::abs(s.gradient[i]) * 0.5 * (high(t, i) - low(t, i));
    });
    const double mu = std::max(work, options_.tolerance) / count_;
    each([&](const LqStage& d, Stage& s, std::size_t t) {
      for (Eigen::Index i = 0; i < m_; ++i) {
        s.z_lower[i] = mu / s.s_lower[i];
        s.z_upper[i] = mu / s.s_upper[i];
      }
      row_value(p_, w_, t, s.s_row);
      const double unit = d.g.size() > 0 ? d.g.cwiseAbs().mean() + 1e-12 : 1.0;
      s.s_row = s.s_row.cwiseMax(0.1 * unit);
      s.y_row = mu * s.s_row.cwiseInverse();
    });
    unbalanced_ = calc_imbalance();
  }

  void simulate() {
    each([&](const LqStage& d, Stage& s, std::size_t t) {
      s.x_next.noalias() = d.A * state(p_, w_, t);
      s.x_next.noalias() += d.B * s.u;
    });
  }

  /// Gradient of the Lagrangian with respect to u_t at the current point, by the costates, without the multipliers of the bounds.
  void calc_gradient() {
    w_.costate.setZero(n_);
    for (std::size_t t = T_; t-- > 0;) {
      const LqStage& d = p_.stages[t];
      Stage& s = w_.stages[t];
      w_.costate += d.q;
      w_.costate.noalias() += d.Q * s.x_next;
      change(p_, w_, t, w_.change);
      s.gradient = p_.R.cwiseProduct(w_.change);
      if (t + 1 < T_) {
        change(p_, w_, t + 1, w_.change);
        s.gradient -= p_.R.cwiseProduct(w_.change);
      }
      s.gradient.noalias() += d.B.transpose() * w_.costate;
      w_.x.noalias() = d.A.transpose() * w_.costate;
      if (d.g.size() > 0) {
        s.gradient.noalias() -= d.Gu.transpose() * s.y_row;
        w_.x.noalias() -= d.Gx.transpose() * s.y_row;
      }
      w_.costate.swap(w_.x);
    }
  }

  double cost() {
    double out = 0;
    each([&](const LqStage& d, Stage& s, std::size_t t) {
      w_.x.noalias() = d.Q * s.x_next;
      change(p_, w_, t, w_.change);
      out += 0.5 * s.x_next.dot(w_.x) + d.q.dot(s.x_next) + 0.5 * w_.change.cwiseAbs2().dot(p_.R);
    });
    return out;
  }

  /// Bound of the distance to the minimum: f(u) − f* ≤ Σ s·z + Σ |residual| · width, since f is convex and every input lies within its
  /// bounds. Rows that do not hold yet count with their multipliers. Residuals are linear: a step of length α leaves 1 − α of them.
  double gap() { return count_ * complementarity() + unbalanced_; }

  /// Σ |residual| · width at the start.
  double calc_imbalance() {
    calc_gradient();
    double out = 0;
    each([&](const LqStage& d, Stage& s, std::size_t t) {
      for (Eigen::Index i = 0; i < m_; ++i) out += std::abs(s.gradient[i] - s.z_lower[i] + s.z_upper[i]) * (high(t, i) - low(t, i));
      if (d.g.size() == 0) return;
      row_value(p_, w_, t, w_.row);
      out += (w_.row - s.s_row).cwiseAbs().dot(s.y_row);
    });
    return out;
  }

  double complementarity() {
    double sum = 0;
    each([&](const LqStage&, Stage& s, std::size_t) { sum += s.s_lower.dot(s.z_lower) + s.s_upper.dot(s.z_upper) + s.s_row.dot(s.y_row); });
    return sum / count_;
  }

  double complementarity_after(double alpha) {
    double sum = 0;
    each([&](const LqStage&, Stage& s, std::size_t) {
      sum += (s.s_lower + alpha * s.du).dot(s.z_lower + alpha * s.dz_lower);
      sum += (s.s_upper - alpha * s.du).dot(s.z_upper + alpha * s.dz_upper);
      sum += (s.s_row + alpha * s.ds_row).dot(s.y_row + alpha * s.dy_row);
    });
    return sum / count_;
  }

  /// Sets the target of every product slack · multiplier to mu; `correct` adds the second-order term of the step tried before.
  void aim(double mu, bool correct) {
    each([&](const LqStage&, Stage& s, std::size_t) {
      s.center_lower.setConstant(mu), s.center_upper.setConstant(mu), s.center_row.setConstant(mu);
      if (!correct) return;
      s.center_lower -= s.du.cwiseProduct(s.dz_lower);
      s.center_upper += s.du.cwiseProduct(s.dz_upper);
      s.center_row -= s.ds_row.cwiseProduct(s.dy_row);
    });
  }

  /// Computes all parts of the Newton step to the target products with the current factorisation.
  /// @returns the longest step that keeps slacks and multipliers positive; NaN if the step is not finite, which happens when unstable
  ///   dynamics leave no correct digit
  double try_step() {
    calc_newton_step(p_, w_);
    double limit = std::numeric_limits<double>::infinity();
    bool finite = true;
    const auto see = [&limit](double value, double change) {
      if (change < 0) limit = std::min(limit, -value / change);
    };
    each([&](const LqStage& d, Stage& s, std::size_t) {
      finite = finite && s.du.allFinite() && s.dx_next.allFinite();
      for (Eigen::Index i = 0; i < m_; ++i) {
        const double sl = s.s_lower[i], su = s.s_upper[i];
        s.dz_lower[i] = (s.center_lower[i] - s.z_lower[i] * s.du[i]) / sl - s.z_lower[i];
        s.dz_upper[i] = (s.center_upper[i] + s.z_upper[i] * s.du[i]) / su - s.z_upper[i];
        see(sl, s.du[i]), see(su, -s.du[i]);
        see(s.z_lower[i], s.dz_lower[i]), see(s.z_upper[i], s.dz_upper[i]);
      }
      for (Eigen::Index i = 0; i < d.g.size(); ++i) {
        s.dy_row[i] = (s.center_row[i] - s.y_row[i] * s.ds_row[i]) / s.s_row[i] - s.y_row[i];
        see(s.s_row[i], s.ds_row[i]), see(s.y_row[i], s.dy_row[i]);
      }
    });
    return finite ? limit : std::numeric_limits<double>::quiet_NaN();
  }

  bool take(double alpha) {
    if (!(alpha > 0)) return false;
    each([&](const LqStage&, Stage& s, std::size_t) {
      s.u += alpha * s.du;
      // dx_next includes the feedback of forward(). A simulation from the inputs alone would amplify rounding errors in unstable dynamics.
      s.x_next += alpha * s.dx_next;
      s.s_lower += alpha * s.du;
      s.s_upper -= alpha * s.du;
      s.z_lower += alpha * s.dz_lower;
      s.z_upper += alpha * s.dz_upper;
      s.s_row += alpha * s.ds_row;
      s.y_row += alpha * s.dy_row;
    });
    unbalanced_ *= 1 - alpha;
    return true;
  }

  void store(BoxLqResult& out) {
    out.u.resize(T_), out.x.resize(T_ + 1), out.gains.resize(T_);
    out.x[0] = p_.x0;
    out.cost = cost();
    each([&](const LqStage&, Stage& s, std::size_t t) {
      out.u[t] = s.u;
      out.x[t + 1] = s.x_next;
      out.gains[t] = s.gains;
      if (!s.gains.K_x.allFinite() || !s.gains.K_u.allFinite()) out.gains[t].K_x.setZero(), out.gains[t].K_u.setZero();
    });
  }

  const BoxLqProblem& p_;
  const BoxLqOptions& options_;
  BoxLqWorkspace& w_;
  Eigen::Index n_, m_;
  std::size_t T_;
  double count_ = 0;       // number of products slack · multiplier
  double unbalanced_ = 0;  // part of gap() that comes from the residuals
};

}  // namespace

Status solve_box_lq(const BoxLqProblem& problem, const BoxLqOptions& options, BoxLqWorkspace& work, BoxLqResult& out) {
  core::require_positive("tolerance", options.tolerance);
  if (options.max_iterations < 1) core::throw_invalid("max_iterations", std::to_string(options.max_iterations), "at least 1");
  validate(problem);
  return Solver(problem, options, work).run(out);
}

}  // namespace stiction::trajopt
