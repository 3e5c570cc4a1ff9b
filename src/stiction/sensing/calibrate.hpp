#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stiction/sensing/after_touch.hpp"
#include "stiction/sensing/link_torque.hpp"

namespace stiction::sensing {

/// External torques of a robot at rest, one column a row of the record.
struct RestRows {
  Eigen::MatrixXd q;            ///< (n_a × rows) [rad or m]
  Eigen::MatrixXd tau;          ///< (n_a × rows) as measured [N·m; N]
  std::vector<double> times{};  ///< [s] (rows); empty: unknown, and no drift is found
  std::vector<int> records{};   ///< number of the record of each row; empty: one record
  /// Rows in which something touches the robot; empty: none. They are no rest, and say what is left after a touch. They take times.
  std::vector<bool> touched{};
  std::vector<int> measured{};  ///< joints that have a torque sensor; empty: all. Of the others the noise is 1 and the rest 0
};

/// A rigid body that the robot's own model of gravity lacks, or has too much: what hangs on a link.
struct Payload {
  int body = -1;
  double mass = 0, mass_deviation = 0;                 ///< [kg]
  Eigen::Vector3d centre_L = Eigen::Vector3d::Zero();  ///< of mass, in the frame of the link [m]
};

struct CalibrationOptions {
  std::optional<int> payload_body{};  ///< link on which a payload may hang; nullopt: none is looked for
  double same_posture = 0.05;         ///< largest difference of joint positions of one posture [rad or m], > 0
  double settle = 1;                  ///< time after a touch from which on torques are those of rest again [s], > 0
};

/// Noise of torques, and how well it is known.
struct TorqueNoise {
  Eigen::MatrixXd covariance;  ///< (n_a × n_a) [(N·m)²]
  Eigen::VectorXd
      freedom;  ///< independent numbers by which that of each joint is known (n_a): TorqueModel::deviations are those of calc_student_bound()
};

/// What is known of torques after rows at rest.
struct Calibration {
  Eigen::VectorXd rest;    ///< offset of the torques as measured: the mean of the last record, less what a payload makes (n_a) [N·m; N]
  Eigen::MatrixXd within;  ///< covariance of one row about the mean of its record, with many rows (n_a × n_a) [(N·m)²]
  Eigen::MatrixXd noise;   ///< covariance of a torque less `rest`: `within` and the variance of the mean
  /// The same with the rest of another record of the same posture; empty where no posture has two records.
  Eigen::MatrixXd noise_between;
  Eigen::VectorXd drift;  ///< of a random walk (n_a) [N·m/√s]; empty without times
  std::optional<Payload> payload;
  Hysteresis hysteresis;                                 ///< what touches leave, where rows were touched
  int rows = 0, records = 0, postures = 0, freedom = 0;  ///< freedom: rows less records, by which noise is known
  std::vector<int> touched;        ///< rows that were left out, since a torque is too far from the others of its record
  std::vector<std::string> notes;  ///< a sentence each

  /// `rest` at a posture, with the payload. @param q (n_q)
  Eigen::VectorXd calc_rest(const world::Model& model, VectorRef q) const;
  /// Of a torque less the mean of rows at rest, after a touch: `within` and h² T² of Hysteresis. Both are known by few numbers, so that the sum of their shares is (Welch &
  /// Satterthwaite 1947). @param touch  T, largest torque of each joint in the touch (n_a) [N·m; N]; 0: none  @param seconds  since the touch, ≥ 0
  /// @param rest_rows  of which the rest is the mean, ≥ 1
  TorqueNoise calc_noise(VectorRef touch, double seconds, int rest_rows) const;
};

/// Offset, noise, drift and payload from rows at rest. The covariance is that of the rows about the mean of their record. Its correlations are shrunk towards 0 by the
/// share that their own errors explain (Schäfer & Strimmer 2005), and it is enlarged by ν/(ν − 2), the variance of Student's distribution with ν = rows − records.
/// Rows less than `settle` after a touch are no rest either, but say what a touch leaves (Hysteresis).
/// A payload is what four numbers m, m c explain of the offsets in three postures or more; it is reported if m is more than three deviations from 0.
/// @throws core::InvalidInput: sizes, not finite, no record with two rows, a torque that is the same in all rows, rows of which many are touched, touched rows without
/// times
/// Tests: tests/sensing/calibrate_test.cpp
Calibration calibrate(const world::Model& model, const RestRows& rows, const CalibrationOptions& options = {});

/// Torques with which the motors hold the robots against gravity at q (n_a) [N·m; N].
Eigen::VectorXd calc_holding_torques(const world::Model& model, VectorRef q);

/// Which sign total torques at rest have, against those that hold the robot.
struct SignCheck {
  int sign = 0;       ///< 1: of the motors on the links; −1: the other one; 0: these are not the total torques of this model
  double factor = 0;  ///< of the holding torques in what was measured, by least squares
  std::string message;
};
/// @param q, tau  of rows at rest (n_a × rows), total torques and not external ones
SignCheck check_sign(const world::Model& model, const Eigen::MatrixXd& q, const Eigen::MatrixXd& tau);

}  // namespace stiction::sensing
