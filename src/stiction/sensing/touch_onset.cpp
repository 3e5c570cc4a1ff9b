#include "stiction/sensing/touch_onset.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/torque_noise.hpp"

namespace stiction::sensing {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// P(χ²_n ≤ x) for even and odd n, by its recursion from n = 1 or 2.
VectorXd chi_square_below(Index first, Index count, double x) {
  VectorXd out(count);
  const double half = 0.5 * x;
  Index n = first % 2 == 0 ? 2 : 1;
  double below = n == 2 ? -std::expm1(-half) : std::erf(std::sqrt(half));
  double term = n == 2 ? half * std::exp(-half) : std::sqrt(half) * std::exp(-half) / std::tgamma(1.5);  // (x/2)^{n/2} e^{−x/2}/Γ(n/2 + 1)
  for (Index i = 0; i < count;) {
    if (n == first + 2 * i) out[i++] = below;
    below -= term;
    n += 2;
    term *= half / (0.5 * static_cast<double>(n));
  }
  return out.cwiseMax(0);
}

/// P(‖r e + z‖² ≤ x) with z of n normal numbers: a Poisson mixture of χ².
double shifted_below(Index n, double r, double x) {
  if (x <= 0) return 0;
  const double mean = 0.5 * r * r;
  const auto terms = static_cast<Index>(mean + 10 * std::sqrt(mean + 1) + 10);
  const VectorXd below = chi_square_below(n, terms, x);
  double out = 0;
  for (Index j = 0; j < terms; ++j)
    out += below[j] * std::exp(static_cast<double>(j) * std::log(std::max(mean, 1e-300)) - mean - std::lgamma(static_cast<double>(j) + 1));
  return out;
}

/// Mean number of rows until ‖s‖ > h from s = 0, with ‖s‖ on a grid.
double calc_run_length(Index n, double allowance, double h) {
  constexpr Index kStates = 40;  // 0, and the middles of as many intervals less one
  const double width = h / (static_cast<double>(kStates) - 0.5);
  MatrixXd A = MatrixXd::Identity(kStates, kStates);
  for (Index i = 0; i < kStates; ++i) {
    double before = 0;
    for (Index j = 0; j < kStates; ++j) {
      const double upper = (static_cast<double>(j) + 0.5) * width + allowance;
      const double below = shifted_below(n, static_cast<double>(i) * width, upper * upper);
      A(i, j) -= below - before;
      before = below;
    }
  }
  return A.partialPivLu().solve(VectorXd::Ones(kStates))[0];
}

}  // namespace

void OnsetOptions::validate(Index n) const {
  double uniform = 0;
  (void)make_covariance(noise, static_cast<int>(n), uniform);
  if (drift.size() != 0) {
    core::require_size("drift", drift.size(), n);
    for (const double x : drift) core::require_nonnegative("drift", x);
  }
  if (friction.size() != 0) {
    core::require_size("friction", friction.size(), n);
    for (const double x : friction) core::require_nonnegative("friction", x);
  }
  if (!(false_alarms > 0 && false_alarms < 0.1))
    core::throw_invalid("false_alarms", fmt::format("{}", false_alarms), "a number in (0, 0.1)");
  core::require_positive("shift", shift);
  core::require_nonnegative("hysteresis", hysteresis);
  core::require_positive("settle", settle);
  if (rest_rows < 1) core::throw_invalid("rest_rows", fmt::format("{}", rest_rows), "an integer ≥ 1");
  if (quiet < 1) core::throw_invalid("quiet", fmt::format("{}", quiet), "an integer ≥ 1");
}

double calc_onset_bound(Index n, double allowance, double rate) {
  double low = 0.1, high = 1;
  while (calc_run_length(n, allowance, high) < 1 / rate) {
    low = high;
    high *= 1.5;
  }
  constexpr int kHalvings = 24;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (calc_run_length(n, allowance, middle) < 1 / rate ? low : high) = middle;
  }
  return high;
}

TouchOnset::TouchOnset(const VectorXd& rest, OnsetOptions options) : options_(std::move(options)), n_(rest.size()) {
  core::require_finite("rest", {rest.data(), static_cast<std::size_t>(n_)});
  options_.validate(n_);
  bound_ = calc_onset_bound(n_, 0.5 * options_.shift, options_.false_alarms);
  const Index states = options_.friction.size() > 0 ? 2 * n_ : n_;
  x_.setZero(states);
  x_.head(n_) = rest;
  P_.setZero(states, states);
  P_.topLeftCorner(n_, n_) = options_.noise / options_.rest_rows;
  sign_.setZero(n_);
  left_.setZero(n_);
  restart();
}

/// Torques of a filter state: the offset plus the friction.
VectorXd TouchOnset::sum_parts(const VectorXd& x) const {
  VectorXd out = x.head(n_);
  if (x.size() > n_) out += x.tail(n_);
  return out;
}

/// P Hᵀ, with the torques H x = sum_parts(x).
MatrixXd TouchOnset::calc_covariance() const {
  MatrixXd out = P_.leftCols(n_);
  if (P_.cols() > n_) out += P_.rightCols(n_);
  return out;
}

/// H P Hᵀ.
MatrixXd TouchOnset::calc_variance() const {
  const MatrixXd half = calc_covariance();
  MatrixXd out = half.topRows(n_);
  if (half.rows() > n_) out += half.bottomRows(n_);
  return out;
}

void TouchOnset::hold(const VectorXd& x, const VectorXd& sign) {
  held_x_ = x;
  held_ = sum_parts(x);
  held_sign_ = sign;
  held_variance_ = calc_variance();
}

void TouchOnset::restart() {
  hold(x_, sign_);
  sum_.setZero(n_);
  total_.setZero(n_);
  peak_.setZero(n_);
  since_ = 0;
  rows_ = quiet_rows_ = 0;
  alarm_ = false;
}

void TouchOnset::find_beginning() {
  VectorXd added = VectorXd::Zero(n_);
  double most = -1, rows = 0;
  std::size_t beginning = recent_.size() - 1;
  for (std::size_t i = recent_.size(); i-- > 0;) {
    added += recent_[i].z;
    if (const double gain = added.squaredNorm() / ++rows; gain > most) {
      most = gain;
      beginning = i;
    }
  }
  hold(recent_[beginning].x, recent_[beginning].sign);
  total_.setZero();
  since_ = 0;
  for (std::size_t i = beginning; i < recent_.size(); ++i) {
    total_ += recent_[i].tau;
    peak_ = peak_.cwiseMax((recent_[i].tau - held_).cwiseAbs());
    since_ += recent_[i].dt;
  }
  if (options_.drift.size() != 0)
    P_.diagonal().head(n_).array() += since_ * options_.drift.array().square();  // the offset has drifted for the time of the touch
  rows_ = static_cast<int>(recent_.size() - beginning);
  recent_.clear();
}

bool TouchOnset::is_quiet(const VectorXd& z) {
  const auto n = static_cast<double>(z.size());
  quiet_rows_ = z.squaredNorm() <= n + 3 * std::sqrt(2 * n) ? quiet_rows_ + 1 : 0;
  return quiet_rows_ >= options_.quiet && !keeps_;
}

/// Makes the friction of a joint that sticks or reverses uncertain: a mean-reverting process, so that after a while friction may have any
/// value within ± its size. Its variance never exceeds that size, so a slowly growing touch is not mistaken for friction.
void TouchOnset::loosen(const VectorXd& before, double dt) {
  constexpr double kCreep = 0.5;  // time in which the torque of a sticking joint may change to any value [s]
  for (Index j = 0; j < options_.friction.size(); ++j) {
    const double changed = std::abs(sign_[j] - before[j]) + dt / kCreep * (1 - sign_[j] * sign_[j]);
    const double kept = std::exp(-changed), variance = options_.friction[j] * options_.friction[j] / 3;
    const Index k = n_ + j;
    x_[k] *= kept;
    P_.row(k) *= kept;
    P_.col(k) *= kept;
    P_(k, k) += (1 - kept * kept) * variance;
  }
}

/// Variance of the offset that the touch leaves.
VectorXd TouchOnset::calc_left() const { return (options_.hysteresis * peak_).cwiseAbs2(); }

/// Variance of the change of friction in a touch, which stops the joints. Friction of a joint at rest may have any value within ± its size. Before the touch the same holds,
/// unless the joint slid: then the observer subtracted its friction.
VectorXd TouchOnset::calc_hidden() const {
  if (options_.friction.size() == 0) return VectorXd::Zero(n_);
  return options_.friction.array().square() * (2 - held_sign_.array().abs()) / 3;
}

/// Variance of the torques without contact during a touch. P counts friction that changed in the touch, as calc_hidden() does, so the variance before the touch is used.
MatrixXd TouchOnset::calc_touch_variance() const {
  if (options_.friction.size() == 0) return calc_variance();
  MatrixXd out = held_variance_;
  out.diagonal() += calc_hidden();
  if (options_.drift.size() != 0) out.diagonal().array() += since_ * options_.drift.array().square();
  return out;
}

/// Lets the offset left by a touch fade, by e² within `settle`: at every moment the offset may drift by the remaining amount.
void TouchOnset::settle(double dt) {
  if (!(options_.hysteresis > 0)) return;
  const double kept = std::exp(-4 * dt / options_.settle);
  P_.diagonal().head(n_) += (1 - kept) * left_;
  left_ *= kept;
}

bool TouchOnset::update(VectorRef tau, double dt, VectorRef sign) {
  core::require_size("tau", tau.size(), n_);
  core::require_finite("tau", {tau.data(), static_cast<std::size_t>(tau.size())});
  core::require_positive("dt", dt);
  core::require_size("sign", sign.size(), n_);
  const VectorXd sign_before = std::exchange(sign_, sign), x_before = x_;
  loosen(sign_before, dt);
  if (options_.drift.size() != 0) P_.diagonal().head(n_).array() += dt * options_.drift.array().square();
  settle(dt);
  MatrixXd variance = (alarm_ ? calc_touch_variance() : calc_variance()) + options_.noise;
  if (alarm_) variance.diagonal() += calc_left();
  const Eigen::LLT<MatrixXd> factor(variance);
  const VectorXd innovation = tau - (alarm_ ? held_ : sum_parts(x_)), z = factor.matrixL().solve(innovation);
  if (alarm_) {
    total_ += tau;
    peak_ = peak_.cwiseMax(innovation.cwiseAbs());
    since_ += dt;
    ++rows_;
    if (is_quiet(z)) {
      x_ = held_x_;  // P contains the drift during the touch
      left_ = calc_left();
      P_.diagonal().head(n_) += left_;
      restart();
    }
    return alarm_;
  }
  constexpr std::size_t kRecent = 100;
  recent_.push_back({tau, z, x_before, sign_before, dt});
  if (recent_.size() > kRecent) recent_.pop_front();
  const VectorXd next = sum_ + z;
  const double length = next.norm(), left = length - 0.5 * options_.shift;
  const MatrixXd covariance = calc_covariance(), gain = factor.solve(covariance.transpose()).transpose();
  x_ += gain * innovation;
  if (options_.friction.size() != 0) x_.tail(n_) = x_.tail(n_).cwiseMax(-2 * options_.friction).cwiseMin(2 * options_.friction);
  P_ -= gain * covariance.transpose();
  hold(x_, sign_);
  sum_ = left > 0 ? VectorXd(left / length * next) : VectorXd::Zero(next.size());
  alarm_ = left > bound_;
  if (alarm_) find_beginning();
  return alarm_;
}

VectorXd TouchOnset::mean() const { return rows_ > 0 ? VectorXd(total_ / rows_) : held_; }

MatrixXd TouchOnset::noise() const {
  MatrixXd out = held_variance_ + options_.noise / std::max(1, rows_);
  out.diagonal() += calc_hidden();
  if (options_.drift.size() != 0) out.diagonal().array() += since_ * options_.drift.array().square();
  return out;
}

}  // namespace stiction::sensing
