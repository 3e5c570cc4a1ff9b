#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/contact/geometry_workspace.hpp"
#include "stiction/core/random.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::contact {

/// How a search for a path ended.
enum class PathOutcome {
  Found,
  StartBlocked,
  GoalBlocked,
  NotFound
};

struct PathOptions {
  /// Kept to everything, but for pairs of links that nearly touch at rest (clearance.hpp), at every posture that is looked at between leaving the first contacts and reaching the last, and half of it between
  /// those [m].
  double clearance = 2e-3;
  double step = 0.3;         ///< length of a tree extension, largest joint [rad, L of the robots]
  int max_extensions = 150;  ///< of either tree towards random postures
  int shortcuts = 12;        ///< attempts
};

/// Collision-free path of the branches in `moving` from the robot posture in q to q_a_goal: out of contact (retreat), through free
/// space (bidirectional RRT, Kuffner & LaValle 2000, with shortcuts) and back into contact. The objects stay where q has them.
/// @param path  postures after the start, the last one is q_a_goal (n_a each)
/// Tests: tests/contact/free_path_test.cpp
PathOutcome find_path(const world::Model& model, const world::RobotChains& chains, world::ChainMask moving, const Eigen::VectorXd& q,
                      const Eigen::VectorXd& q_a_goal, const PathOptions& options, core::Random& random, GeometryWorkspace& work,
                      std::vector<Eigen::VectorXd>& path);

/// Moves the joints of the branches in `moving` until every pair they move is at least `clearance` apart, by the shortest small
/// steps; true when that succeeded within joint limits. Appends each posture to `path` (full q_a).
/// @param q  changed in place (n_q)
bool retreat(const world::Model& model, const world::RobotChains& chains, world::ChainMask moving, double clearance, Eigen::VectorXd& q,
             GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path);

}  // namespace stiction::contact
