#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "stiction/core/parallel.hpp"
#include "stiction/planning/expansion.hpp"
#include "stiction/trajopt/optimize.hpp"

namespace stiction::planning::refinement {

/// Scratch of a thread.
struct Scratch : SimulationScratch {
  using SimulationScratch::SimulationScratch;
  std::optional<trajopt::OptimizeWorkspace> optimizer;  ///< made when first needed
  trajopt::OptimizeResult optimized;
};

/// Trials and, within them, ways through a push or a regrasp are tried side by side.
struct Crew {
  Crew(const std::shared_ptr<const world::Model>& model, int threads, const core::RunControl& control) : pool(threads) {
    for (int i = 0; i < pool.size(); ++i) scratch.emplace_back(model, control);
  }
  Scratch& of(int worker) { return scratch[static_cast<std::size_t>(worker)]; }

  core::ThreadPool pool;
  std::deque<Scratch> scratch;  ///< one per thread
};

using Turn = core::ThreadPool::Turn;

/// Asked to stop, or nothing depends on what is tried any more.
inline bool stops(const core::RunControl& control, const Turn* turn) { return control.stop() || (turn != nullptr && turn->over()); }

}  // namespace stiction::planning::refinement
