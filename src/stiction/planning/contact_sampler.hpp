#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "stiction/contact/contact.hpp"
#include "stiction/core/random.hpp"
#include "stiction/core/run_control.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/planning/robot_chains.hpp"
#include "stiction/world/moving_links.hpp"

namespace stiction::planning {

/// Kinematics and distances of one thread, without dynamics.
struct GeometryWorkspace {
  explicit GeometryWorkspace(const world::Model& model) : kinematics_work(model), contact_work(model) {}

  world::KinematicsWorkspace kinematics_work;
  world::Kinematics kinematics;
  world::MovingLinks links;  // of a search over a few joints
  contact::Workspace contact_work;
  std::vector<contact::Contact> contacts;
  std::vector<int> pairs;
  const core::RunControl* control = nullptr;  // of the search: long work looks at it, and comes to nothing once it is to stop
  bool stop() const { return control != nullptr && control->stop(); }
};

/// A robot posture that touches the object, and the branches for which one was found; the others are where they were.
struct ContactSample {
  Eigen::VectorXd q_a;  ///< (n_a)
  ChainMask moved = 0;
};

/// Which branches a regrasp moves. They are drawn before the posture, because they let go of the
/// object first and it may come to rest elsewhere.
struct GraspDraw {
  ChainMask moved = 0;  ///< 0: no branch of the robots can touch an object
};
GraspDraw draw_grasp(const RobotChains& chains, const GenericSampler& sampler, core::Random& random);

/// Draws a posture in contact with the objects at q (3.4.3): no moved branch penetrates anything by more than 0.001 L, and each
/// touched an object within half of that when it was placed. Pure kinematics: nothing moves the object.
/// @param q  configuration (n_q); branches that are not moved keep their joints
/// @returns nullopt when the draws of the sampler were used up
std::optional<ContactSample> sample_contact(const world::Model& model, const RobotChains& chains, const GenericSampler& sampler,
                                            const GraspDraw& draw, Eigen::VectorXd q, core::Random& random, GeometryWorkspace& work);

/// dφ/dqᵃ of one contact in the given joints, 0 elsewhere (n_a). The kinematics in `work` are those of the contact.
Eigen::VectorXd gap_gradient(const world::Model& model, const contact::Contact& contact, std::span<const int> joints,
                             GeometryWorkspace& work);

/// Moves the joints of the branches in `moving` until every pair they move is at least `clearance` apart, by the shortest small
/// steps; true when that succeeded within joint limits. Appends each posture to `path` (full q_a).
bool retreat(const world::Model& model, const RobotChains& chains, ChainMask moving, double clearance, Eigen::VectorXd& q,
             GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path);

/// The same from objects of which each of `places` is one where they may be.
/// @param places  configurations, of which those of the objects count (n_q each), at least one
/// @param q_a     posture of the robot, changed in place (n_a)
/// @param rounds  at most, of 0.04 rad or m each
bool retreat(const world::Model& model, const RobotChains& chains, ChainMask moving, double clearance,
             std::span<const Eigen::VectorXd> places, Eigen::VectorXd& q_a, GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path,
             int rounds = 30);

}  // namespace stiction::planning
