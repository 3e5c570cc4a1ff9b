#include "stiction/execution/touch/move_parts.hpp"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>

#include "stiction/execution/touch/feeler.hpp"

namespace stiction::execution {

double MoveProfile::at(double t) const {
  const double T = duration();
  if (t >= T) return length_;
  if (t < kRamp) return 0.5 * speed_ * t * t / kRamp;
  if (t > T - kRamp) return length_ - 0.5 * speed_ * (T - t) * (T - t) / kRamp;
  return speed_ * (t - 0.5 * kRamp);
}

namespace {

/// Largest force that a move asks for; infinite if none asks for a force.
double find_largest_force(const std::vector<GuardedMove>& moves) {
  double out = 0;
  for (const GuardedMove& move : moves) {
    if (move.until) out = std::max(out, move.until->force);
    if (move.press) out = std::max(out, move.press->force);
  }
  return out > 0 ? out : std::numeric_limits<double>::infinity();
}

}  // namespace

ControlScenario make_guarded_arm(const TouchScenario& scenario, const GuardedRunResult& run, std::uint64_t seed) {
  ControlScenario out = scenario.arm;
  if (out.objects.size() > 0) move_objects(scenario, *out.model, *run.world, out.objects);
  if (run.friction) {
    out.observer.coulomb = run.friction->coulomb, out.observer.viscous = run.friction->viscous;
    out.observer.stiction_speed = run.friction->stiction_speed;
    out.estimator.friction = run.friction->coulomb.cwiseAbs();
    // No contact presses harder than this for long, so noise of joints that stick is not taken for a touch near an axis.
    out.estimator.plausible_force = std::min(out.estimator.plausible_force, kPlausible * find_largest_force(scenario.moves));
  }
  out.observer.seed = seed;
  out.demand = 0.125;  // the lead (G.5) limits the force itself, so damping within the lag of the estimates is enough
  return out;
}

bool tick_arm(const Eigen::VectorXd& reference, const core::RunControl& control, ControlLoop& loop, std::vector<ControlSample>& samples,
              Eigen::VectorXd& q, core::Status& go_on) {
  if (control.cancelled()) go_on = core::Status::Cancelled;
  if (control.expired()) go_on = core::Status::MaxIterations;
  if (go_on != core::Status::Solved) return false;
  ControlSample& sample = samples.emplace_back();
  go_on = loop.tick(reference, sample);
  q = sample.q;
  return true;
}

core::Status carry_out_moves(const TouchScenario& scenario, const ControlScenario& arm, double settle, ControlLoop& loop,
                             const core::Status& go_on, const std::function<void(const GuardedMove&, MoveResult&)>& carry_out,
                             GuardedRunResult& out) {
  out.reached = true;
  for (const GuardedMove& move : scenario.moves) {
    MoveResult& result = out.moves.emplace_back();
    const std::size_t first = out.run.samples.size();
    result.name = move.name, result.begin = loop.time();
    carry_out(move, result);
    result.end = loop.time();
    judge_move(out.run.samples, first, result);
    if (go_on == core::Status::Solved && result.reason.empty()) continue;
    out.reached = false;
    out.reason = go_on == core::Status::NumericalFailure ? loop.message() : fmt::format("{}: {}", move.name, result.reason);
    break;
  }
  summarise(arm, loop, settle, out.run);
  out.q = loop.q();
  return out.status = out.run.status = go_on;
}

std::optional<FeltContact> describe_touch(Feeler& feeler, const Eigen::VectorXd& q, const std::vector<int>& links, double time) {
  const sensing::SenseResult& sensed = feeler.identify(q);
  const std::vector<double>& probable = sensed.posterior.links;
  std::vector<int> order(probable.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::greater<>(), [&](int link) { return probable[static_cast<std::size_t>(link)]; });
  for (const int link : order) {
    if (probable[static_cast<std::size_t>(link)] < kDoubt) break;
    const int body = feeler.sensor().links()[static_cast<std::size_t>(link)].surface.body;
    if (!links.empty() && std::find(links.begin(), links.end(), body) == links.end()) continue;
    FeltContact out;
    out.time = time, out.body = body;
    out.probability = sensed.posterior.links[static_cast<std::size_t>(link)];
    for (const sensing::Candidate& candidate : sensed.candidates) {
      if (candidate.best.link != link) continue;
      out.p_W = candidate.p_W, out.direction_W = candidate.f_W.normalized(), out.force = candidate.f_W.norm();
      return out;
    }
    return std::nullopt;  // no point of this link explains the torques
  }
  return std::nullopt;
}

void judge_move(const std::vector<ControlSample>& samples, std::size_t first, MoveResult& out) {
  std::map<int, double> since;  // begin of contact for each pair
  out.contact = out.end;
  double sum = 0;
  int late = 0;
  for (std::size_t k = first; k < samples.size(); ++k) {
    const ControlSample& sample = samples[k];
    for (const simulation::PairForce& f : sample.forces) {
      const double force = f.force_W.norm(), made = since.try_emplace(f.pair, sample.time).first->second;
      out.contact = std::min(out.contact, made);
      out.peak = std::max(out.peak, force);
      if (sample.time >= made + kImpact) out.late_peak = std::max(out.late_peak, force);
    }
    if (sample.time >= out.end - kImpact) sum += sample.largest_force, ++late;
  }
  out.last_force = late > 0 ? sum / late : 0;
}

}  // namespace stiction::execution
