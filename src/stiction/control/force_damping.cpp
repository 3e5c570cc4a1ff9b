#include "stiction/control/force_damping.hpp"

#include <cmath>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::control {

void ForceDampingOptions::validate() const {
  core::require_nonnegative("damping.largest", largest);
  core::require_positive("damping.force_scale", force_scale);
  core::require_positive("damping.period", period);
  if (!(forget_rate > 0 && forget_rate <= 1)) core::throw_invalid("damping.forget_rate", std::to_string(forget_rate), "a number in (0, 1]");
}

double ForceDamping::update(double error, double dt) {
  const double share = dt / options_.period;
  const double alpha = 1 - std::pow(1 - options_.forget_rate, share);
  const double e = 1 - std::exp(-error / options_.force_scale);  // (5.28)
  const double previous = options_.printed ? last_ : filtered_;
  last_ = e;
  filtered_ = alpha * e + (1 - alpha) * previous;  // (5.29)
  return options_.largest / share * filtered_;
}

}  // namespace stiction::control
