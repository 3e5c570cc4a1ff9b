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
  double near_std = 0.4;           ///< spread of such draws [rad, L of the robots]
  int tries = 20;                  ///< draws per branch
};

/// How often each pair of the model was drawn to be brought into contact, and how often a posture came of it.
struct TouchCounts {
  std::vector<int> drawn, touched;  ///< per pair; empty: never

  bool empty() const { return drawn.empty(); }
  void add(int pair, bool found, std::size_t n_pairs);
  TouchCounts& operator+=(const TouchCounts& o);
};

/// What a sampler learns from: pairs of which hardly a draw in twenty ever touches are drawn as much less often. Equal counts give equal draws.
struct TouchHistory {
  const TouchCounts& known;
  TouchCounts fresh{};  ///< of the draws since
};

/// A robot posture that touches the object, and the branches for which one was found; the others are where they were.
struct ContactSample {
  Eigen::VectorXd q_a;  ///< (n_a)
  world::ChainMask moved = 0;
};

/// Which branches a change of contacts moves. They are drawn before the posture, because they let go of the
/// object first and it may come to rest elsewhere. @returns 0: no branch of the robots can touch an object
world::ChainMask draw_grasp(const world::RobotChains& chains, const GenericSampler& sampler, core::Random& random);

/// Draws a posture in contact with the objects at q (3.4.3): no moved branch penetrates anything by more than 0.001 L, and each
/// touched an object within half of that when it was placed. Pure kinematics: nothing moves the object.
/// @param draw  branches that move  @param q  configuration (n_q); branches that are not moved keep their joints
/// @param history  of draws at like places of the objects; null: every pair of a branch is drawn alike
/// @returns nullopt when the draws of the sampler were used up
/// Tests: tests/contact/free_path_test.cpp
std::optional<ContactSample> sample_contact(const world::Model& model, const world::RobotChains& chains, const GenericSampler& sampler,
                                            world::ChainMask draw, Eigen::VectorXd q, core::Random& random, GeometryWorkspace& work,
                                            TouchHistory* history = nullptr);

}  // namespace stiction::contact
