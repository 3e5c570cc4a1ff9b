#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <deque>

#include "stiction/sensing/link_torque.hpp"

namespace stiction::sensing {

struct OnsetOptions {
  Eigen::MatrixXd noise;    ///< covariance of one row of torques about its slow offset (n × n) [(N·m)²]
  Eigen::VectorXd drift{};  ///< of that offset, a random walk (n) [N·m/√s]; empty: none
  /// Dry friction of joints, of which torques have an unknown part while a joint sticks or turns round (n) [N·m; N], ≥ 0; empty: none.
  Eigen::VectorXd friction{};
  /// What a touch leaves: for `settle` seconds after it the offset of each joint is another one, by this share of the largest torque in the touch (Hysteresis), ≥ 0.
  double hysteresis = 0;
  double settle = 1;  ///< [s], > 0
  double false_alarms =
      1.0 / (3600 * 200);  ///< share of rows at which an alarm begins where nothing touches, in (0, 0.1): once an hour at 200 Hz
  double shift = 2;        ///< change of the torques that is to be found soonest, in deviations of their noise, > 0
  int rest_rows = 1;       ///< rows of which the rest that is given is the mean, ≥ 1: so sure it is
  int quiet = 5;           ///< rows in a row within three deviations of the offset that end a touch, ≥ 1
  void validate(Eigen::Index n) const;  ///< @throws core::InvalidInput naming the field
};

/// Largest sum h of a change test: with z of n independent normal numbers of variance 1, s ← (1 − κ/‖s + z‖)₊ (s + z) starts at 0 and passes ‖s‖ > h after 1/rate rows
/// in the mean (Crosier 1988). From a Markov chain of ‖s‖. @param allowance  κ, > 0  @param rate  in (0, 0.1)
double calc_onset_bound(Eigen::Index n, double allowance, double rate);

/// When a touch begins, and its torques since then as one measurement. The slow offset of the torques is followed by a Kalman filter where nothing touches; its innovations,
/// whitened, are added up by the change test of calc_onset_bound(). The touch began where the innovations since then are least likely without it, among
/// the last 100 rows (the largest ‖Σ z‖²/m over m rows). From there on the offset is held and the mean of the torques grows sharper: with the joints still, it is the torque of the mean force, which is in the cone as well. Belongs to one thread.
/// Tests: tests/sensing/touch_onset_test.cpp
class TouchOnset {
 public:
  /// @param rest  torques where nothing touches (n)  @throws core::InvalidInput: options, sizes, not finite
  TouchOnset(const Eigen::VectorXd& rest, OnsetOptions options);

  /// A row of torques. @param dt  since the one before [s], > 0  @returns whether something touches  @throws core::InvalidInput: sizes, not finite
  bool update(VectorRef tau, double dt) { return update(tau, dt, Eigen::VectorXd::Zero(tau.size())); }
  /// The same where joints have friction. @param sign  of it, tanh(q̇/v₀) (n). By as much as the sign changed, and while a joint sticks within half a second, friction
  /// may be any other within ± its size.
  bool update(VectorRef tau, double dt, VectorRef sign);

  bool touches() const { return alarm_; }
  int rows() const { return rows_; }                     ///< since the touch began, or since the sum was last 0
  const Eigen::VectorXd& rest() const { return held_; }  ///< offset before the touch (n) [N·m; N]
  Eigen::VectorXd mean() const;                          ///< of the torques since then (n); rest() where there are none
  Eigen::MatrixXd noise() const;                         ///< covariance of mean() − rest() (n × n) [(N·m)²]
  double sum() const { return sum_.norm(); }             ///< ‖s‖
  double bound() const { return bound_; }                ///< h

 private:
  /// A row before a touch was found.
  struct Row {
    Eigen::VectorXd tau, z, x;  ///< x: before the row
    double dt = 0;
  };
  Eigen::VectorXd sum_parts(const Eigen::VectorXd& x) const;
  Eigen::MatrixXd calc_covariance() const;
  Eigen::MatrixXd calc_variance() const;
  void hold(const Eigen::VectorXd& x);
  void restart();
  void find_beginning();
  bool is_quiet(const Eigen::VectorXd& innovation);
  void loosen(VectorRef sign, double dt);
  void settle(double dt);
  Eigen::VectorXd calc_left() const;

  OnsetOptions options_;
  double bound_;
  Eigen::Index n_;
  Eigen::VectorXd x_;              ///< the offset, and with friction that of every joint (n or 2n)
  Eigen::MatrixXd P_;              ///< its variance
  Eigen::VectorXd held_x_, held_;  ///< x before the touch, and its torques
  Eigen::MatrixXd held_variance_;
  Eigen::VectorXd sum_, total_, sign_;
  Eigen::VectorXd peak_, left_;  ///< largest torques of the touch, and variance that is left of the one before
  std::deque<Row> recent_;
  double since_ = 0;  ///< time since the touch began [s]
  int rows_ = 0, quiet_rows_ = 0;
  bool alarm_ = false;
};

}  // namespace stiction::sensing
