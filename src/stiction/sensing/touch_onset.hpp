#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <deque>

#include "stiction/sensing/link_torque.hpp"

namespace stiction::sensing {

struct OnsetOptions {
  Eigen::MatrixXd noise;    ///< covariance of one row of torques about its slow offset (n × n) [(N·m)²]
  Eigen::VectorXd drift{};  ///< rate of the random walk of that offset (n) [N·m/√s]; empty: none
  /// Dry friction of the joints (n) [N·m; N], ≥ 0; empty: none. While a joint sticks or reverses, the torque contains an unknown part of
  /// it.
  Eigen::VectorXd friction{};
  /// Share of the largest torque in a touch by which the offset of each joint differs for `settle` seconds after the touch
  /// (Hysteresis), ≥ 0.
  double hysteresis = 0;
  double settle = 1;  ///< [s], > 0
  double false_alarms =
      1.0 / (3600 * 200);               ///< share of rows at which a false alarm begins, in (0, 0.1); the default is once an hour at 200 Hz
  double shift = 2;                     ///< change of the torques for which detection is fastest, in deviations of their noise, > 0
  int rest_rows = 1;                    ///< number of rows averaged to the given rest, ≥ 1; determines its uncertainty
  int quiet = 5;                        ///< consecutive rows within three deviations of the offset that end a touch, ≥ 1
  void validate(Eigen::Index n) const;  ///< @throws core::InvalidInput naming the field
};

/// Threshold h of a change test: with z of n independent normal numbers of variance 1, s ← (1 − κ/‖s + z‖)₊ (s + z) starts at 0 and passes
/// ‖s‖ > h after 1/rate rows in the mean (Crosier 1988). From a Markov chain of ‖s‖. @param allowance  κ, > 0  @param rate  in (0, 0.1)
double calc_onset_bound(Eigen::Index n, double allowance, double rate);

/// Detects when a touch begins, and averages its torques from then on into one measurement. While nothing touches the robot, a Kalman
/// filter follows the slow offset of the torques; the change test of calc_onset_bound() sums its whitened innovations. The touch began at
/// the row, among the last 100, since which the innovations are least likely without a touch (the largest ‖Σ z‖²/m over m rows). From there
/// on the offset is held and the mean of the torques becomes more precise. If the joints stand still, it is the torque of the mean force,
/// which is in the friction cone as well. Belongs to one thread.
/// Tests: tests/sensing/touch_onset_test.cpp
class TouchOnset {
 public:
  /// @param rest  torques without contact (n)  @throws core::InvalidInput: options, sizes, not finite
  TouchOnset(const Eigen::VectorXd& rest, OnsetOptions options);

  /// Processes a row of torques. @param dt  time since the last row [s], > 0  @returns whether something touches the robot
  /// @throws core::InvalidInput: sizes, not finite
  bool update(VectorRef tau, double dt) { return update(tau, dt, Eigen::VectorXd::Zero(tau.size())); }
  /// The same for joints with friction. @param sign  tanh(q̇/v₀), the sign of friction (n). Friction becomes uncertain within ± its size:
  /// as far as the sign has changed, and within half a second while a joint sticks.
  bool update(VectorRef tau, double dt, VectorRef sign);

  /// While true, a touch does not end, however small its torques are: the robot presses harder to tell whether something touches.
  void keep_touch(bool keep) { keeps_ = keep, quiet_rows_ = 0; }

  bool touches() const { return alarm_; }
  int rows() const { return rows_; }                     ///< number of rows since the touch began, or since the sum was last 0
  const Eigen::VectorXd& rest() const { return held_; }  ///< offset before the touch (n) [N·m; N]
  Eigen::VectorXd mean() const;                          ///< mean of the torques of these rows (n); rest() if there are none
  Eigen::MatrixXd noise() const;                         ///< covariance of mean() − rest() (n × n) [(N·m)²]
  double sum() const { return sum_.norm(); }             ///< ‖s‖
  double bound() const { return bound_; }                ///< h

 private:
  /// A row before a touch was detected.
  struct Row {
    Eigen::VectorXd tau, z, x, sign;  ///< x, sign: filter state and sign of friction before the row
    double dt = 0;
  };
  Eigen::VectorXd sum_parts(const Eigen::VectorXd& x) const;
  Eigen::MatrixXd calc_covariance() const;
  Eigen::MatrixXd calc_variance() const;
  void hold(const Eigen::VectorXd& x, const Eigen::VectorXd& sign);
  void restart();
  void find_beginning();
  bool is_quiet(const Eigen::VectorXd& innovation);
  void loosen(const Eigen::VectorXd& before, double dt);
  void settle(double dt);
  Eigen::VectorXd calc_left() const;
  Eigen::VectorXd calc_hidden() const;
  Eigen::MatrixXd calc_touch_variance() const;

  OnsetOptions options_;
  double bound_;
  Eigen::Index n_;
  Eigen::VectorXd x_;  ///< state of the Kalman filter: rest, then change of friction since that rest if there is friction (n or 2n)
  Eigen::MatrixXd P_;  ///< covariance of x_
  Eigen::VectorXd held_x_, held_;  ///< x before the touch, and the torques of that state
  Eigen::MatrixXd held_variance_;
  Eigen::VectorXd sum_, total_, sign_, held_sign_;
  Eigen::VectorXd peak_, left_;  ///< largest torques of the touch; remaining offset variance of the last touch
  std::deque<Row> recent_;
  double since_ = 0;  ///< time since the touch began [s]
  int rows_ = 0, quiet_rows_ = 0;
  bool alarm_ = false, keeps_ = false;
};

}  // namespace stiction::sensing
