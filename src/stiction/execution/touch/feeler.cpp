#include "stiction/execution/touch/feeler.hpp"

#include <cmath>

#include "stiction/core/invalid_input.hpp"

namespace stiction::execution {

using Eigen::VectorXd;

namespace {

VectorXd calc_joint_noise(const ControlScenario& arm) {
  if (arm.observer.joint_noise.size() > 0) return arm.observer.joint_noise;
  return VectorXd::Constant(arm.model->n_a(), arm.observer.noise);
}

}  // namespace

Feeler::Feeler(const ControlScenario& arm)
    : arm_(arm),
      sensor_(sensing::Sensor::make(arm.model, arm.estimator.sensor)),
      work_(sensor_),
      memory_(std::exp(-arm.period / arm.observer.time_constant)) {
  const double whiter = (1 + memory_) / (1 - memory_);
  noise_ = (whiter * calc_joint_noise(arm).array().square()).matrix().asDiagonal();
  listen();
}

void Feeler::listen() {
  onset_.reset();
  last_.resize(0);
  sum_.setZero(arm_.model->n_a());
  rows_ = 0;
}

void Feeler::start() {
  if (rows_ == 0) core::throw_invalid("rest", "no row", "at least one row while nothing touches");
  onset_.emplace(sum_ / rows_, sensing::OnsetOptions{.noise = noise_, .drift = arm_.observer.drift, .rest_rows = rows_});
  settle();
}

bool Feeler::update(const VectorXd& external) {
  if (last_.size() == 0) {
    last_ = external;
    return false;
  }
  row_ = (external - memory_ * last_) / (1 - memory_);
  last_ = external;
  sum_ += row_;
  ++rows_;
  return onset_ && onset_->update(row_, arm_.period);
}

double Feeler::age() const { return touches() ? onset_->rows() * arm_.period : 0; }

void Feeler::settle() {
  sum_.setZero();
  rows_ = 0;
}

const sensing::SenseResult& Feeler::identify(const VectorXd& q) {
  if (!touches() || rows_ == 0) core::throw_invalid("touch", "nothing", "a touch, and a row since settle()");
  sensing::SenseOptions options = arm_.estimator.sense;
  options.threshold.reset(), options.max_descents.reset();
  options.posterior = true;
  options.torques.rest = onset_->rest();
  options.torques.covariance = onset_->noise() + noise_ / rows_;
  VectorXd q_full = arm_.model->neutral();
  q_full.tail(q.size()) = q;
  sensing::sense(*sensor_, {q_full, sum_ / rows_}, options, work_, sensed_);
  return sensed_;
}

}  // namespace stiction::execution
