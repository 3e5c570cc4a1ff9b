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
  /// Distance that all pairs keep at every checked posture, after the path leaves the first contacts and before it reaches the last [m].
  /// Between two checked postures half of it is guaranteed. Links that nearly touch at rest keep less (clearance.hpp).
  double clearance = 2e-3;
  double step = 0.3;         ///< largest joint motion of one tree extension [rad, L of the robots]
  int max_extensions = 150;  ///< extensions of each tree towards random postures
  int shortcuts = 12;        ///< attempts to shorten the path
};

/// Finds a collision-free path of the branches in `moving` from the robot posture in q to q_a_goal. The path leaves contact (retreat),
/// crosses free space (bidirectional RRT, Kuffner & LaValle 2000, with shortcuts) and returns to contact. The objects stay at their poses
/// in q.
/// @param path  postures after the start; the last one is q_a_goal (n_a each)
/// Tests: tests/contact/free_path_test.cpp
PathOutcome find_path(const world::Model& model, const world::RobotChains& chains, world::ChainMask moving, const Eigen::VectorXd& q,
                      const Eigen::VectorXd& q_a_goal, const PathOptions& options, core::Random& random, GeometryWorkspace& work,
                      std::vector<Eigen::VectorXd>& path);

/// Moves the branches in `moving` by small steps of least joint motion until every pair that they move is at least `clearance` [m] apart.
/// @param q  configuration (n_q), changed in place
/// @param path  each posture (full q_a) is appended
/// @returns true if all pairs reached the clearance within the joint limits
bool retreat(const world::Model& model, const world::RobotChains& chains, world::ChainMask moving, double clearance, Eigen::VectorXd& q,
             GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path);

}  // namespace stiction::contact
