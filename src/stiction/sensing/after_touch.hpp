#pragma once

#include <Eigen/Core>
#include <vector>

namespace stiction::sensing {

/// Offset left by a touch: for a while each torque at rest is off by a share of its torque in the touch, because joints stick elsewhere and
/// the arm rings.
struct Hysteresis {
  double share = 0;    ///< h: the standard deviation right after a touch is h times the largest torque of the joint in it
  double freedom = 0;  ///< degrees of freedom of h²; 0: no touch was observed
  double settle = 1;   ///< time after the last row of a touch until torques are those of rest again [s]
};

/// The rows of one record, sorted by their time after touches, and the largest torques of the touches.
struct AfterTouch {
  std::vector<int> settled, unsettled;  ///< rows at rest: before any touch or `settle` after it; sooner after a touch
  std::vector<int> touch;               ///< for each unsettled row the number of the touch before it, from 0
  Eigen::MatrixXd sizes;  ///< largest |τ − rest| of each joint in each touch (n × touches), rest: the mean of the settled rows
};

/// Sorts the rows of a record. @param tau (n × rows)  @param times  of all rows [s]  @param at_rest, touched  rows of one record
/// @returns sizes are 0 if no row is settled
AfterTouch find_after_touch(const Eigen::MatrixXd& tau, const std::vector<double>& times, const std::vector<int>& at_rest,
                            const std::vector<int>& touched, double settle);

/// Estimates h from the offsets d of the unsettled rows of all records, corrected for noise: h² = (Σ (d² − σ²))₊/Σ T², where d² is the mean
/// over the rows after a touch and T the largest torques in the touch.
/// @param variance  σ², the noise variance of one row (n)
Hysteresis fit_hysteresis(const Eigen::MatrixXd& tau, const std::vector<AfterTouch>& records, const Eigen::VectorXd& variance,
                          double settle);

}  // namespace stiction::sensing
