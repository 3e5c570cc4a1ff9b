#pragma once

#include <memory>
#include <vector>

#include "stiction/dynamics/step.hpp"

namespace stiction::dynamics {

using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;

/// Steps from N pairs of configuration and command, one a column.
struct StepBatchInput {
  MatrixRef q;                               ///< (n_q × N)
  MatrixRef u;                               ///< (n_a × N)
  const Eigen::MatrixXd* tau_ext = nullptr;  ///< external generalised forces besides gravity (n_v × N) [N, N·m]; may be null
};

struct StepBatchResult {
  std::vector<core::Status> status;  ///< (N)
  Eigen::MatrixXd q_next;            ///< (n_q × N)
  Eigen::MatrixXd torque;            ///< (n_a × N) [N·m, N]
  /// One step a column, each with its rows one after the other (n_v·n_v × N and n_v·n_a × N): an array (N, n_v, n_v) in the order of C. Empty unless
  /// asked for.
  Eigen::MatrixXd A, B;
  int failed = 0;  ///< steps that are not Solved
};

/// Threads and a step workspace for each; belongs to one caller at a time.
class StepBatchWorkspace {
 public:
  /// @param threads  0 = all cores   @throws core::InvalidInput: threads < 0
  explicit StepBatchWorkspace(std::shared_ptr<const world::Model> model, int threads = 0);
  ~StepBatchWorkspace();
  StepBatchWorkspace(StepBatchWorkspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// step() for every column. Each is solved cold, so that it depends on its own column alone: the result has the same bits for any number of threads,
/// order and size of the batch.
///
/// @param options  of the steps; warm_start and with_force_derivatives are not used
/// @returns Solved, or the status of the first step that is not; its q_next is its q, its A and B are 0
/// @throws  core::InvalidInput: as step(), with the number of the step, and q or u of different numbers of columns
/// Tests: tests/dynamics/step_batch_test.cpp
core::Status step_batch(const world::Model& model, const StepBatchInput& in, const StepOptions& options, StepBatchWorkspace& work,
                        StepBatchResult& out);

}  // namespace stiction::dynamics
