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

/// Gx x_t + Gu u_t + g; `out` is left as it is if the stage has no rows.
inline void row_value(const BoxLqProblem& problem, const BoxLqWorkspace& work, std::size_t t, Eigen::VectorXd& out) {
  const LqStage& d = problem.stages[t];
  if (d.g.size() == 0) return;
  out = d.g;
  out.noalias() += d.Gx * state(problem, work, t);
  out.noalias() += d.Gu * work.stages[t].u;
}

// ---- the step

/// Computes the cost to go in (x_t, u_{t−1}) and the gains by a Riccati recursion. The Hessian is that of (T.3), plus z/s of the bounds and
/// Gᵀ diag(y/s) G of the rows.
/// @returns false if a Hessian is not positive definite
bool factorise(const BoxLqProblem& problem, BoxLqWorkspace& work);

/// Computes du, dx_next and ds_row of the Newton step towards the target products, with the current factorisation.
void calc_newton_step(const BoxLqProblem& problem, BoxLqWorkspace& work);

}  // namespace stiction::trajopt
