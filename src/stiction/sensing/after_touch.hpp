#pragma once

#include <Eigen/Core>
#include <vector>

namespace stiction::sensing {

/// What a touch leaves behind: for a while the torques of rest are off by a share of what each joint bore in the touch, since joints stick elsewhere and the arm rings.
struct Hysteresis {
  double share = 0;    ///< h: the standard deviation right after a touch is h times the largest torque of the joint in it
  double freedom = 0;  ///< independent numbers by which h² is known; 0: no touch is known
  double settle = 1;   ///< time after the last row of a touch from which on torques are those of rest again [s]
};

/// Rows of one record after its touches, and the largest torques of these.
struct AfterTouch {
  std::vector<int> settled, unsettled;  ///< rows at rest: before any touch or `settle` after it, and those in between
  std::vector<int> touch;               ///< of each unsettled row: number of the touch before it, from 0
  Eigen::MatrixXd sizes;  ///< largest |τ − rest| of each joint in each touch (n × touches), rest: the mean of the settled rows
};

/// @param tau (n × rows)  @param times  of all rows [s]  @param at_rest, touched  rows of one record  @returns sizes 0 where no row is settled
AfterTouch find_after_touch(const Eigen::MatrixXd& tau, const std::vector<double>& times, const std::vector<int>& at_rest,
                            const std::vector<int>& touched, double settle);

/// h from what the unsettled rows of all records are off by, less what noise makes of it: h² = (Σ (d² − σ²))₊/Σ T², d² the mean over the rows after a touch, T the torques in it.
/// @param variance  σ² of one row (n)
Hysteresis fit_hysteresis(const Eigen::MatrixXd& tau, const std::vector<AfterTouch>& records, const Eigen::VectorXd& variance,
                          double settle);

}  // namespace stiction::sensing
