#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/contact/geometry_workspace.hpp"

namespace stiction::contact {

/// Brings pairs into contact, or to the wanted gaps, by Newton steps with the smallest motion of the moving joints. Each gap ends within
/// half of 0.001 L of its wanted value.
/// @param moving  flag per robot joint (n_a)  @param wanted  gap of each pair [m]; empty: 0
/// @param q  configuration (n_q), changed in place
/// @param work  its kinematics must be those of q at the start. Only the bodies of the pairs are updated; the other bodies are out of date
///   afterwards
/// Tests: tests/contact/free_path_test.cpp
bool touch(const world::Model& model, std::span<const int> pairs, const std::vector<char>& moving, Eigen::VectorXd& q,
           GeometryWorkspace& work, std::span<const double> wanted = {});

/// A gap of this size counts as contact [contact tolerance of the robots].
inline constexpr double kTouch = 0.1;

}  // namespace stiction::contact
