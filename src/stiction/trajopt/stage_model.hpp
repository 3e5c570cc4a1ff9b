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
  dynamics::StepWorkspace steps;  // smoothed, with the derivatives of their forces
  dynamics::StepResult smooth;
};

/// A step of the nominal trajectory by the exact dynamics.
struct NominalStep {
  VectorRef q, u, q_next;
};

/// The scheme with its κ or Σ of iteration i; samples of every time t of the horizon T from their own seed.
dynamics::LocalModelScheme scheme_of(const OptimizeOptions& options, int i, std::size_t t, std::size_t T);

/// κ [1/J], or std of u (its largest); 0 for Exact.
double sharpness(const dynamics::LocalModelScheme& scheme);

/// A and B of the stage, carried to the exact states, and its rows (T.7), of which there are none without a force trust region.
/// @returns the status of the local model: not Solved, and the stage is as if nothing were touched
core::Status calc_stage_model(const world::Model& model, const NominalStep& nominal, const dynamics::LocalModelScheme& scheme,
                              const OptimizeOptions& options, StageModelWorkspace& work, LqStage& stage);

}  // namespace stiction::trajopt
