#include "stiction/planning/settle_start.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stiction/planning/contact_limits.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;

/// An object that still moves after kMostSettling steps, and has moved this far, is not supported [L of the robots], [rad].
constexpr double kFallenMove = 0.5, kFallenTurn = 0.05;

/// Names the pair that overlaps most at the start of a step; empty if none overlaps.
std::string deepest_pair(const Model& model, const dynamics::StepResult& step) {
  const auto deepest = std::min_element(step.contacts.begin(), step.contacts.end(),
                                        [](const auto& a, const auto& b) { return a.contact.phi < b.contact.phi; });
  if (deepest == step.contacts.end() || deepest->contact.phi >= 0) return {};
  const auto& pair = model.pairs()[static_cast<std::size_t>(deepest->contact.pair)];
  return fmt::format("; '{}' is {:.3g} m inside '{}'", model.geometries()[static_cast<std::size_t>(pair.geometry_a)].name,
                     -deepest->contact.phi, model.geometries()[static_cast<std::size_t>(pair.geometry_b)].name);
}

}  // namespace

std::optional<Trace> settle_start(const Setting& setting, const Eigen::VectorXd& u_start, ThreadScratch& scratch, Totals& totals,
                                  PlanResult& result) {
  const Model& model = setting.model;
  const Eigen::VectorXd& q_start = setting.problem.q_start;
  const double length = model.scales().robots().length;
  Trace at{.q = q_start, .u = u_start.size() > 0 ? u_start : q_start.tail(model.n_a())};
  at.u = at.u.cwiseMax(model.command_lower()).cwiseMin(model.command_upper()).eval();
  Simulation simulation(setting, scratch, totals);
  const Pace pace{Pace::Kind::WithinEfforts, setting.exact, {}, {}};
  scratch.steps.forget();
  bool rests = false;
  for (int k = 0; k < threshold::kMostSettling && !rests; ++k) {
    Trace next{.q = at.q, .u = at.u};
    const Ending ending = simulation.hold(1, setting.thresholds.rest, pace, {}, {}, next, rests);
    if (ending == Ending::Stopped) return std::nullopt;
    const dynamics::StepResult& step = scratch.step_result;
    if (ending != Ending::Reached) {
      result.reason = fmt::format("the start cannot be settled: step {} of the exact dynamics ends in {}{}", k + 1,
                                  core::to_string(step.status), deepest_pair(model, step));
      return std::nullopt;
    }
    if (k == 0) {
      for (const auto& c : step.contacts) result.start_penetration = std::max(result.start_penetration, -c.contact.phi);
      result.start_projected = calc_penetration(model, step) > 1 &&
                               world::largest_share(model, step.delta, world::share::kContact * length, world::share::kContact) > 1;
    }
    at.u = next.u;
    if (rests) break;
    at.q = next.q;
    at.knots.push_back(std::move(next.knots.front()));
  }
  const Eigen::VectorXd e = setting.goal.difference(q_start, at.q);
  result.start_moved = world::largest_share(model, e, 1, 1);
  const double slip = setting.goal.share_of_tolerances(q_start, at.q);
  result.start_slips = slip > setting.problem.start_may_move;
  if (result.start_slips) {
    result.reason = fmt::format("the object does not rest at the start: it moves by {:.1f} tolerances", slip);
    return std::nullopt;
  }
  if (rests || world::largest_share(model, e, kFallenMove * length, kFallenTurn) <= 1) return at;
  result.reason = fmt::format(
      "the objects do not come to rest at the start: after {} steps one has moved by {:.3g} (m or rad); "
      "is it supported?",
      threshold::kMostSettling, result.start_moved);
  return std::nullopt;
}

}  // namespace stiction::planning
