#pragma once

#include <algorithm>
#include <vector>

#include "stiction/sensing/descent.hpp"

namespace stiction::bench {

/// What Algorithm 4 computes on its way, so that each part can be timed by itself.
struct DescentTrace {
  struct Query {
    Eigen::Vector3d p_L;
    int triangle;  ///< guess
  };
  std::vector<sensing::ContactPoint> residuals;  ///< points and normals at which (4.5) was solved
  std::vector<Query> retractions;                ///< points off the surface
  std::vector<sensing::ContactPoint> gradients;  ///< points and forces of (4.12)
};

/// Algorithm 4, as sensing::descend has it. @param evaluate  a point with force and residual from one with its place and normal
/// @param trace  nullptr: of no interest
template <class Evaluate>
void descend(Evaluate&& evaluate, const sensing::SensedLink& link, const sensing::LinkTorque& torque, sensing::Normals normals,
             double tolerance, sensing::ContactPoint point, DescentTrace* trace) {
  const sensing::SteepestDescent options;
  const double size = link.surface.size, enough = tolerance * tolerance * torque.tau_tau;
  const auto solve = [&](const sensing::ContactPoint& at) {
    if (trace != nullptr) trace->residuals.push_back(at);
    return evaluate(at);
  };
  for (int step = 0; step < options.max_steps && point.residual > enough; ++step) {
    if (trace != nullptr) trace->gradients.push_back(point);
    const Eigen::Vector3d gradient = 0.5 * sensing::calc_gradient(torque, point.p_L, point.f_L);
    const Eigen::Vector3d t = gradient - point.n_L.dot(gradient) * point.n_L;
    const double length = t.norm();
    if (length <= options.tol_gradient * torque.tau_tau / size) return;
    double a = std::min(options.max_step * size / length, 1.0);
    sensing::ContactPoint trial = point;
    for (int tries = 0;; a *= options.backtrack) {
      trial.p_L = point.p_L - a * t;
      if (0.5 * solve(trial).residual < 0.5 * point.residual - options.armijo * a * length * length) break;
      if (++tries > options.max_backtracks) return;
    }
    if (trace != nullptr) trace->retractions.push_back({trial.p_L, point.triangle});
    const auto closest = link.surface.tree.closest(trial.p_L, point.triangle);
    if ((closest.point - trial.p_L).norm() > options.max_step * size) return;
    point.triangle = closest.triangle;
    point.p_L = closest.point;
    point.n_L = link.surface.normal(closest.triangle, closest.point, normals);
    point = solve(point);
  }
}

}  // namespace stiction::bench
