#pragma once

#include <Eigen/Core>
#include <span>

#include "stiction/sensing/sensor.hpp"

namespace stiction::sensing {

/// Algorithm 4: steepest descent on the surface, with the settings of the thesis's research code.
struct SteepestDescent {
  int max_steps = 50;
  double tol_gradient = 1e-5;  ///< on ‖t‖ size/‖τ‖² [-], t the tangential gradient and size that of the link
  double armijo = 0.4;         ///< share of the decrease that the gradient promises
  double backtrack = 0.5;      ///< factor on the step length
  int max_backtracks = 10;
  double max_step = 0.1;  ///< as a share of the link's size
};

/// Levenberg–Marquardt in the tangential step and the force coordinates on the active face of the cone.
struct GaussNewton {
  int max_steps = 20;
  double tol_step = 1e-6;  ///< as a share of the link's size
  double damping = 1e-6;   ///< initial λ of (Y.4)
  double max_step = 0.2;   ///< as a share of the link's size
};

/// A point on the surface of a link with its residual.
struct ContactPoint {
  int link = -1;  ///< index into Sensor::links()
  int triangle = -1;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_L = Eigen::Vector3d::Zero();  ///< outward
  Eigen::Vector3d f_L = Eigen::Vector3d::Zero();  ///< best force on the robot [N]
  double residual = 0;                            ///< l (4.5) [(N·m)²]
};

/// @throws core::InvalidInput naming `field`: a link or a triangle that the sensor does not have, a point that is not finite
void require_point(const Sensor& sensor, const char* field, const ContactPoint& point);

/// Inputs of a descent, held by reference.
struct DescentProblem {
  const SensedLink& link;
  int index;  ///< index of the link
  const LinkTorque& torque;
  const FrictionCone& cone;
  Normals normals;
  double tolerance;                      ///< [-] a point with √l ≤ tolerance ‖τ‖ has converged
  double settle = 0;                     ///< Gauss–Newton ends if a step lowers l by no more than this [(N·m)²]
  std::span<const ContactPoint> ends{};  ///< Gauss–Newton gives up within `near` of one of these ends whose l is not larger
  double near = 0;                       ///< [m]
};

/// Computes force and residual at a point of a triangle.
ContactPoint evaluate(const DescentProblem& problem, int triangle, const Eigen::Vector3d& p_L);

/// The nearest point of the surface, with force and residual.
ContactPoint retract(const DescentProblem& problem, const Eigen::Vector3d& p_L, int guess);

/// Descends from `point` and moves it to the end of the descent. @returns whether the descent converged, with a lower l than at the start
bool descend(const DescentProblem& problem, const SteepestDescent& options, ContactPoint& point);
bool descend(const DescentProblem& problem, const GaussNewton& options, ContactPoint& point);

}  // namespace stiction::sensing
