#pragma once

#include <string>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/execution/contact_control/control_loop.hpp"

namespace stiction::execution {

struct ControlRunOptions {
  /// The force of a pair is called settled once it has touched for this long without a break [s], ≥ 0.
  double settle = 0.3;
  core::RunControl control;
  void validate() const;
};

/// What the run comes to. Forces: of single contacts, measured.
struct ControlRunResult {
  core::Status status = core::Status::NumericalFailure;
  std::string message;
  std::vector<ControlSample> samples;
  double peak_force = 0;                             ///< [N]
  double settled_peak = 0;                           ///< the same of settled pairs [N]
  int settled_ticks = 0;                             ///< in which a pair was settled; forces of these are those of its largest
  int bounded_ticks = 0;                             ///< of these with the force at its bound
  double bound_error = 0;                            ///< mean |f − λ_max| over them [N]
  double bound_p95 = 0;                              ///< 95th percentile of f over them [N]
  double mean_force = 0;                             ///< over the settled ticks [N]
  int makes = 0;                                     ///< contacts made, of the robot as a whole
  double rms_error_contact = 0, rms_error_free = 0;  ///< of ControlSample::error
  double peak_speed = 0;                             ///< largest ‖q̇‖ [rad/s]
  double peak_force_rate = 0;                        ///< largest fall of a force between two ticks, settled contacts [N/s]
  double peak_rise = 0;                              ///< largest rise of a force between two ticks, settled contacts [N]
  double commanded_rise = 0;  ///< what the change of the command makes of it, −J_u Δq_cmd / (J_u K⁻¹ J_uᵀ) of that contact (C.1) [N]
  int above_ticks = 0;        ///< settled ones in which a force is above its bound by more than a fifth
  int slack_ticks = 0;        ///< in which a bound was given up by more than a thousandth of itself
  int unsolved_ticks = 0;
  double tick_median_s = 0, tick_p99_s = 0;    ///< processor time of update()
  double sense_median_s = 0, sense_p99_s = 0;  ///< of the estimator, over the ticks in which it was told of torques
};

/// The figures of `out` from its samples and what the loop counted. @param settle  as in ControlRunOptions [s]
void summarise(const ControlScenario& scenario, const ControlLoop& loop, double settle, ControlRunResult& out);

/// Runs the scenario in the second-order simulation: impedance control of the joints, the contact controller above it, contacts as simulated.
/// @returns Solved | NumericalFailure: the simulation stopped, `message` says why | Cancelled | MaxIterations (deadline)
/// @throws core::InvalidInput: options out of range
/// Tests: tests/execution/control_test.cpp
[[nodiscard]] core::Status run_control(const ControlScenario& scenario, const ControlRunOptions& options, ControlRunResult& out);

}  // namespace stiction::execution
