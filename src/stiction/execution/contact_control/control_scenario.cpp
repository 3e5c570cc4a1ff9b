#include "stiction/execution/contact_control/control_scenario.hpp"

#include <algorithm>

#include "stiction/core/invalid_input.hpp"

namespace stiction::execution {

void set_lambda_max(ControlScenario& scenario, double lambda_max) {
  core::require_positive("lambda_max", lambda_max);
  scenario.controller.lambda_max = lambda_max;
  scenario.controller.force_threshold = std::min(scenario.controller.force_threshold, lambda_max / 3);
}

ContactEstimatorOptions make_estimator_options(const ControlScenario& scenario) {
  ContactEstimatorOptions out = scenario.estimator;
  const simulation::ObserverOptions& observer = scenario.observer;
  out.noise = observer.joint_noise.size() > 0 ? observer.joint_noise.maxCoeff() : observer.noise;
  if (observer.joint_noise.size() > 0)
    out.sense.torques.covariance = sensing::make_covariance(observer.joint_noise, static_cast<int>(observer.joint_noise.size()), out.noise);
  if (observer.rest.size() > 0) out.sense.torques.rest = observer.rest;
  out.lag = observer.time_constant;
  out.least_force = scenario.controller.force_threshold;
  out.plausible_force = scenario.plausible_force.value_or(2 * scenario.controller.lambda_max);
  return out;
}

Eigen::VectorXd calc_start(const ControlScenario& scenario) {
  Eigen::VectorXd q = scenario.model->neutral();
  if (scenario.objects.size() > 0) q.head(scenario.objects.size()) = scenario.objects;
  q.tail(scenario.start.size()) = scenario.start;
  return q;
}

void calc_reference(const ControlScenario& scenario, double time, Eigen::VectorXd& out) {
  const auto& knots = scenario.knots;
  std::size_t k = 0;
  while (k + 1 < knots.size() && time >= knots[k + 1].time) ++k;
  if (k + 1 == knots.size()) {
    out = knots[k].value;
    return;
  }
  const double s = std::clamp((time - knots[k].time) / (knots[k + 1].time - knots[k].time), 0.0, 1.0);
  out = knots[k].value + s * s * (3 - 2 * s) * (knots[k + 1].value - knots[k].value);
}

}  // namespace stiction::execution
