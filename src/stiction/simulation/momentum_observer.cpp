#include "stiction/simulation/momentum_observer.hpp"

#include <cmath>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::simulation {

namespace {
constexpr std::uint64_t kStream = 0x6f627376, kPostureStream = 0x706f7374, kWalkStream = 0x77616c6b;  // of random numbers
}  // namespace

void ObserverOptions::validate() const {
  core::require_positive("observer.time_constant", time_constant);
  core::require_nonnegative("observer.noise", noise);
  for (const double s : joint_noise) core::require_nonnegative("observer.joint_noise", s);
  core::require_finite("observer.rest", {rest.data(), static_cast<std::size_t>(rest.size())});
  for (const double s : drift) core::require_nonnegative("observer.drift", s);
  core::require_nonnegative("observer.bias", bias);
  core::require_positive("observer.stiction_speed", stiction_speed);
  core::require_size("observer.viscous", viscous.size(), coulomb.size());
  core::require_finite("observer.coulomb", {coulomb.data(), static_cast<std::size_t>(coulomb.size())});
  core::require_finite("observer.viscous", {viscous.data(), static_cast<std::size_t>(viscous.size())});
  core::require_nonnegative("observer.bias_reach", bias_reach);
  core::require_finite("observer.inertia_error", inertia_error);
  if (friction_error && !(*friction_error > -1))
    core::throw_invalid("observer.friction_error", std::to_string(*friction_error), "a number > -1");
  if (!(inertia_error > -1)) core::throw_invalid("observer.inertia_error", std::to_string(inertia_error), "a number > -1");
}

MomentumObserver::MomentumObserver(Eigen::Index joints, double period, const ObserverOptions& options)
    : options_(options), period_(period), random_(options.seed, kStream), random_walk_(options.seed, kWalkStream) {
  options.validate();
  core::require_positive("observer.period", period);
  gain_ = period / (options.time_constant + period);
  if (options.joint_noise.size() > 0) core::require_size("observer.joint_noise", options.joint_noise.size(), joints);
  if (options.coulomb.size() > 0) core::require_size("observer.coulomb", options.coulomb.size(), joints);
  if (options.rest.size() > 0) core::require_size("observer.rest", options.rest.size(), joints);
  if (options.drift.size() > 0) core::require_size("observer.drift", options.drift.size(), joints);
  sensor_noise_ = options.joint_noise.size() > 0 ? options.joint_noise : Eigen::VectorXd::Constant(joints, options.noise).eval();
  sensor_noise_ *= std::sqrt((2 - gain_) / gain_);
  p_.setZero(joints), r_.setZero(joints), cosine_.setZero(joints), sine_.setZero(joints), waves_.setZero(joints, joints),
      walk_.setZero(joints);
  reset();
}

void MomentumObserver::reset() {
  random_ = core::Random(options_.seed, kStream);
  random_walk_ = core::Random(options_.seed, kWalkStream);
  p_.setZero(), r_.setZero(), walk_.setZero();
  if (options_.rest.size() > 0) r_ = walk_ = options_.rest;
  for (double& xi : cosine_) xi = options_.bias * random_.normal();
  if (options_.bias_reach == 0) return;
  core::Random random(options_.seed, kPostureStream);
  for (double& eta : sine_) eta = options_.bias * random.normal();
  for (double& w : waves_.reshaped()) w = random.normal() / options_.bias_reach;
}

const Eigen::VectorXd& MomentumObserver::update(VectorRef p, VectorRef n, VectorRef tau, VectorRef q) {
  for (Eigen::Index j = 0; j < options_.drift.size(); ++j) walk_[j] += options_.drift[j] * std::sqrt(period_) * random_walk_.normal();
  for (Eigen::Index j = 0; j < r_.size(); ++j) {
    const double phase = options_.bias_reach > 0 ? waves_.row(j).dot(q) : 0;
    const double measured =
        tau[j] + cosine_[j] * std::cos(phase) + sine_[j] * std::sin(phase) - walk_[j] + sensor_noise_[j] * random_.normal();
    r_[j] += gain_ * ((p[j] - p_[j]) / period_ - measured - n[j] - r_[j]);
  }
  p_ = p;
  return r_;
}

}  // namespace stiction::simulation
