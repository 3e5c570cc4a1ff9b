#include "stiction/planning/simulate.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "stiction/dynamics/disturbances.hpp"
#include "stiction/planning/contact_limits.hpp"

namespace stiction::planning {

using core::Status;

Ending Simulation::follow(std::span<const Eigen::VectorXd> commands, const Pace& pace, const Disturbance& disturbance, const Watch& watch,
                          Trace& at) {
  for (const Eigen::VectorXd& command : commands) {
    if (scratch_.stop()) return Ending::Stopped;
    const Ending ending = pace.kind == Pace::Kind::SubSteps ? roll(command, pace, watch, at) : step(command, pace, disturbance, watch, at);
    if (ending != Ending::Reached) return ending;
  }
  return Ending::Reached;
}

Ending Simulation::hold(int most, const Allowance& rest, const Pace& pace, const Disturbance& disturbance, const Watch& watch, Trace& at,
                        bool& rests) {
  rests = false;
  for (int k = 0; k < most && !rests; ++k) {
    const Eigen::VectorXd before = at.q, u = at.u;
    const Ending ending = follow(std::span(&u, 1), pace, disturbance, watch, at);
    if (ending != Ending::Reached) return ending;
    rests = setting_.goal.share(before, at.q, rest.position, rest.angle) <= 1;
  }
  return Ending::Reached;
}

bool Simulation::ends_well(const Watch& watch, Trace& at) {
  if (at.started && watch.most.penetration < kUnlimited)
    at.worst.penetration = std::max(at.worst.penetration, calc_penetration(setting_.model, at.q, scratch_.geometry));
  return at.worst.within(watch.most);
}

Ending Simulation::roll(const Eigen::VectorXd& command, const Pace& pace, const Watch& watch, Trace& at) {
  dynamics::RolloutResult& rolled = scratch_.rollout_result;
  const Status status = dynamics::rollout(setting_.model, at.q, at.u, command, pace.step, pace.limits, scratch_.steps, rolled, pace.overrun,
                                          scratch_.geometry.control);
  work_.steps += rolled.steps;
  if (scratch_.stop()) return Ending::Stopped;
  if (status != Status::Solved && status != Status::MaxIterations) {
    ++work_.failed_steps;
    return Ending::Unsolved;
  }
  at.worst.penetration = std::max(at.worst.penetration, rolled.penetration);
  if (at.worst.penetration > watch.most.penetration) return Ending::OverLimits;
  for (dynamics::Knot& knot : rolled.knots) {
    Worst worst = at.worst;
    worst.press = std::max(worst.press, setting_.press.share(knot.contacts, pace.step.h));
    if (watch.most.force_gap < kUnlimited)
      worst.force_gap = std::max(worst.force_gap, calc_force_gap(setting_.model, knot.q, knot.contacts, scratch_.geometry));
    if (!worst.within(watch.most) || (watch.brace && setting_.press.braces(knot.contacts, pace.step.h))) return Ending::OverLimits;
    if (!stays(knot.q, watch)) return Ending::Moved;
    at.worst = worst;
    at.started = true;
    at.q = knot.q;
    at.u = knot.u;
    at.knots.push_back(std::move(knot));
  }
  return status == Status::Solved ? Ending::Reached : Ending::OverLimits;
}

Ending Simulation::step(const Eigen::VectorXd& command, const Pace& pace, const Disturbance& disturbance, const Watch& watch, Trace& at) {
  const dynamics::StepResult& result = scratch_.step_result;
  const bool halves = pace.kind == Pace::Kind::HalfSteps;
  Eigen::VectorXd u;
  for (int part = halves ? 1 : 2; part <= 2; ++part) {
    u = part == 1 ? Eigen::VectorXd(0.5 * (at.u + command)) : command;
    if (!solve(at.q, u, pace, disturbance)) return Ending::Unsolved;
    if (at.started) at.worst.penetration = std::max(at.worst.penetration, calc_penetration(setting_.model, result));
    if (watch.most.force_gap < kUnlimited || halves)
      at.worst.force_gap = std::max(at.worst.force_gap, calc_force_gap(setting_.model, result.q_next, result.contacts, scratch_.geometry));
    at.worst.press = std::max(at.worst.press, setting_.press.share(result.contacts, pace.step.h));
    at.started = true;
    at.q = result.q_next;
    if (!at.worst.within(watch.most)) return Ending::OverLimits;
    if (!stays(at.q, watch)) return Ending::Moved;
  }
  at.u = u;
  at.knots.push_back({.u = at.u, .q = at.q, .contacts = {}});
  return Ending::Reached;
}

bool Simulation::solve(const Eigen::VectorXd& q, Eigen::VectorXd& u, const Pace& pace, const Disturbance& disturbance) {
  if (pace.kind == Pace::Kind::WithinEfforts) {
    int steps = 0;
    const Status status = dynamics::step_within_efforts(setting_.model, q, u, pace.step, scratch_.steps, scratch_.step_result, steps);
    return work_.add(steps, status);
  }
  Eigen::VectorXd weights;
  if (disturbance.tilt > 0) weights = dynamics::calc_weights_aside(setting_.model, q, disturbance.tilt, disturbance.side);
  const dynamics::StepInput input{q, u, disturbance.tilt > 0 ? &weights : nullptr, nullptr, disturbance.friction_factors};
  return work_.add(1, dynamics::step(setting_.model, input, pace.step, scratch_.steps, scratch_.step_result));
}

bool Simulation::stays(const Eigen::VectorXd& q, const Watch& watch) const {
  if (setting_.problem.goal.bystanders && bystander_share(setting_.model, setting_.problem.goal, q) > 1) return false;
  if (watch.places[0].q == nullptr) return true;
  return std::ranges::any_of(watch.places, [&](const Place& place) {
    return place.q != nullptr && setting_.goal.share(*place.q, q, place.within.position, place.within.angle) <= 1;
  });
}

std::vector<Eigen::VectorXd> commands_of(std::span<const dynamics::Knot> knots) {
  std::vector<Eigen::VectorXd> out;
  for (const dynamics::Knot& knot : knots) out.push_back(knot.u);
  return out;
}

std::vector<Eigen::VectorXd> commands_of(const Eigen::MatrixXd& columns) {
  std::vector<Eigen::VectorXd> out;
  for (const auto& column : columns.colwise()) out.emplace_back(column);
  return out;
}

Pace substeps(const Setting& setting) { return {Pace::Kind::SubSteps, setting.exact, setting.thresholds.substep, dynamics::Overrun::Stop}; }

Pace half_steps(const Setting& setting) {
  Pace pace{Pace::Kind::HalfSteps, setting.exact, {}, {}};
  pace.step.warm_start = false;  // as in the checker, every step depends on its state alone
  return pace;
}

void add_forces(const world::Model& model, const dynamics::StepOptions& options, Eigen::VectorXd q, Segment& segment,
                SimulationScratch& scratch, Work& work) {
  for (dynamics::Knot& knot : segment.knots) {
    knot.contacts.clear();
    if (work.add(1, dynamics::step(model, {q, knot.u}, options, scratch.steps, scratch.step_result))) {
      const auto& contacts = scratch.step_result.contacts;
      std::ranges::copy_if(contacts, std::back_inserter(knot.contacts), [](const auto& c) { return c.active; });
    }
    q = knot.q;
  }
}

}  // namespace stiction::planning
