#pragma once

#include "stiction/trajopt/box_lq.hpp"
#include "stiction/trajopt/optimize.hpp"

// Internal to the layer: local models along the trajectory as the stages of the program (T.3). docs/theory/trajopt.md.

namespace stiction::trajopt {

/// Scratch of one thread.
struct StageModelWorkspace {
  explicit StageModelWorkspace(const std::shared_ptr<const world::Model>& model) : models(model, 1), steps(model) {}
  dynamics::LocalModelWorkspace models;
  dynamics::LocalModel local;
  dynamics::StepWorkspace steps;  // for smoothed steps with derivatives of their forces
  dynamics::StepResult smooth;
};

/// One step of the nominal trajectory, computed with the exact dynamics.
struct NominalStep {
  VectorRef q, u, q_next;
};

/// Smoothing scheme of iteration i, with the κ or Σ of that iteration. The samples of each time t of the horizon T have their own seed.
dynamics::LocalModelScheme scheme_of(const OptimizeOptions& options, int i, std::size_t t, std::size_t T);

/// κ [1/J], or the largest standard deviation of u; 0 for Exact.
double sharpness(const dynamics::LocalModelScheme& scheme);

/// Computes A and B of the stage, transported to the exact states, and its rows (T.7). Without a force trust region there are no rows.
/// @returns status of the local model; if not Solved, the stage is filled as if there were no contact
core::Status calc_stage_model(const world::Model& model, const NominalStep& nominal, const dynamics::LocalModelScheme& scheme,
                              const OptimizeOptions& options, StageModelWorkspace& work, LqStage& stage);

}  // namespace stiction::trajopt
