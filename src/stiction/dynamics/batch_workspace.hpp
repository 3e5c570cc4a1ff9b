#pragma once

#include <algorithm>
#include <vector>

#include "stiction/core/parallel.hpp"
#include "stiction/dynamics/step_batch.hpp"

// Internal to the layer: what threads of a batch have of their own.

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

/// Calls visit(column, workspace, result) for every column on all threads, in blocks: a step may cost less than to be handed out.
template <class Visit>
void for_each_column(StepBatchWorkspace& workspace, Eigen::Index n, Eigen::Index block_size, Visit&& visit) {
  StepBatchWorkspace::Impl& work = workspace.impl();
  work.pool.run(static_cast<int>((n + block_size - 1) / block_size), [&](int block, int worker) {
    for (Eigen::Index i = block * block_size; i < std::min(n, (block + 1) * block_size); ++i)
      visit(i, work.steps[static_cast<std::size_t>(worker)], work.results[static_cast<std::size_t>(worker)]);
  });
}

/// Options of steps of a batch: each is cold, so that it depends on its own input alone. @throws core::InvalidInput: out of range
inline StepOptions cold(StepOptions options) {
  options.warm_start = options.with_force_derivatives = false;
  options.validate();
  return options;
}

/// @param failed  how many are not Solved  @returns the first of these, or Solved
inline core::Status first_failure(const std::vector<core::Status>& status, int& failed) {
  const auto is_failure = [](core::Status one) { return one != core::Status::Solved; };
  failed = static_cast<int>(std::ranges::count_if(status, is_failure));
  const auto first = std::ranges::find_if(status, is_failure);
  return first == status.end() ? core::Status::Solved : *first;
}

}  // namespace detail
}  // namespace stiction::dynamics
