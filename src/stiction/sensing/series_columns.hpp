#pragma once

#include <string>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::sensing {

/// Column numbers of the time, and of the position and torque of every measured joint.
struct SeriesColumns {
  std::size_t time = 0;
  double seconds = 1;                ///< per unit of that column
  std::vector<int> joints;           ///< measured joints, in the order of u
  std::vector<std::size_t> q, tau;   ///< columns of these joints
  std::vector<std::string> notes{};  ///< a sentence each on columns that are not read, and on columns whose meaning the user must know
};

/// Columns of a table without names: time, joint positions, torques, in the order of u. @param unmeasured  joints without columns
SeriesColumns make_ordered_columns(int n_a, const std::vector<int>& unmeasured = {});

/// Finds the columns of a table by their names, in any order. With NAME the name of a joint, as in its file or as robot/joint, the position
/// is in a column q_NAME, position_NAME or NAME/position and the like, after any path (/joint_states/NAME/position); the external torque is
/// in tau_NAME, tau_ext_NAME, NAME/effort and the like. q and tau may also be numbered in the order of u, from 0 or from 1, also by the
/// names of libfranka (tau_ext_hat_filtered) and of RTDE (actual_q). The time may be in ms, us or ns, if its name says so (time_ms, t [ns]); a
/// column `duration` of libfranka is in ms. Every other column is left out.
/// @param unmeasured  joints without columns  @param where  prefix of error messages, as in "FILE:LINE: series"
/// @throws core::InvalidInput: there is no column, or there are several, for the time or for a joint
/// Tests: tests/sensing/series_test.cpp
SeriesColumns find_columns(const std::vector<std::string>& names, const world::Model& model, const std::string& where,
                           const std::vector<int>& unmeasured = {});

/// Position of each measured joint of a model in a list of names, which are joint or robot/joint.
/// @throws core::InvalidInput: a joint is not in the list, or more than once
std::vector<std::size_t> find_joints(const std::vector<std::string>& names, const world::Model& model, const std::string& where,
                                     const std::vector<int>& unmeasured = {});

/// All joints of u except the unmeasured ones.
std::vector<int> joints_but(int n_a, const std::vector<int>& unmeasured);

}  // namespace stiction::sensing
