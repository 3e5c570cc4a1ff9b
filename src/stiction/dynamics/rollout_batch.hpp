#pragma once

#include <vector>

#include "stiction/dynamics/step_batch.hpp"

namespace stiction::dynamics {

/// N trajectories of T steps each, one per column.
struct RolloutBatchInput {
  MatrixRef q_start;  ///< (n_q × N)
  MatrixRef u;        ///< commands of all steps, stacked (n_a·T × N)
};

struct RolloutBatchResult {
  std::vector<core::Status> status;  ///< (N) Solved, or the status of the first step that failed
  std::vector<int> steps;            ///< (N) solved steps; a trajectory stays where a step failed
  Eigen::MatrixXd q;                 ///< configurations from the start on, stacked (n_q·(T + 1) × N)
  int failed = 0;                    ///< trajectories that are not Solved
};

/// Derivatives of a scalar function of the trajectories by their starts and commands.
struct RolloutGradient {
  Eigen::MatrixXd q_start;  ///< (n_q × N)
  Eigen::MatrixXd u;        ///< (n_a·T × N)
};

/// Computes q_{t+1} = f(q_t, u_t) for every column. Each step is solved cold, so a column has the same bits for any number of threads and
/// in any batch.
///
/// @param options  options of the steps; the derivative flags and warm_start are ignored
/// @param control  checked before each step. Trajectories that it stopped are Cancelled or MaxIterations (deadline) and stay where they are
/// @returns Solved, or the status of the first trajectory that failed
/// @throws  core::InvalidInput: as step_batch(), and a length of u that is not a multiple of n_a
/// Tests: tests/dynamics/rollout_batch_test.cpp
core::Status rollout_batch(const world::Model& model, const RolloutBatchInput& in, const StepOptions& options, StepBatchWorkspace& work,
                           RolloutBatchResult& out, const core::RunControl& control = {});

/// Computes the derivatives of a scalar function L of the trajectories by their starts and commands, from ∂L/∂q_t, with the adjoint of the
/// steps:
///
///     w_T = G_Tᵀ ∂L/∂q_T ,    ∂L/∂u_t = B_tᵀ w_{t+1} ,    w_t = A_tᵀ w_{t+1} + G_tᵀ ∂L/∂q_t                                      (S.25)
///
/// G_t is the derivative of q_t ⊕ δ by δ. A configuration has more numbers than its tangent: the derivative by a quaternion is taken along
/// the sphere of unit quaternions, G (GᵀG)⁻¹ w. A_t and B_t are recomputed from q_t and u_t and not stored, so that memory does not grow
/// with T·n_v². A step that failed passes w on unchanged.
///
/// @param rolled   the result of rollout_batch() for `in`
/// @param D_L_q    ∂L/∂q_t (n_q·(T + 1) × N)
/// @param options  options of the steps to differentiate. They may be smoother than those of the rollout, whose exact derivative is 0 if
///                 nothing touches
/// @param control  checked before each step
/// @returns Solved; or Cancelled or MaxIterations (deadline), and then `out` is of no use
/// @throws core::InvalidInput: sizes
/// Tests: tests/dynamics/rollout_batch_test.cpp
core::Status pull_back_rollout(const world::Model& model, const RolloutBatchInput& in, const RolloutBatchResult& rolled, MatrixRef D_L_q,
                               const StepOptions& options, StepBatchWorkspace& work, RolloutGradient& out,
                               const core::RunControl& control = {});

}  // namespace stiction::dynamics
