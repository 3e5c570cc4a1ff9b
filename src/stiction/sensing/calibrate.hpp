#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stiction/sensing/after_touch.hpp"
#include "stiction/sensing/link_torque.hpp"

namespace stiction::sensing {

/// External torques of a robot at rest; each column is one row of the record.
struct RestRows {
  Eigen::MatrixXd q;            ///< (n_a × rows) [rad or m]
  Eigen::MatrixXd tau;          ///< (n_a × rows) as measured [N·m; N]
  std::vector<double> times{};  ///< [s] (rows); empty: unknown, and no drift is found
  std::vector<int> records{};   ///< record number of each row; empty: all rows are one record
  /// Rows in which something touches the robot; empty: none. They are not used as rest; Hysteresis is learned from them. They require
  /// `times`.
  std::vector<bool> touched{};
  std::vector<int> measured{};  ///< joints with a torque sensor; empty: all. The other joints get noise 1 and rest 0
};

/// A rigid body on a link that the robot's model of gravity lacks, or contains although it is absent (negative mass).
struct Payload {
  int body = -1;
  double mass = 0, mass_deviation = 0;                 ///< [kg]
  Eigen::Vector3d centre_L = Eigen::Vector3d::Zero();  ///< centre of mass in the frame of the link [m]
};

struct CalibrationOptions {
  std::optional<int> payload_body{};  ///< link that may carry a payload; nullopt: no payload is sought
  double same_posture = 0.05;         ///< largest difference of joint positions within one posture [rad or m], > 0
  double settle = 1;                  ///< time after a touch until torques are those of rest again [s], > 0
};

/// Noise of torques, and the number of data behind it.
struct TorqueNoise {
  Eigen::MatrixXd covariance;  ///< (n_a × n_a) [(N·m)²]
  Eigen::VectorXd freedom;  ///< degrees of freedom of the noise of each joint (n_a), for calc_student_bound() and TorqueModel::deviations
};

/// Result of calibrate(): the torque model that follows from rows at rest.
struct Calibration {
  Eigen::VectorXd rest;    ///< offset of the measured torques: the mean of the last record minus the torques of the payload (n_a) [N·m; N]
  Eigen::MatrixXd within;  ///< covariance of one row about the mean of its record, for many rows (n_a × n_a) [(N·m)²]
  Eigen::MatrixXd noise;   ///< covariance of a torque minus `rest`: `within` plus the variance of the mean
  /// The same if `rest` comes from another record of the same posture; empty if no posture has two records.
  Eigen::MatrixXd noise_between;
  Eigen::VectorXd drift;  ///< rate of a random walk of the offset (n_a) [N·m/√s]; empty without times
  std::optional<Payload> payload;
  Hysteresis hysteresis;                                 ///< torques left by touches, if rows were touched
  int rows = 0, records = 0, postures = 0, freedom = 0;  ///< freedom: rows minus records, the degrees of freedom of the noise
  std::vector<int> touched;                              ///< rows left out because a torque is too far from the others of its record
  std::vector<std::string> notes;                        ///< a sentence each

  /// `rest` plus the torques of the payload at a posture. @param q (n_q)
  Eigen::VectorXd calc_rest(const world::Model& model, VectorRef q) const;
  /// Noise of a torque minus the mean of rows at rest, after a touch: `within` plus h² T² of Hysteresis. Both terms have few degrees of
  /// freedom; those of the sum follow Welch & Satterthwaite (1947). @param touch  T, largest torque of each joint in the touch (n_a) [N·m;
  /// N]; 0: none  @param seconds  time since the touch, ≥ 0
  /// @param rest_rows  number of rows averaged to the rest, ≥ 1
  TorqueNoise calc_noise(VectorRef touch, double seconds, int rest_rows) const;
};

/// Estimates offset, noise, drift and payload from rows at rest. The covariance is that of the rows about the mean of their record. Its
/// correlations are shrunk towards 0 by the share that their own errors explain (Schäfer & Strimmer 2005), and it is enlarged by ν/(ν − 2),
/// the variance of Student's distribution with ν = rows − records. Rows less than `settle` after a touch are not rest either; they
/// determine the Hysteresis. A payload with the four parameters m, m c is fitted to the offsets in three or more postures. It is reported
/// if m is more than three deviations from 0.
/// @throws core::InvalidInput: sizes, not finite, no record with two rows, a torque that is the same in all rows, rows of which many are touched, touched rows without
/// times
/// Tests: tests/sensing/calibrate_test.cpp
Calibration calibrate(const world::Model& model, const RestRows& rows, const CalibrationOptions& options = {});

/// Motor torques that hold the robots against gravity at q (n_a) [N·m; N].
Eigen::VectorXd calc_holding_torques(const world::Model& model, VectorRef q);

/// Sign of total torques at rest relative to the torques that hold the robot.
struct SignCheck {
  int sign = 0;       ///< 1: torques of the motors on the links; −1: the opposite; 0: these are not the total torques of this model
  double factor = 0;  ///< least-squares factor of the holding torques in the measured torques
  std::string message;
};
/// @param q, tau  rows at rest (n_a × rows), with total instead of external torques
SignCheck check_sign(const world::Model& model, const Eigen::MatrixXd& q, const Eigen::MatrixXd& tau);

}  // namespace stiction::sensing
