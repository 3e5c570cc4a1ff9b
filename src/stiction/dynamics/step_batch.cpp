#include "stiction/dynamics/step_batch.hpp"

#include <fmt/format.h>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/dynamics/batch_workspace.hpp"

namespace stiction::dynamics {

using core::Status;

namespace {

int count_threads(int threads) {
  if (threads < 0 || threads > core::kMostThreads)
    core::throw_invalid("threads", std::to_string(threads), fmt::format("0 for all cores, or a number up to {}", core::kMostThreads));
  return threads == 0 ? core::hardware_threads() : threads;
}

constexpr int kBlock = 16;  // steps per block; handing out a single step may cost more than the step

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

void store_rows(const Eigen::MatrixXd& matrix, Eigen::Ref<Eigen::VectorXd> column) {
  Eigen::Map<RowMajor>(column.data(), matrix.rows(), matrix.cols()) = matrix;
}

}  // namespace

StepBatchWorkspace::StepBatchWorkspace(std::shared_ptr<const world::Model> model, int threads)
    : impl_(std::make_unique<Impl>(model, count_threads(threads))) {}
StepBatchWorkspace::~StepBatchWorkspace() = default;
StepBatchWorkspace::StepBatchWorkspace(StepBatchWorkspace&&) noexcept = default;

Status step_batch(const world::Model& model, const StepBatchInput& in, const StepOptions& given, StepBatchWorkspace& workspace,
                  StepBatchResult& out, const core::RunControl& control) {
  const Eigen::Index n = in.q.cols();
  core::require_size("q", in.q.rows(), model.n_q());
  core::require_size("u", in.u.rows(), model.n_a());
  if (in.u.cols() != n) core::throw_invalid("u", fmt::format("{} commands", in.u.cols()), fmt::format("{}, one for each q", n));
  if (in.tau_ext != nullptr) {
    core::require_size("tau_ext", in.tau_ext->rows(), model.n_v());
    if (in.tau_ext->cols() != n)
      core::throw_invalid("tau_ext", fmt::format("{} forces", in.tau_ext->cols()), fmt::format("{}, one for each q", n));
  }
  const StepOptions options = detail::cold(given);
  out.status.assign(static_cast<std::size_t>(n), Status::NumericalFailure);
  out.q_next.resize(model.n_q(), n);
  out.torque.resize(model.n_a(), n);
  out.A.resize(options.with_A ? model.n_v() * model.n_v() : 0, options.with_A ? n : 0);
  out.B.resize(options.with_B ? model.n_v() * model.n_a() : 0, options.with_B ? n : 0);
  detail::for_each_column(workspace, n, kBlock, [&](Eigen::Index i, StepWorkspace& steps, StepResult& result) {
    if (control.stop()) {
      out.status[static_cast<std::size_t>(i)] = control.status_when_stopped();
      out.q_next.col(i) = in.q.col(i);
      out.torque.col(i).setZero();
      if (options.with_A) out.A.col(i).setZero();
      if (options.with_B) out.B.col(i).setZero();
      return;
    }
    steps.forget();
    const Eigen::VectorXd tau_ext = in.tau_ext == nullptr ? Eigen::VectorXd() : in.tau_ext->col(i);
    const StepInput input{in.q.col(i), in.u.col(i), in.tau_ext == nullptr ? nullptr : &tau_ext};
    try {
      out.status[static_cast<std::size_t>(i)] = step(model, input, options, steps, result);
    } catch (const core::InvalidInput& error) {
      throw core::InvalidInput(fmt::format("step {}: {}", i, error.what()));
    }
    out.q_next.col(i) = result.q_next;
    out.torque.col(i) = result.torque;
    if (options.with_A) store_rows(result.A, out.A.col(i));
    if (options.with_B) store_rows(result.B, out.B.col(i));
  });
  return detail::first_failure(out.status, out.failed);
}

}  // namespace stiction::dynamics
