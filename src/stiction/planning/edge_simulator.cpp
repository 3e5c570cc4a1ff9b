#include "stiction/planning/edge_simulator.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "stiction/planning/contact_limits.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;

/// A contact edge must turn the robot or an object at least this far, or move it by this of L, to be worth a node.
constexpr double kLeastTurn = 1e-4, kLeastMove = 1e-3;

}  // namespace

void set_edge(const std::vector<dynamics::Knot>& knots, const Model& model, Node& node) {
  const auto n = static_cast<Eigen::Index>(knots.size());
  node.commands.resize(model.n_a(), n);
  node.states.resize(model.n_q(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    node.commands.col(k) = knots[static_cast<std::size_t>(k)].u;
    node.states.col(k) = knots[static_cast<std::size_t>(k)].q;
  }
}

bool go_on_in_half_steps(const PressLimits& press, const Eigen::VectorXd& u, const dynamics::StepOptions& options, const Worst& allowed,
                         SimulationScratch& scratch, HalfSteps& at, Work& work) {
  const Model& model = scratch.steps.model();
  const dynamics::StepResult& step = scratch.step_result;
  for (const Eigen::VectorXd& half : {Eigen::VectorXd(0.5 * (at.u + u)), u}) {
    if (!work.add(1, dynamics::step(model, {at.q, half}, options, scratch.steps, scratch.step_result))) return false;
    if (at.started) at.worst.penetration = std::max(at.worst.penetration, calc_penetration(model, step));
    at.worst.force_gap = std::max(at.worst.force_gap, calc_force_gap(model, step.q_next, step.contacts, scratch.geometry));
    at.worst.press = std::max(at.worst.press, press.share(step.contacts, options.h));
    at.started = true;
    at.q = step.q_next;
    if (!at.worst.within(allowed)) return false;
  }
  at.u = u;
  return true;
}

bool go_on_in_half_steps(const PressLimits& press, std::span<const Segment> segments, const dynamics::StepOptions& options,
                         const Worst& allowed, const core::RunControl& control, SimulationScratch& scratch, HalfSteps& at, Work& work) {
  for (const Segment& segment : segments) {
    for (const auto& knot : segment.knots) {
      if (control.stop() || !go_on_in_half_steps(press, knot.u, options, allowed, scratch, at, work)) return false;
    }
  }
  return ends_well(scratch.steps.model(), allowed, scratch.geometry, at);
}

bool ends_well(const Model& model, const Worst& allowed, contact::GeometryWorkspace& geometry, HalfSteps& at) {
  if (at.started) at.worst.penetration = std::max(at.worst.penetration, calc_penetration(model, at.q, geometry));
  return at.worst.within(allowed);
}

void add_forces(const Model& model, const dynamics::StepOptions& options, Eigen::VectorXd q, Segment& segment, SimulationScratch& scratch,
                Work& work) {
  for (dynamics::Knot& knot : segment.knots) {
    knot.contacts.clear();
    if (work.add(1, dynamics::step(model, {q, knot.u}, options, scratch.steps, scratch.step_result))) {
      const auto& contacts = scratch.step_result.contacts;
      std::copy_if(contacts.begin(), contacts.end(), std::back_inserter(knot.contacts), [](const auto& c) { return c.active; });
    }
    q = knot.q;
  }
}

EdgeSimulator::EdgeSimulator(const Setting& setting) : setting_(setting), exact_(setting.options.step_options()), cold_(exact_) {
  cold_.warm_start = false;
}

bool EdgeSimulator::move(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const {
  scratch.steps.forget();
  return setting_.options.substep ? roll_out(from, u, scratch, totals, to) : step_once(from, u, scratch, totals, to);
}

bool EdgeSimulator::step_once(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const {
  to.u = u;
  int steps = 0;
  const Status status = dynamics::step_within_efforts(setting_.model, from.q, to.u, exact_, scratch.steps, scratch.step_result, steps);
  if (!totals.add(steps, status) || !spares(scratch.step_result.contacts)) return false;
  to.q = scratch.step_result.q_next;
  to.commands = to.u;
  to.states = to.q;
  return true;
}

bool EdgeSimulator::roll_out(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const {
  auto& r = scratch.rollout_result;
  const Status status = dynamics::rollout(setting_.model, from.q, from.u, u, exact_, *setting_.options.substep, scratch.steps, r,
                                          dynamics::Overrun::Stop, scratch.geometry.control);
  totals.steps += r.steps;
  if (scratch.stop()) return false;
  if (status != Status::Solved && status != Status::MaxIterations) {
    ++totals.failed_steps;
    return false;
  }
  const bool long_slips = setting_.options.friction_law == dynamics::FrictionLaw::Coulomb;  // along which round sides part
  const auto bad = [&](const dynamics::Knot& knot) {
    return setting_.press.braces(knot.contacts, setting_.options.h) || !spares(knot.contacts) ||
           (long_slips && calc_force_gap(setting_.model, knot.q, knot.contacts, scratch.geometry) > kMostForceGap);
  };
  r.knots.erase(std::find_if(r.knots.begin(), r.knots.end(), bad), r.knots.end());
  if (r.knots.empty() || r.penetration > kMostEdgePenetration) return false;
  if (calc_penetration(setting_.model, r.knots.back().q, scratch.geometry) > kMostFinePenetration)
    return false;  // where no step has looked yet
  to.q = r.knots.back().q;
  to.u = r.knots.back().u;
  set_edge(r.knots, setting_.model, to);
  return true;
}

Eigen::MatrixXd EdgeSimulator::follow_in_half_steps(Eigen::VectorXd q, Eigen::VectorXd u_last, const Eigen::MatrixXd& commands,
                                                    bool limit_gap, ThreadScratch& scratch, Totals& totals) const {
  const Worst allowed = limit_gap ? Worst{kMostFinePenetration, kMostForceGap, kMostPress} : kAnything;
  Eigen::MatrixXd states(setting_.model.n_q(), commands.cols());
  HalfSteps at{.q = std::move(q), .u = std::move(u_last)};
  for (Eigen::Index k = 0; k < commands.cols(); ++k) {
    if (scratch.stop() || !go_on_in_half_steps(setting_.press, commands.col(k), cold_, allowed, scratch, at, totals))
      return states.leftCols(k);
    states.col(k) = at.q;
  }
  if (!limit_gap || ends_well(setting_.model, allowed, scratch.geometry, at)) return states;
  return states.leftCols(commands.cols() - 1);
}

bool EdgeSimulator::moves(const Node& from, const Node& to) const {
  Eigen::VectorXd moved(setting_.model.n_v());
  moved << setting_.goal.difference(from.q, to.q), (to.q - from.q).tail(setting_.model.n_a());
  for (int v = 0; v < setting_.model.n_v(); ++v) {
    const world::Dof& dof = setting_.model.dofs()[static_cast<std::size_t>(v)];
    const world::Scale& scale = v < setting_.model.n_vu() ? setting_.model.scales().object(dof.owner) : setting_.model.scales().robots();
    if (std::abs(moved[v]) > (dof.kind == world::DofKind::Revolute ? kLeastTurn : kLeastMove * scale.length)) return true;
  }
  return false;
}

}  // namespace stiction::planning
