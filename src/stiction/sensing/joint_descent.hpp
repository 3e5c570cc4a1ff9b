#pragma once

#include "stiction/sensing/contact_rows.hpp"
#include "stiction/sensing/descent.hpp"
#include "stiction/sensing/joint_forces.hpp"

namespace stiction::sensing {

/// A set of contacts that explain the torques together.
struct ContactSet {
  int count = 0;
  std::array<ContactPoint, kMostContacts> contacts;  ///< by link, then by point; their `residual` is that of the set
  double residual = 0;                               ///< l of the set (Y.9), without the prior [(N·m)²]
  double objective = 0;  ///< residual plus the prior (Y.9), compared with the bound of explained torques [(N·m)²]
  /// Dimension of the family of nearby points and forces with the same torques: 5 count − rank (Y.11). 0: this set is isolated.
  int freedom = 0;
  /// Standard deviation of each point along the surface [m] (Y.12); the size of its link if torques carry no information on the point.
  std::array<double, kMostContacts> deviation{};
  std::array<bool, kMostContacts> point_is_unique{};  ///< whether no motion of the family (Y.11) moves this point
};

/// Inputs of a joint descent, held by reference.
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

/// Computes forces, residual and objective of a set at its points.
void evaluate(const JointProblem& problem, JointWorkspace& work, ContactSet& set);

struct JointDescent {
  int max_steps = 30;
  double tol_step = 1e-6;  ///< as a share of the link's size
  double tol_gain = 1e-3;  ///< relative gain of the objective that ends the descent once the objective is below `enough`
  double damping = 1e-6;   ///< initial damping factor
  double max_step = 0.2;   ///< as a share of the link's size
};

/// Levenberg–Marquardt in the tangential steps of all points and the coordinates of their forces on the active rays (Y.10).
/// @param enough  objective that is good enough to stop early [(N·m)²]
void descend(const JointProblem& problem, const JointDescent& options, double enough, JointWorkspace& work, ContactSet& set);

/// Fills freedom, deviation and point_is_unique from the Jacobian of torques by points and all force components.
void calc_identifiability(const JointProblem& problem, JointWorkspace& work, ContactSet& set);

}  // namespace stiction::sensing
