#include "stiction/dynamics/rollout_batch.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <atomic>

#include "stiction/core/invalid_input.hpp"
#include "stiction/dynamics/batch_workspace.hpp"
#include "stiction/dynamics/sample_step.hpp"

namespace stiction::dynamics {
namespace {

using core::Status;
using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Sizes of a batch. @throws core::InvalidInput: sizes do not match
struct Sizes {
  Sizes(const world::Model& model, const RolloutBatchInput& in) : n_q(model.n_q()), n_a(model.n_a()), n(in.q_start.cols()) {
    core::require_size("q_start", in.q_start.rows(), n_q);
    if (n_a == 0 || in.u.rows() % n_a != 0)
      core::throw_invalid("u", fmt::format("{} numbers a trajectory", in.u.rows()),
                          fmt::format("a multiple of {}, a command for each step", n_a));
    if (in.u.cols() != n) core::throw_invalid("u", fmt::format("{} trajectories", in.u.cols()), fmt::format("{}, one for each start", n));
    steps = in.u.rows() / n_a;
  }
  Index n_q, n_a, n, steps = 0;
};

/// @throws core::InvalidInput: not one trajectory for each of u, or not of its length
void require_trajectories(const char* name, MatrixRef columns, const Sizes& size) {
  if (columns.cols() != size.n)
    core::throw_invalid(name, fmt::format("{} trajectories", columns.cols()), fmt::format("{}, one for each of u", size.n));
  if (columns.rows() != size.n_q * (size.steps + 1))
    core::throw_invalid(name, fmt::format("{} configurations a trajectory", columns.rows() / size.n_q),
                        fmt::format("{}, the start and one for each of the {} commands of u", size.steps + 1, size.steps));
}

StepOptions options_of(StepOptions options, bool with_derivatives) {
  options.with_A = options.with_B = with_derivatives;
  return detail::cold(options);
}

/// Calls visit(first index in q, first index in v) for the rotation of every free object. Only there q has more numbers than its tangent.
template <class Visit>
void for_each_quaternion(const world::Model& model, Visit&& visit) {
  for (const auto& object : model.objects()) {
    if (object.n_v == 6) visit(object.q_begin + 3, object.v_begin + 3);
  }
}

/// Calls copy for the coordinates that are the same in q and in v. @param copy  (first in q, first in v, how many)
template <class Copy>
void for_each_plain(const world::Model& model, Copy&& copy) {
  for (const auto& object : model.objects()) copy(object.q_begin, object.v_begin, object.n_v == 6 ? 3 : object.n_v);
  copy(model.n_qu(), model.n_vu(), model.n_a());
}

/// w += Gᵀ g. A unit quaternion (v, w) moves by ½ (w δ + v × δ, −v·δ).
void add_tangent(const world::Model& model, VectorRef q, VectorRef g, VectorXd& w) {
  for_each_plain(model, [&](Index i, Index v, Index n) { w.segment(v, n) += g.segment(i, n); });
  for_each_quaternion(model, [&](Index i, Index v) {
    const Vector3d a = q.segment<3>(i), g_a = g.segment<3>(i);
    w.segment<3>(v) += 0.5 * (q[i + 3] * g_a + g_a.cross(a) - g[i + 3] * a);
  });
}

/// G (GᵀG)⁻¹ w, GᵀG = ¼ for quaternions.
void to_numbers(const world::Model& model, VectorRef q, const VectorXd& w, Eigen::Ref<VectorXd> g) {
  for_each_plain(model, [&](Index i, Index v, Index n) { g.segment(i, n) = w.segment(v, n); });
  for_each_quaternion(model, [&](Index i, Index v) {
    const Vector3d a = q.segment<3>(i), w_r = w.segment<3>(v);
    g.segment<3>(i) = 2 * (q[i + 3] * w_r + a.cross(w_r));
    g[i + 3] = -2 * a.dot(w_r);
  });
}

/// Takes one cold step. The message of an InvalidInput names the trajectory and the step.
/// @param delta  approximate δq (n_v), or null
Status step_of(const world::Model& model, Index trajectory, Index t, const StepInput& in, const VectorXd* delta, const StepOptions& options,
               StepWorkspace& steps, StepResult& result) {
  steps.forget();
  try {
    return delta == nullptr ? step(model, in, options, steps, result) : detail::sample_step(model, in, *delta, options, steps, result);
  } catch (const core::InvalidInput& error) {
    throw core::InvalidInput(fmt::format("trajectory {}, step {}: {}", trajectory, t, error.what()));
  }
}

}  // namespace

Status rollout_batch(const world::Model& model, const RolloutBatchInput& in, const StepOptions& given, StepBatchWorkspace& work,
                     RolloutBatchResult& out, const core::RunControl& control) {
  const Sizes size(model, in);
  const StepOptions options = options_of(given, false);
  out.status.assign(static_cast<std::size_t>(size.n), Status::Solved);
  out.steps.assign(static_cast<std::size_t>(size.n), 0);
  out.q.resize(size.n_q * (size.steps + 1), size.n);
  detail::for_each_column(work, size.n, 1, [&](Index i, StepWorkspace& steps, StepResult& result) {
    Status& status = out.status[static_cast<std::size_t>(i)];
    auto q = out.q.col(i);
    q.head(size.n_q) = in.q_start.col(i);
    for (Index t = 0; t < size.steps; ++t) {
      const auto from = q.segment(t * size.n_q, size.n_q);
      auto to = q.segment((t + 1) * size.n_q, size.n_q);
      if (status == Status::Solved && control.stop()) status = control.status_when_stopped();
      if (status == Status::Solved) {
        status = step_of(model, i, t, {from, in.u.col(i).segment(t * size.n_a, size.n_a)}, nullptr, options, steps, result);
        out.steps[static_cast<std::size_t>(i)] += status == Status::Solved;
      }
      to = from;
      if (status == Status::Solved) to = result.q_next;
    }
  });
  return detail::first_failure(out.status, out.failed);
}

Status pull_back_rollout(const world::Model& model, const RolloutBatchInput& in, const RolloutBatchResult& rolled, MatrixRef D_L_q,
                         const StepOptions& given, StepBatchWorkspace& work, RolloutGradient& out, const core::RunControl& control) {
  const Sizes size(model, in);
  const StepOptions options = options_of(given, true);
  require_trajectories("rolled", rolled.q, size);
  require_trajectories("D_L_q", D_L_q, size);
  const bool smoothed = std::holds_alternative<Analytic>(options.smoothing);
  out.q_start.resize(size.n_q, size.n);
  out.u.setZero(size.n_a * size.steps, size.n);
  std::atomic<bool> stopped = false;
  detail::for_each_column(work, size.n, 1, [&](Index i, StepWorkspace& steps, StepResult& result) {
    const auto q = rolled.q.col(i);
    const auto g = D_L_q.col(i);
    VectorXd w = VectorXd::Zero(model.n_v()), delta(model.n_v());
    add_tangent(model, q.tail(size.n_q), g.tail(size.n_q), w);
    for (Index t = size.steps; t-- > 0;) {
      if (stopped || control.stop()) {
        stopped = true;
        return;
      }
      const auto from = q.segment(t * size.n_q, size.n_q);
      const auto u = in.u.col(i).segment(t * size.n_a, size.n_a);
      if (smoothed) world::local(model, from, q.segment((t + 1) * size.n_q, size.n_q), delta);
      if (t < rolled.steps[static_cast<std::size_t>(i)] &&
          step_of(model, i, t, {from, u}, smoothed ? &delta : nullptr, options, steps, result) == Status::Solved) {
        out.u.col(i).segment(t * size.n_a, size.n_a).noalias() = result.B.transpose() * w;
        w = (result.A.transpose() * w).eval();
      }
      add_tangent(model, from, g.segment(t * size.n_q, size.n_q), w);
    }
    to_numbers(model, q.head(size.n_q), w, out.q_start.col(i));
  });
  return !stopped ? Status::Solved : control.status_when_stopped();
}

}  // namespace stiction::dynamics
