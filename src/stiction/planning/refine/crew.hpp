#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "stiction/core/parallel.hpp"
#include "stiction/planning/contact_sampler.hpp"
#include "stiction/trajopt/optimize.hpp"

namespace stiction::planning::refinement {

/// Scratch of a thread.
struct Scratch {
  explicit Scratch(const std::shared_ptr<const world::Model>& model)
      : steps(model), half_steps(model), smooth_steps(model), geometry(*model) {}

  dynamics::StepWorkspace steps, half_steps, smooth_steps;
  dynamics::StepResult result, half_result, smooth_result;
  dynamics::RolloutResult rollout;
  GeometryWorkspace geometry;
  std::optional<trajopt::OptimizeWorkspace> optimizer;  ///< made when first needed
  trajopt::OptimizeResult optimized;
};

/// Trials and, within them, ways through a push or a regrasp are tried side by side.
struct Crew {
  Crew(const std::shared_ptr<const world::Model>& model, int threads) : pool(threads) {
    for (int i = 0; i < pool.size(); ++i) scratch.emplace_back(model);
  }
  Scratch& of(int worker) { return scratch[static_cast<std::size_t>(worker)]; }

  core::ThreadPool pool;
  std::deque<Scratch> scratch;  ///< one per thread
};

using Turn = core::ThreadPool::Turn;

/// Asked to stop, or nothing depends on what is tried any more.
inline bool stops(const core::RunControl& control, const Turn* turn) { return control.stop() || (turn != nullptr && turn->over()); }

}  // namespace stiction::planning::refinement
