#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/contact/geometry_workspace.hpp"

namespace stiction::contact {

/// Brings pairs into contact, or to the gaps that are wanted, by Newton steps on their gaps, with the least motion of the moving joints; a gap ends within half of 0.001 L.
/// @param moving  per joint of the robots (n_a)  @param wanted  gap of each pair [m]; empty: 0
/// @param q  configuration (n_q), changed in place. Only what moves the pairs is computed: the rest of the kinematics in `work`, which are those of q at
///   first, is out of date after it
/// Tests: tests/contact/free_path_test.cpp
bool touch(const world::Model& model, std::span<const int> pairs, const std::vector<char>& moving, Eigen::VectorXd& q,
           GeometryWorkspace& work, std::span<const double> wanted = {});

/// A gap of this size counts as contact [contact tolerance of the robots].
inline constexpr double kTouch = 0.1;

}  // namespace stiction::contact
