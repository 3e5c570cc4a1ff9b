#include "stiction/execution/touch/friction_motion.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "stiction/execution/touch/move_parts.hpp"

namespace stiction::execution {

using core::Status;
using Eigen::VectorXd;

namespace {

/// v₀, small because guarded moves are slow: friction has its full sign already at a fifth of their joint speeds [rad/s or m/s].
constexpr double kStictionSpeed = 0.003;
constexpr double kDuration = 8;                  ///< T [s]
constexpr double kLowest = 0.8, kHighest = 1.6;  ///< frequency of the first and of the last joint [1/s]

/// The arm for this motion, with tracking alone: unknown friction would look like contacts to the controller.
ControlScenario make_mover(const TouchScenario& scenario, const TouchRunOptions& options, const GuardedRunResult& out) {
  ControlScenario arm = make_guarded_arm(scenario, out, options.seed);
  arm.tool = -1;
  arm.controller.law = control::Law::Unconstrained;
  arm.observer.friction_error.reset();
  return arm;
}

VectorXd calc_posture(const ControlScenario& arm, double amplitude, double t) {
  const double envelope = std::sin(std::numbers::pi * t / kDuration);
  VectorXd q = arm.start;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double share = q.size() > 1 ? static_cast<double>(j) / static_cast<double>(q.size() - 1) : 0;
    const double frequency = kLowest + share * (kHighest - kLowest);
    q[j] += amplitude * envelope * envelope * std::sin(2 * std::numbers::pi * frequency * t);
  }
  return q.cwiseMax(arm.model->lower()).cwiseMin(arm.model->upper());
}

/// Names the first joint whose torques are neither friction nor noise, because something touched the arm. Empty: none.
std::string name_disturbed(const ControlScenario& arm, const sensing::JointFriction& friction) {
  constexpr double kOfNoise = 3, kOfFriction = 0.5;
  for (Eigen::Index j = 0; j < friction.left.size(); ++j) {
    const double noise = arm.observer.joint_noise.size() > 0 ? arm.observer.joint_noise[j] : arm.observer.noise;
    if (friction.left[j] <= kOfNoise * noise + kOfFriction * std::abs(friction.coulomb[j])) continue;
    return fmt::format("the motion for friction left {:.3g} N m or N of the torques of '{}' that are no friction: is something in its way?",
                       friction.left[j], arm.model->dofs()[static_cast<std::size_t>(arm.model->n_vu() + j)].name);
  }
  return "";
}

}  // namespace

Status find_friction(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out) {
  const ControlScenario arm = make_mover(scenario, options, out);
  ControlLoop loop(arm, out.world);
  const auto ticks = static_cast<Eigen::Index>(std::lround(kDuration / arm.period));
  std::vector<ControlSample> samples;
  std::vector<double> times;
  Eigen::MatrixXd v = Eigen::MatrixXd::Zero(arm.model->n_a(), ticks), r = v;
  VectorXd q = arm.start, before = q;
  Status go_on = Status::Solved;
  for (Eigen::Index k = 0; k < ticks; ++k) {
    samples.clear();
    if (!tick_arm(calc_posture(arm, scenario.friction_motion, loop.time() + arm.period), options.control, loop, samples, q, go_on) ||
        go_on != Status::Solved) {
      out.reason = go_on == Status::NumericalFailure ? loop.message() : "";
      return out.status = out.run.status = go_on;
    }
    times.push_back(samples.back().time);
    if (k > 0) v.col(k) = (q - before) / arm.period;  // mean speed in the period of this row
    if (samples.back().external.size() > 0) r.col(k) = samples.back().external;
    before = q;
  }
  out.friction = sensing::fit_friction(*arm.model, times, v, r, arm.observer.time_constant, kStictionSpeed);
  out.reason = name_disturbed(arm, *out.friction);
  return out.status = Status::Solved;
}

}  // namespace stiction::execution
