#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "stiction/contact/geometry_workspace.hpp"
#include "stiction/core/random.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::contact {

/// Contact sampler that works for any robot: branches are drawn and brought to the object one by one.
struct GenericSampler {
  double whole_probability = 0.5;  ///< probability that all branches move; otherwise one or two of them
  double near_probability = 0.3;   ///< probability that a branch is drawn around its present posture
  double pinch_probability = 0.5;  ///< probability that a hand which an arm carries takes the object between two of its parts
  int pinch_tries = 3;             ///< draws of such a grasp, before the branches are drawn one by one
  double near_std = 0.4;           ///< spread of such draws [rad, L of the robots]
  int tries = 20;                  ///< draws per branch
  std::vector<char> touch{};  ///< 1 per pair that may be brought into contact (pairs of the model); empty: any of a branch with an object
};

/// A robot posture that touches the object, and the branches for which one was found; the others are where they were.
struct ContactSample {
  Eigen::VectorXd q_a;  ///< (n_a)
  Eigen::VectorXd u;    ///< commands there: q_a, and beyond it where jaws hold a free object, as far as its weight needs (n_a)
  world::ChainMask moved = 0;
};

/// Which branches a change of contacts moves. They are drawn before the posture, because they let go of the
/// object first and it may come to rest elsewhere. @returns 0: no branch of the robots can touch an object
world::ChainMask draw_grasp(const world::RobotChains& chains, const GenericSampler& sampler, core::Random& random);

/// Draws a posture in contact with the objects at q (3.4.3): no moved branch penetrates anything by more than 0.001 L, and each
/// touched an object within half of that when it was placed. Pure kinematics: nothing moves the object.
/// @param draw  branches that move  @param q  configuration (n_q); branches that are not moved keep their joints
/// @returns nullopt when the draws of the sampler were used up
/// Tests: tests/contact/free_path_test.cpp
std::optional<ContactSample> sample_contact(const world::Model& model, const world::RobotChains& chains, const GenericSampler& sampler,
                                            world::ChainMask draw, Eigen::VectorXd q, core::Random& random, GeometryWorkspace& work);

}  // namespace stiction::contact
