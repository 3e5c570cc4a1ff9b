#pragma once

#include "stiction/sensing/contact_rows.hpp"
#include "stiction/sensing/descent.hpp"
#include "stiction/sensing/joint_forces.hpp"

namespace stiction::sensing {

/// Contacts that make torques together.
struct ContactSet {
  int count = 0;
  std::array<ContactPoint, kMostContacts> contacts;  ///< by link, then by point; their `residual` is that of the set
  double residual = 0;                               ///< l of the set (Y.9), without the prior [(N·m)²]
  double objective = 0;                              ///< with it: what counts as explained
  /// Dimension of the points and forces near these with the same torques: 5 count − rank of their map (Y.11). 0: this set is isolated.
  int freedom = 0;
  /// Standard deviation of each point along the surface, from noise and, where torques say nothing of it, the size of its link [m] (Y.12).
  std::array<double, kMostContacts> deviation{};
  std::array<bool, kMostContacts> point_is_unique{};  ///< no motion of the free ones moves this point
};

/// What a joint descent needs to know; refers to its parts.
struct JointProblem {
  const Sensor& sensor;
  const ContactRows& rows;
  const FrictionCone& cone;
  double prior;  ///< ρ = σ²/F² [m²]
  double noise;  ///< σ [N·m]
};

/// Scratch of the functions below; one per thread.
struct JointWorkspace {
  ForceProblem forces;
  ForceWorkspace active_set;
  ForceSolution solution;
  Eigen::MatrixXd D, N;
  Eigen::VectorXd left, gradient;
};

/// Forces, residual and objective of a set at its points.
void evaluate(const JointProblem& problem, JointWorkspace& work, ContactSet& set);

struct JointDescent {
  int max_steps = 30;
  double tol_step = 1e-6;  ///< of a link's size
  double tol_gain = 1e-3;  ///< of the objective, where it is already within `enough`
  double damping = 1e-6;   ///< first factor of the diagonal
  double max_step = 0.2;   ///< of a link's size
};

/// Levenberg–Marquardt on the tangential steps of all points and the coordinates of their forces on the rays that carry (Y.10).
/// @param enough  objective below which further descent need not go on [(N·m)²]
void descend(const JointProblem& problem, const JointDescent& options, double enough, JointWorkspace& work, ContactSet& set);

/// Fills freedom, deviation and point_is_unique: the map from points and forces to torques at a set, all components of the forces.
void calc_identifiability(const JointProblem& problem, JointWorkspace& work, ContactSet& set);

}  // namespace stiction::sensing
