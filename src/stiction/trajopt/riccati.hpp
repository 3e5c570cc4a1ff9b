#pragma once

#include "stiction/trajopt/box_lq.hpp"

// Internal to the layer: the Newton step of the interior point as a linear-quadratic program without bounds. docs/theory/trajopt.md (T.4).

namespace stiction::trajopt {

// ---- the iterate

/// x_t.
inline const Eigen::VectorXd& state(const BoxLqProblem& problem, const BoxLqWorkspace& work, std::size_t t) {
  return t == 0 ? problem.x0 : work.stages[t - 1].x_next;
}

/// r_t + u_t − u_{t−1}.
inline void change(const BoxLqProblem& problem, const BoxLqWorkspace& work, std::size_t t, Eigen::VectorXd& out) {
  out = problem.stages[t].r + work.stages[t].u;
  if (t > 0) out -= work.stages[t - 1].u;
}

/// Gx x_t + Gu u_t + g; untouched where there are no rows.
inline void row_value(const BoxLqProblem& problem, const BoxLqWorkspace& work, std::size_t t, Eigen::VectorXd& out) {
  const LqStage& d = problem.stages[t];
  if (d.g.size() == 0) return;
  out = d.g;
  out.noalias() += d.Gx * state(problem, work, t);
  out.noalias() += d.Gu * work.stages[t].u;
}

// ---- the step

/// Riccati recursion for the Hessian of (T.3) plus z/s on the boxes and Gᵀ diag(y/s) G of the rows: cost to go in (x_t, u_{t−1}), gains.
/// @returns false: a Hessian that is not positive definite
bool factorise(const BoxLqProblem& problem, BoxLqWorkspace& work);

/// du, dx_next and ds_row of the Newton step to the centres, with the factors at hand.
void calc_newton_step(const BoxLqProblem& problem, BoxLqWorkspace& work);

}  // namespace stiction::trajopt
