#pragma once

#include <string>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/execution/contact_control/control_loop.hpp"

namespace stiction::execution {

struct ControlRunOptions {
  /// A contact is settled after the pair has touched without a break for this long [s], ≥ 0.
  double settle = 0.3;
  core::RunControl control;
  void validate() const;
};

/// Result of a control run. Forces are measured forces of single contacts.
struct ControlRunResult {
  core::Status status = core::Status::NumericalFailure;
  std::string message;
  std::vector<ControlSample> samples;
  double peak_force = 0;    ///< largest force [N]
  double settled_peak = 0;  ///< largest force of settled contacts [N]
  int settled_ticks = 0;    ///< ticks with a settled contact; the force of such a tick is that of its largest settled contact
  int bounded_ticks = 0;    ///< settled ticks with the force at its bound
  double bound_error = 0;   ///< mean |f − λ_max| over the bounded ticks [N]
  double bound_p95 = 0;     ///< 95th percentile of f over the bounded ticks [N]
  double mean_force = 0;    ///< mean force over the settled ticks [N]
  int makes = 0;            ///< how often the robot as a whole came into contact
  double rms_error_contact = 0, rms_error_free = 0;  ///< root mean square of ControlSample::error in contact, and without contact
  double peak_speed = 0;                             ///< largest ‖q̇‖ [rad/s]
  double peak_force_rate = 0;                        ///< largest fall of a settled contact's force between two ticks [N/s]
  double peak_rise = 0;                              ///< largest rise of a settled contact's force between two ticks [N]
  double commanded_rise = 0;  ///< part of this rise due to the command, −J_u Δq_cmd / (J_u K⁻¹ J_uᵀ) (C.1) [N]
  int above_ticks = 0;        ///< settled ticks with a force above its bound by more than a fifth
  int slack_ticks = 0;        ///< ticks in which the slack of a bound was more than a thousandth of the bound
  int unsolved_ticks = 0;
  double tick_median_s = 0, tick_p99_s = 0;    ///< processor time of the controller's update()
  double sense_median_s = 0, sense_p99_s = 0;  ///< processor time of the estimator, over the ticks with torques
};

/// Computes the figures of `out` from its samples and from the counts of the loop. @param settle  as in ControlRunOptions [s]
void summarise(const ControlScenario& scenario, const ControlLoop& loop, double settle, ControlRunResult& out);

/// Runs a scenario in the second-order simulation: joint impedance control, above it the contact controller, with the contacts of the scenario's source.
/// @returns Solved | NumericalFailure: the simulation stopped, `message` says why | Cancelled | MaxIterations (deadline)
/// @throws core::InvalidInput: options out of range
/// Tests: tests/execution/control_test.cpp
[[nodiscard]] core::Status run_control(const ControlScenario& scenario, const ControlRunOptions& options, ControlRunResult& out);

}  // namespace stiction::execution
