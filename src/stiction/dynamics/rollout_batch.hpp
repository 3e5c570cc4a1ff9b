#pragma once

#include <vector>

#include "stiction/dynamics/step_batch.hpp"

namespace stiction::dynamics {

/// N trajectories of T steps each, one a column.
struct RolloutBatchInput {
  MatrixRef q_start;  ///< (n_q × N)
  MatrixRef u;        ///< commands, one after the other (n_a·T × N)
};

struct RolloutBatchResult {
  std::vector<core::Status> status;  ///< (N): Solved, or that of the first step that is not
  std::vector<int> steps;            ///< (N) that were solved; a trajectory stays where a step failed
  Eigen::MatrixXd q;                 ///< configurations from the start on, one after the other (n_q·(T + 1) × N)
  int failed = 0;                    ///< trajectories that are not Solved
};

/// What a function of the trajectories has for derivatives.
struct RolloutGradient {
  Eigen::MatrixXd q_start;  ///< (n_q × N)
  Eigen::MatrixXd u;        ///< (n_a·T × N)
};

/// q_{t+1} = f(q_t, u_t) for every column, each step solved cold: the same bits for any number of threads, and for any batch that a column is in.
///
/// @param options  of the steps; derivatives and warm_start are not used
/// @returns Solved, or the status of the first trajectory that is not
/// @throws  core::InvalidInput: as step_batch(), and u of a length that is no multiple of n_a
/// Tests: tests/dynamics/rollout_batch_test.cpp
core::Status rollout_batch(const world::Model& model, const RolloutBatchInput& in, const StepOptions& options, StepBatchWorkspace& work,
                           RolloutBatchResult& out);

/// Derivatives of a scalar L of the trajectories by their starts and commands, from ∂L/∂q_t, by the adjoint of the steps:
///
///     w_T = G_Tᵀ ∂L/∂q_T ,    ∂L/∂u_t = B_tᵀ w_{t+1} ,    w_t = A_tᵀ w_{t+1} + G_tᵀ ∂L/∂q_t                                      (S.25)
///
/// G_t is the derivative of q_t ⊕ δ by δ. Configurations have more numbers than tangents: the derivative by a quaternion is the one along the sphere of unit
/// quaternions, G (GᵀG)⁻¹ w. A_t and B_t are computed anew from q_t and u_t and kept for no other step, so that memory does not grow with T·n_v².
/// A step that failed passes w on as it is.
///
/// @param rolled   what rollout_batch() gave for `in`
/// @param D_L_q    ∂L/∂q_t (n_q·(T + 1) × N)
/// @param options  of the steps whose derivatives are taken. They may be smoother than those of the rollout, whose exact derivative is 0 where nothing touches
/// @throws core::InvalidInput: sizes
/// Tests: tests/dynamics/rollout_batch_test.cpp
void pull_back_rollout(const world::Model& model, const RolloutBatchInput& in, const RolloutBatchResult& rolled, MatrixRef D_L_q,
                       const StepOptions& options, StepBatchWorkspace& work, RolloutGradient& out);

}  // namespace stiction::dynamics
