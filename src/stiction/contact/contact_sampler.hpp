#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "stiction/contact/geometry_workspace.hpp"
#include "stiction/core/random.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::contact {

/// Contact sampler for any robot: it draws branches and brings them to the object one by one.
struct GenericSampler {
  double whole_probability = 0.5;  ///< probability that all branches move; otherwise one or two of them
  double near_probability = 0.3;   ///< probability that a branch is drawn near its present posture
  double pinch_probability = 0.5;  ///< probability that a hand carried by an arm pinches the object between two of its parts
  int pinch_tries = 3;             ///< attempts at a pinch before the branches are drawn one by one
  double near_std = 0.4;           ///< standard deviation of draws near the present posture [rad, L of the robots]
  int tries = 20;                  ///< draws per branch
  std::vector<char> touch{};  ///< per pair of the model: 1 if it may be brought into contact; empty: every pair of a branch and an object
};

/// A robot posture that touches the object.
struct ContactSample {
  Eigen::VectorXd q_a;  ///< robot posture (n_a)
  Eigen::VectorXd u;    ///< command at this posture (n_a): q_a, plus the squeeze that holds a free object between jaws against its weight
  world::ChainMask moved = 0;  ///< branches for which a contact was found; the other branches did not move
};

/// Draws the branches that a regrasp moves. They are drawn before the posture because these branches first release the object, which may
/// then come to rest elsewhere.
/// @returns 0 if no branch of the robots can touch an object
world::ChainMask draw_grasp(const world::RobotChains& chains, const GenericSampler& sampler, core::Random& random);

/// Draws a posture in contact with the objects at q (3.4.3). No moved branch penetrates anything by more than 0.001 L, and each moved
/// branch was within half of that of an object when it was placed. This is pure kinematics: the objects do not move.
/// @param draw  branches that move  @param q  configuration (n_q); branches that are not moved keep their joints
/// @returns nullopt if the sampler used up its draws
/// Tests: tests/contact/free_path_test.cpp
std::optional<ContactSample> sample_contact(const world::Model& model, const world::RobotChains& chains, const GenericSampler& sampler,
                                            world::ChainMask draw, Eigen::VectorXd q, core::Random& random, GeometryWorkspace& work);

}  // namespace stiction::contact
