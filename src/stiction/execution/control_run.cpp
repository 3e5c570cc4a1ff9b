#include "stiction/execution/control_run.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/quantile.hpp"

namespace stiction::execution {

using core::Status;

void ControlRunOptions::validate() const { core::require_nonnegative("settle", settle); }

namespace {

double quantile_or_0(const std::vector<double>& values, double p) { return values.empty() ? 0 : core::quantile(values, p); }

/// The contact of sample k is at least `settle` ticks old.
bool is_settled(const std::vector<ControlSample>& samples, std::size_t k, std::size_t settle) {
  if (k < settle) return false;
  for (std::size_t i = k - settle; i <= k; ++i)
    if (!(samples[i].largest_force > 0)) return false;
  return true;
}

double calc_peak_force_rate(const std::vector<ControlSample>& samples, double period, double settle) {
  double out = 0;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const double fall = samples[k - 1].largest_force - samples[k].largest_force;
    if (is_settled(samples, k - 1, static_cast<std::size_t>(settle / period))) out = std::max(out, fall / period);
  }
  return out;
}

Status run(const ControlScenario& scenario, const ControlRunOptions& options, ControlLoop& loop, ControlRunResult& out) {
  const auto ticks = static_cast<long>(std::ceil(scenario.duration / scenario.period - 1e-9));
  Eigen::VectorXd reference;
  for (long k = 0; k < ticks; ++k) {
    if (options.control.cancelled()) return Status::Cancelled;
    if (options.control.expired()) return Status::MaxIterations;
    calc_reference(scenario, loop.time() + scenario.period, reference);
    if (loop.tick(reference, out.samples.emplace_back()) != Status::Solved) {
      out.message = loop.message();
      return Status::NumericalFailure;
    }
  }
  return Status::Solved;
}

}  // namespace

void summarise(const ControlScenario& scenario, const ControlLoop& loop, double settle, ControlRunResult& out) {
  std::vector<double> bounded;
  double force_sum = 0, error_contact = 0, error_free = 0;
  int in_contact = 0, free = 0;
  std::optional<double> made;
  for (const ControlSample& s : out.samples) {
    const bool touches = s.largest_force > 0;
    if (touches && !made) made = s.time, ++out.makes;
    if (!touches) made.reset();
    (touches ? in_contact : free) += 1;
    (touches ? error_contact : error_free) += s.error * s.error;
    out.peak_force = std::max(out.peak_force, s.largest_force);
    out.peak_speed = std::max(out.peak_speed, s.speed);
    out.slack_ticks += s.slack > 1e-3 * scenario.controller.lambda_max;
    if (!made || s.time < *made + settle) continue;
    ++out.settled_ticks;
    force_sum += s.largest_force;
    out.settled_peak = std::max(out.settled_peak, s.largest_force);
    if (!s.bounded) continue;
    bounded.push_back(s.largest_force);
    out.bound_error += std::abs(s.largest_force - scenario.controller.lambda_max);
  }
  out.peak_force_rate = calc_peak_force_rate(out.samples, scenario.period, settle);
  out.bounded_ticks = static_cast<int>(bounded.size());
  if (!bounded.empty()) out.bound_error /= static_cast<double>(bounded.size());
  out.bound_p95 = quantile_or_0(bounded, 0.95);
  if (out.settled_ticks > 0) out.mean_force = force_sum / out.settled_ticks;
  if (in_contact > 0) out.rms_error_contact = std::sqrt(error_contact / in_contact);
  if (free > 0) out.rms_error_free = std::sqrt(error_free / free);
  out.unsolved_ticks = loop.unsolved_ticks();
  out.tick_median_s = quantile_or_0(loop.update_times(), 0.5);
  out.tick_p99_s = quantile_or_0(loop.update_times(), 0.99);
  out.sense_median_s = quantile_or_0(loop.sense_times(), 0.5);
  out.sense_p99_s = quantile_or_0(loop.sense_times(), 0.99);
}

Status run_control(const ControlScenario& scenario, const ControlRunOptions& options, ControlRunResult& out) {
  options.validate();
  ControlLoop loop(scenario, scenario.model);
  out = {};
  out.status = run(scenario, options, loop, out);
  summarise(scenario, loop, options.settle, out);
  return out.status;
}

}  // namespace stiction::execution
