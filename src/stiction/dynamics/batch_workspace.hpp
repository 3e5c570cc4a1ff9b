#pragma once

#include <algorithm>
#include <vector>

#include "stiction/core/parallel.hpp"
#include "stiction/dynamics/step_batch.hpp"

// Internal to the layer: the workspaces of the threads of a batch.

namespace stiction::dynamics {

struct StepBatchWorkspace::Impl {
  Impl(const std::shared_ptr<const world::Model>& model, int threads) : pool(threads), results(static_cast<std::size_t>(threads)) {
    for (int i = 0; i < threads; ++i) steps.emplace_back(model);
  }
  core::ThreadPool pool;
  std::vector<StepWorkspace> steps;  // per thread
  std::vector<StepResult> results;
};

namespace detail {

/// Calls visit(column, workspace, result) for every column on all threads, in blocks, because handing out a single step may cost more than
/// the step.
template <class Visit>
void for_each_column(StepBatchWorkspace& workspace, Eigen::Index n, Eigen::Index block_size, Visit&& visit) {
  StepBatchWorkspace::Impl& work = workspace.impl();
  work.pool.run(static_cast<int>((n + block_size - 1) / block_size), [&](int block, int worker) {
    for (Eigen::Index i = block * block_size; i < std::min(n, (block + 1) * block_size); ++i)
      visit(i, work.steps[static_cast<std::size_t>(worker)], work.results[static_cast<std::size_t>(worker)]);
  });
}

/// Options for the steps of a batch: cold, so that each step depends on its own input alone. @throws core::InvalidInput: out of range
inline StepOptions cold(StepOptions options) {
  options.warm_start = options.with_force_derivatives = false;
  options.validate();
  return options;
}

/// Counts failures. @param failed  number of entries that are not Solved  @returns the first status that is not Solved, or Solved
inline core::Status first_failure(const std::vector<core::Status>& status, int& failed) {
  const auto is_failure = [](core::Status one) { return one != core::Status::Solved; };
  failed = static_cast<int>(std::ranges::count_if(status, is_failure));
  const auto first = std::ranges::find_if(status, is_failure);
  return first == status.end() ? core::Status::Solved : *first;
}

}  // namespace detail
}  // namespace stiction::dynamics
