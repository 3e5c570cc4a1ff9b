#include "stiction/planning/press_limits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stiction::planning {

PressLimits::PressLimits(const world::Model& model, const world::RobotChains& chains, double brace_force)
    : model_(model), brace_force_(brace_force) {
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    fragile_ = fragile_ || std::isfinite(model.pairs()[static_cast<std::size_t>(i)].max_force);
    may_brace_.push_back(chains.mask_of_pair(i) != 0 && !chains.touches_object(i));
  }
}

double PressLimits::share(std::span<const dynamics::ContactImpulse> contacts, double h) const {
  if (!fragile_) return 0;
  double worst = 0;
  for (const auto& first : contacts) {
    const double most = model_.pairs()[static_cast<std::size_t>(first.contact.pair)].max_force;
    if (!std::isfinite(most)) continue;
    double impulse = 0;
    for (const auto& c : contacts) impulse += c.contact.pair == first.contact.pair ? c.lambda[0] : 0.0;
    worst = std::max(worst, impulse / (h * most));
  }
  return worst;
}

bool PressLimits::braces(std::span<const dynamics::ContactImpulse> contacts, double h) const {
  return std::any_of(contacts.begin(), contacts.end(), [&](const dynamics::ContactImpulse& c) {
    return may_brace_[static_cast<std::size_t>(c.contact.pair)] != 0 && c.lambda[0] > brace_force_ * h;
  });
}

std::optional<double> largest_press(const world::Model& model, const Plan& plan) {
  const world::RobotChains chains(model);
  const PressLimits press(model, chains, std::numeric_limits<double>::infinity());
  if (!press.fragile()) return std::nullopt;
  double worst = 0;
  for (const Segment& segment : plan.segments) {
    for (const auto& knot : segment.knots) worst = std::max(worst, press.share(knot.contacts, plan.step.h));
  }
  return worst;
}

}  // namespace stiction::planning
