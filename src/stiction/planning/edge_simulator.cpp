#include "stiction/planning/edge_simulator.hpp"

#include <algorithm>

#include "stiction/planning/force_gap.hpp"

namespace stiction::planning {
namespace {

using core::Status;
using world::Model;

/// Penetration of an edge in a sub-step of half the length [m]; the checker allows 1 mm.
constexpr double kMaxFinePenetration = 0.95e-3;
/// A contact edge must move the robot or an object at least this far to be worth a node [m or rad].
constexpr double kMinMove = 1e-4;

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

EdgeSimulator::EdgeSimulator(const Model& model, const PlannerOptions& options, const RobotChains& chains, const ObjectSpace& space)
    : model_(model), options_(options), chains_(chains), space_(space), exact_(options.step_options()), cold_(exact_) {
  cold_.warm_start = false;
}

bool EdgeSimulator::move(const Node& from, const Eigen::VectorXd& u, ThreadScratch& scratch, Totals& totals, Node& to) const {
  if (!options_.substep) {
    scratch.steps.forget();
    const Status status = dynamics::step(model_, {from.q, u}, exact_, scratch.steps, scratch.step_result);
    ++totals.steps;
    if (status != Status::Solved) {
      ++totals.failed_steps;
      return false;
    }
    to.q = scratch.step_result.q_next;
    to.u = u;
    to.commands = u;
    to.states = to.q;
    return true;
  }
  return roll_out(from, u, *options_.substep, scratch, totals, to);
}

bool EdgeSimulator::roll_out(const Node& from, const Eigen::VectorXd& u, const dynamics::SubstepLimits& limits, ThreadScratch& scratch,
                             Totals& totals, Node& to) const {
  scratch.steps.forget();
  auto& r = scratch.rollout_result;
  const Status status = dynamics::rollout(model_, from.q, from.u, u, exact_, limits, scratch.steps, r, dynamics::Overrun::Stop);
  totals.steps += r.steps;
  if (status != Status::Solved && status != Status::MaxIterations) {
    ++totals.failed_steps;
    return false;
  }
  const bool long_slips = options_.friction_law == dynamics::FrictionLaw::Coulomb;  // along which round sides part
  const auto bad = [&](const dynamics::Knot& knot) {
    return braces(knot) || (long_slips && calc_force_gap(model_, knot, scratch.geometry) > kMostForceGap);
  };
  r.knots.erase(std::find_if(r.knots.begin(), r.knots.end(), bad), r.knots.end());
  if (r.knots.empty() || r.min_phi < -kMostEdgePenetration) return false;
  if (calc_penetration(model_, r.knots.back().q, scratch.geometry) > kMaxFinePenetration) return false;  // where no step has looked yet
  to.q = r.knots.back().q;
  to.u = r.knots.back().u;
  set_edge(r.knots, model_, to);
  return true;
}

Eigen::MatrixXd EdgeSimulator::follow_in_half_steps(Eigen::VectorXd q, Eigen::VectorXd u_last, const Eigen::MatrixXd& commands,
                                                    bool limit_gap, ThreadScratch& scratch, Totals& totals) const {
  Eigen::MatrixXd states(model_.n_q(), commands.cols());
  scratch.steps.forget();
  for (Eigen::Index k = 0; k < commands.cols(); ++k) {
    for (const double s : {0.5, 1.0}) {
      const Eigen::VectorXd u = (1 - s) * u_last + s * commands.col(k);
      ++totals.steps;
      if (dynamics::step(model_, {q, u}, cold_, scratch.steps, scratch.step_result) != Status::Solved) {
        ++totals.failed_steps;
        return states.leftCols(k);
      }
      q = scratch.step_result.q_next;
      if (!limit_gap) continue;
      if (calc_force_gap(model_, scratch.step_result, scratch.geometry) > kMostForceGap) return states.leftCols(k);
      const bool own = k > 0 || s == 1;  // what penetrates where an edge starts is not its doing
      if (own && calc_penetration(scratch.step_result) > kMaxFinePenetration) return states.leftCols(k);
    }
    states.col(k) = q;
    u_last = commands.col(k);
  }
  return states;
}

bool EdgeSimulator::moves(const Node& from, const Node& to) const {
  Eigen::VectorXd moved(model_.n_vu());
  space_.error(from.q.data(), to.q.data(), moved.data());
  return moved.cwiseAbs().maxCoeff() > kMinMove || (to.q - from.q).tail(model_.n_a()).cwiseAbs().maxCoeff() > kMinMove;
}

bool EdgeSimulator::braces(const dynamics::Knot& knot) const {
  return std::any_of(knot.contacts.begin(), knot.contacts.end(), [&](const dynamics::ContactImpulse& c) {
    const int pair = c.contact.pair;
    return chains_.mask_of_pair(pair) != 0 && !chains_.touches_object(pair) && c.lambda[0] > options_.brace_force * options_.h;
  });
}

}  // namespace stiction::planning
