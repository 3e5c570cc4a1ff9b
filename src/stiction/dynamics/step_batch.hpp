#pragma once

#include <memory>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/dynamics/step.hpp"

namespace stiction::dynamics {

using MatrixRef = Eigen::Ref<const Eigen::MatrixXd>;

/// Steps from N pairs of configuration and command, one pair per column.
struct StepBatchInput {
  MatrixRef q;                               ///< (n_q × N)
  MatrixRef u;                               ///< (n_a × N)
  const Eigen::MatrixXd* tau_ext = nullptr;  ///< external generalised forces besides gravity (n_v × N) [N, N·m]; may be null
};

struct StepBatchResult {
  std::vector<core::Status> status;  ///< (N)
  Eigen::MatrixXd q_next;            ///< (n_q × N)
  Eigen::MatrixXd torque;            ///< (n_a × N) [N·m, N]
  /// One step per column, each matrix flattened row by row (n_v·n_v × N and n_v·n_a × N). In memory A is a C-order array (N, n_v, n_v).
  /// Empty unless asked for.
  Eigen::MatrixXd A, B;
  int failed = 0;  ///< steps that are not Solved
};

/// Thread pool with one step workspace per thread. One caller at a time may use it.
class StepBatchWorkspace {
 public:
  /// @param threads  0 = all cores   @throws core::InvalidInput: not in [0, 1024]
  explicit StepBatchWorkspace(std::shared_ptr<const world::Model> model, int threads = 0);
  ~StepBatchWorkspace();
  StepBatchWorkspace(StepBatchWorkspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Calls step() for every column. Each step is solved cold and depends on its own column alone, so its result has the same bits for any
/// number of threads, order and size of the batch.
///
/// @param options  options of the steps; warm_start and with_force_derivatives are ignored
/// @param control  checked before each step. Steps that it stopped have the status Cancelled, or MaxIterations after its deadline
/// @returns Solved, or the status of the first step that failed. A failed or stopped step has q_next = q and A = B = 0
/// @throws  core::InvalidInput: as step(), with the index of the step; also if q and u have different numbers of columns
/// Tests: tests/dynamics/step_batch_test.cpp
core::Status step_batch(const world::Model& model, const StepBatchInput& in, const StepOptions& options, StepBatchWorkspace& work,
                        StepBatchResult& out, const core::RunControl& control = {});

}  // namespace stiction::dynamics
