#include "stiction/planning/settle_start.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;

/// The settling of the start stops when no object moves farther than this in a step [L of the robots], [rad].
constexpr double kSettledMove = 1e-5, kSettledTurn = 1e-6;
constexpr int kMaxSettleSteps = 100;
/// An object that is still moving after so many steps and has gone this far is not supported [L of the robots], [rad].
constexpr double kFallenMove = 0.5, kFallenTurn = 0.05;

/// The pair that overlaps most at the start of a step, in words; empty where none does.
std::string deepest_pair(const Model& model, const dynamics::StepResult& step) {
  const auto deepest = std::min_element(step.contacts.begin(), step.contacts.end(),
                                        [](const auto& a, const auto& b) { return a.contact.phi < b.contact.phi; });
  if (deepest == step.contacts.end() || deepest->contact.phi >= 0) return {};
  const auto& pair = model.pairs()[static_cast<std::size_t>(deepest->contact.pair)];
  return fmt::format("; '{}' is {:.3g} m inside '{}'", model.geometries()[static_cast<std::size_t>(pair.geometry_a)].name,
                     -deepest->contact.phi, model.geometries()[static_cast<std::size_t>(pair.geometry_b)].name);
}

}  // namespace

std::optional<SettledStart> settle_start(const Setting& setting, const Eigen::VectorXd& u_start, const EdgeSimulator& simulator,
                                         ThreadScratch& scratch, Totals& totals, PlanResult& result) {
  const Model& model = setting.model;
  const Eigen::VectorXd& q_start = setting.problem.q_start;
  const double length = model.scales().robots().length;
  SettledStart out{q_start, u_start.size() > 0 ? u_start : q_start.tail(model.n_a()), {}};
  out.u = out.u.cwiseMax(model.lower()).cwiseMin(model.upper()).eval();
  scratch.steps.forget();
  bool rests = false;
  for (int k = 0; k < kMaxSettleSteps && !rests; ++k) {
    int steps = 0;
    const Status status = dynamics::step_within_efforts(model, out.q, out.u, simulator.exact(), scratch.steps, scratch.step_result, steps);
    if (!totals.add(steps, status)) {
      result.reason = fmt::format("the start cannot be settled: step {} of the exact dynamics ends in {}{}", k + 1, core::to_string(status),
                                  deepest_pair(model, scratch.step_result));
      return std::nullopt;
    }
    const auto& r = scratch.step_result;
    if (k == 0) {
      for (const auto& c : r.contacts) result.start_penetration = std::max(result.start_penetration, -c.contact.phi);
    }
    rests = world::largest_share(model, r.delta, kSettledMove * length, kSettledTurn) < 1;
    if (rests) break;
    if (k == 0 && world::largest_share(model, r.delta, world::share::kContact * length, world::share::kContact) > 1)
      result.start_projected = true;
    out.knots.push_back({.u = out.u, .q = r.q_next, .contacts = {}});
    out.q = r.q_next;
  }
  const Eigen::VectorXd e = setting.goal.difference(q_start, out.q);
  result.start_moved = world::largest_share(model, e, 1, 1);
  if (rests || world::largest_share(model, e, kFallenMove * length, kFallenTurn) <= 1) return out;
  result.reason = fmt::format(
      "the objects do not come to rest at the start: after {} steps one has moved by {:.3g} (m or rad); "
      "is it supported?",
      kMaxSettleSteps, result.start_moved);
  return std::nullopt;
}

}  // namespace stiction::planning
