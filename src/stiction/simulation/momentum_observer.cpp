#include "stiction/simulation/momentum_observer.hpp"

#include <cmath>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::simulation {

namespace {
constexpr std::uint64_t kStream = 0x6f627376;  // of random numbers
}  // namespace

void ObserverOptions::validate() const {
  core::require_positive("observer.time_constant", time_constant);
  core::require_nonnegative("observer.noise", noise);
  core::require_nonnegative("observer.bias", bias);
  core::require_finite("observer.inertia_error", inertia_error);
  if (!(inertia_error > -1)) core::throw_invalid("observer.inertia_error", std::to_string(inertia_error), "a number > -1");
}

MomentumObserver::MomentumObserver(Eigen::Index joints, double period, const ObserverOptions& options)
    : options_(options), period_(period), random_(options.seed, kStream) {
  options.validate();
  core::require_positive("observer.period", period);
  gain_ = period / (options.time_constant + period);
  sensor_noise_ = options.noise * std::sqrt((2 - gain_) / gain_);
  p_.setZero(joints), r_.setZero(joints), bias_.setZero(joints);
  reset();
}

void MomentumObserver::reset() {
  random_ = core::Random(options_.seed, kStream);
  p_.setZero(), r_.setZero();
  for (double& b : bias_) b = options_.bias * random_.normal();
}

const Eigen::VectorXd& MomentumObserver::update(VectorRef p, VectorRef n, VectorRef tau) {
  for (Eigen::Index j = 0; j < r_.size(); ++j) {
    const double measured = tau[j] + bias_[j] + sensor_noise_ * random_.normal();
    r_[j] += gain_ * ((p[j] - p_[j]) / period_ - measured - n[j] - r_[j]);
  }
  p_ = p;
  return r_;
}

}  // namespace stiction::simulation
