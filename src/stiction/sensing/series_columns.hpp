#pragma once

#include <string>
#include <vector>

#include "stiction/world/model.hpp"

namespace stiction::sensing {

/// Where a table has the time, and the position and the torque of every joint.
struct SeriesColumns {
  std::size_t time = 0;
  std::vector<std::size_t> q, tau;   ///< (n_a) in the order of u
  std::vector<std::string> notes{};  ///< a sentence each: columns that are not read, and columns whose meaning the user has to know
};

/// The columns of a table without names: a time, the joint positions, the torques, in the order of u.
SeriesColumns make_ordered_columns(int n_a);

/// The columns of a table by their names, in any order. With NAME the name of a joint, as in its file or as robot/joint, the position is in a column
/// q_NAME, position_NAME or NAME/position and the like, after any path (/joint_states/NAME/position); the external torque is in tau_NAME, tau_ext_NAME,
/// NAME/effort and the like. q and tau may also be numbered in the order of u, from 0 or from 1. Every other column is left out.
/// @param where  stands before the message, as in "FILE:LINE: series"
/// @throws core::InvalidInput: there is no column, or there are several, for the time or for a joint
/// Tests: tests/sensing/series_test.cpp
SeriesColumns find_columns(const std::vector<std::string>& names, const world::Model& model, const std::string& where);

/// Where each joint of a model stands in a list of joints, as joint or robot/joint (n_a).
/// @throws core::InvalidInput: a joint is not in the list, or more than once
std::vector<std::size_t> find_joints(const std::vector<std::string>& names, const world::Model& model, const std::string& where);

}  // namespace stiction::sensing
