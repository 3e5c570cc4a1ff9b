#include "stiction/planning/regrasp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "stiction/contact/clearance.hpp"
#include "stiction/contact/contact_sampler.hpp"
#include "stiction/contact/free_path.hpp"
#include "stiction/dynamics/disturbances.hpp"
#include "stiction/planning/contact_limits.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using Posture = Eigen::VectorXd;

/// The command u, with the joints of the branches in `moving` at a posture.
Eigen::VectorXd command_of(const world::RobotChains& chains, world::ChainMask moving, const Posture& posture, Eigen::VectorXd u) {
  for (const int j : chains.joints_of(moving)) u[j] = posture[j];
  return u;
}

}  // namespace

bool is_free_on_its_way(const world::Model& model, const world::RobotChains& chains, const std::vector<dynamics::Knot>& knots,
                        contact::GeometryWorkspace& work) {
  constexpr double kElsewhere = 0.1;  // [rad, L]
  const double free = world::share::kContact * model.scales().robots().length;
  const double touching = 0.1 * free;  // an object that is pushed away keeps a gap of some micrometres
  for (int c = 0; c < chains.size(); ++c) {
    double excursion = 0;
    for (const auto& knot : knots) {
      for (const int j : chains.joints(c))
        excursion = std::max(excursion, std::abs((knot.q - knots.front().q)[model.n_qu() + j]) / model.scales().joint(j));
    }
    if (excursion < kElsewhere) continue;
    const auto pairs = contact::split_by_clearance(model, chains.pairs_against(c), free, work.contact_work).pairs;
    bool was_free = false, touched = false;
    for (const auto& knot : knots) {
      world::calc_kinematics(model, knot.q, work.kinematics_work, work.kinematics);
      const double gap =
          contact::calc_min_distance(model, work.kinematics, pairs, -std::numeric_limits<double>::infinity(), work.contact_work);
      if (gap >= free && touched) return false;
      was_free = was_free || gap >= free;
      touched = touched || (was_free && gap <= touching);
    }
    if (!was_free) return false;
  }
  return true;
}

// ---- RegraspSimulation

RegraspSimulation::RegraspSimulation(const Setting& setting, const RegraspSizes& sizes, const Eigen::VectorXd& q, const Eigen::VectorXd& u,
                                     SimulationScratch& scratch, Work& work)
    : setting_(setting), sizes_(sizes), scratch_(scratch), simulation_(setting, scratch, work), q_rest_(q), at_{.q = q, .u = u} {
  scratch_.steps.forget();
}

Ending RegraspSimulation::let_go(const Eigen::VectorXd& u_kept, world::ChainMask unloaded, world::ChainMask moving, bool& clear) {
  const ProfileClock::Scope scope(scratch_.profile, Activity::LettingGo);
  const world::Model& model = setting_.model;
  const Allowance& allowance = setting_.thresholds.release;
  contact::GeometryWorkspace& geometry = scratch_.geometry;
  clear = true;
  Ending ending = move(command_of(setting_.chains, unloaded, at_.q.tail(model.n_a()), u_kept), sizes_.pace.limits, allowance);
  if (ending != Ending::Reached || moving == 0) return ending;
  std::vector<Posture> path;
  Eigen::VectorXd q_clear = at_.q;
  clear = contact::retreat(model, setting_.chains, moving, sizes_.clearance, q_clear, geometry, path);
  if (!clear) return Ending::Moved;
  for (const Posture& posture : path) {
    ending = move(command_of(setting_.chains, moving, posture, at_.u), sizes_.pace.limits, allowance);
    if (ending != Ending::Reached) return ending;
  }
  bool rests = false;
  ending = simulation_.hold(threshold::kMostHeld * sizes_.cuts, rest(), sizes_.pace, {}, watch(allowance), at_, rests);
  if (ending != Ending::Reached) return ending;
  q_rest_ = at_.q;
  return is_clear(moving, at_.q.tail(model.n_a())) ? Ending::Reached : Ending::Moved;
}

bool RegraspSimulation::is_stable() {
  const ProfileClock::Scope scope(scratch_.profile, Activity::Stability);
  Pace steps = sizes_.pace;
  steps.kind = Pace::Kind::Steps;
  const Watch stays{.places = {{{&at_.q, setting_.thresholds.regrasp}, {}}}};
  bool stable = true;
  for (int side = 0; side < dynamics::kDisturbances && stable; ++side) {
    Trace aside{.q = at_.q, .u = at_.u};
    bool rests = false;
    scratch_.steps.forget();
    const Disturbance tilt{nullptr, threshold::kReleaseTilt, side};
    stable = simulation_.hold(threshold::kMostHeld * sizes_.cuts, rest(), steps, tilt, stays, aside, rests) == Ending::Reached && rests;
  }
  scratch_.steps.forget();
  return stable;
}

bool RegraspSimulation::find_path(world::ChainMask moving, const Posture& posture, core::Random& random, std::vector<Posture>& path) {
  const ProfileClock::Scope scope(scratch_.profile, Activity::Paths);
  const contact::PathOptions options{.clearance = sizes_.clearance};
  return contact::find_path(setting_.model, setting_.chains, moving, at_.q, posture, options, random, scratch_.geometry, path) ==
         contact::PathOutcome::Found;
}

Ending RegraspSimulation::go(world::ChainMask moving, const std::vector<Posture>& path, const Eigen::VectorXd& u_end) {
  const ProfileClock::Scope scope(scratch_.profile, Activity::Grasping);
  bool was_clear = false;
  for (std::size_t k = 0; k < path.size(); ++k) {
    const bool clear = sizes_.free_limits && is_clear(moving, path[k]);
    const dynamics::SubstepLimits& limits = was_clear && clear ? *sizes_.free_limits : sizes_.pace.limits;
    const Posture& posture = k + 1 == path.size() ? u_end : path[k];
    const Ending ending = move(command_of(setting_.chains, moving, posture, at_.u), limits, setting_.thresholds.regrasp);
    if (ending != Ending::Reached) return ending;
    was_clear = clear;
  }
  return hold();
}

Ending RegraspSimulation::hold() {
  bool rests = false;
  const Ending ending =
      simulation_.hold(threshold::kMostHeld * sizes_.cuts, rest(), sizes_.pace, {}, watch(setting_.thresholds.regrasp), at_, rests);
  return ending == Ending::Reached && !rests ? Ending::Moved : ending;
}

Ending RegraspSimulation::move(const Eigen::VectorXd& u, const dynamics::SubstepLimits& limits, const Allowance& allowance) {
  Pace pace = sizes_.pace;
  pace.limits = limits;
  return simulation_.follow(u, pace, watch(allowance), at_);
}

Watch RegraspSimulation::watch(const Allowance& allowance) const {
  return {.most = sizes_.most, .places = {{{&q_rest_, allowance}, sizes_.also}}};
}

bool RegraspSimulation::is_clear(world::ChainMask moving, const Posture& q_a) {
  Eigen::VectorXd q = at_.q;
  q.tail(setting_.model.n_a()) = q_a;
  contact::GeometryWorkspace& geometry = scratch_.geometry;
  setting_.chains.pairs_of(moving, geometry.pairs);
  world::calc_kinematics(setting_.model, q, geometry.kinematics_work, geometry.kinematics);
  const auto pairs = contact::split_by_clearance(setting_.model, geometry.pairs, sizes_.clearance, geometry.contact_work);
  return !contact::any_too_near(setting_.model, geometry.kinematics, pairs, 0.5, geometry.contact_work);
}

Allowance RegraspSimulation::rest() const {
  return {setting_.thresholds.rest.position / sizes_.cuts, setting_.thresholds.rest.angle / sizes_.cuts};
}

// ---- the tree's regrasps

namespace {

/// A posture for a new grasp.
struct Candidate {
  Promise promise;
  Posture q_a;
  Eigen::VectorXd u;  // command with which the posture holds
};

/// Draws postures, best first. The most promising ones are simulated: local models see forces across gaps that exact steps do not make.
std::vector<Candidate> draw_candidates(const Setting& setting, world::ChainMask draw, Eigen::VectorXd q, const GraspJudge& judge,
                                       core::Random& random, SimulationScratch& scratch) {
  const ProfileClock::Scope scope(scratch.profile, Activity::GraspSamples);
  contact::GeometryWorkspace& geometry = scratch.geometry;
  const bool choose = judge.choose && setting.options.uses(Mechanism::GraspChoice);
  std::vector<Candidate> out;
  const Eigen::VectorXd q_before = q;
  for (int k = 0; k < (choose ? threshold::kCandidates : 1) && !geometry.stop(); ++k) {
    const auto sample = contact::sample_contact(setting.model, setting.chains, judge.sampler, draw, q_before, random, geometry);
    if (!sample) continue;
    q.tail(sample->q_a.size()) = sample->q_a;
    out.push_back({judge.promise ? judge.promise(q, sample->u) : Promise{}, sample->q_a, sample->u});
  }
  const auto sort = [&](std::size_t n) {
    std::stable_sort(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(n),
                     [](const Candidate& a, const Candidate& b) { return a.promise.distance < b.promise.distance; });
  };
  sort(out.size());
  if (!judge.simulated || !choose) return out;
  const std::size_t trials = std::min(static_cast<std::size_t>(threshold::kTrials), out.size());
  // Half of the simulated postures are grips, if there are any: a local model says little about the use of a grip.
  std::size_t grips = 0;
  std::stable_partition(out.begin(), out.end(),
                        [&](const Candidate& candidate) { return candidate.u != candidate.q_a && grips < trials / 2 && ++grips > 0; });
  for (Candidate& candidate : std::span(out).first(trials)) {
    q.tail(candidate.q_a.size()) = candidate.q_a;
    candidate.promise.distance = judge.simulated(q, candidate.u, candidate.promise.command);
  }
  sort(trials);
  return out;
}

/// Counts a failure by its cause. @returns false
bool count_failure(Ending ending, RegraspCounts& counts) {
  ++(ending == Ending::Unsolved || ending == Ending::Stopped ? counts.failed_step : counts.object_moved);
  return false;
}

/// Releases the branches in `moved` while the others keep their grip, or if that fails with all branches relaxed.
/// @returns nothing if the branches cannot let go; the cause is counted
std::optional<RegraspSimulation> let_go(const Setting& setting, const RegraspSizes& sizes, const Eigen::VectorXd& q,
                                        const Eigen::VectorXd& u, world::ChainMask moved, SimulationScratch& scratch, Work& work,
                                        RegraspCounts& counts) {
  std::optional<RegraspSimulation> run;
  Ending ending = Ending::Moved;
  for (const world::ChainMask unloaded : {moved, setting.chains.all()}) {
    run.emplace(setting, sizes, q, u, scratch, work);
    bool clear = false;
    ending = run->let_go(u, unloaded, moved, clear);
    if (!clear) {
      ++counts.no_path;
      return std::nullopt;
    }
    if (ending == Ending::Reached) return run;
    if (unloaded == setting.chains.all()) break;
  }
  count_failure(ending, counts);
  return std::nullopt;
}

}  // namespace

bool try_regrasp(const Setting& setting, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Release& release,
                 const GraspJudge& judge, core::Random& random, SimulationScratch& scratch, Regrasp& out, RegraspCounts& counts) {
  static_cast<Work&>(out) = {};
  out.unstable = false;
  out.knots.clear();
  ++counts.tried;
  if (release.moved == 0) {
    ++counts.no_sample;
    return false;
  }
  const RegraspSizes sizes{
      .pace = substeps(setting), .clearance = setting.thresholds.clearance, .most = {kUnlimited, kUnlimited, kMostPress}};
  auto run = let_go(setting, sizes, q, u, release.moved, scratch, out, counts);
  if (!run) return false;
  out.unstable = setting.options.uses(Mechanism::StableReleases) && !run->is_stable();
  if (out.unstable && !release.may_be_unstable) {
    ++counts.unstable;
    return count_failure(Ending::Moved, counts);
  }

  const auto candidates = draw_candidates(setting, release.moved, run->at().q, judge, random, scratch);
  if (candidates.empty()) {
    ++counts.no_sample;
    return false;
  }
  std::vector<Posture> path;
  const auto reachable = std::ranges::find_if(
      candidates, [&](const Candidate& candidate) { return run->find_path(release.moved, candidate.q_a, random, path); });
  if (reachable == candidates.end()) {
    ++counts.no_path;
    return false;
  }
  const Ending ending = run->go(release.moved, path, reachable->u);
  if (ending != Ending::Reached) return count_failure(ending, counts);
  if (!run->is_free_on_its_way()) {
    ++counts.no_path;
    return false;
  }
  const bool deep = std::ranges::any_of(run->knots(), [&](const dynamics::Knot& knot) {
    return calc_penetration(setting.model, knot.q, scratch.geometry) > kMostFinePenetration;
  });
  if (deep) return count_failure(Ending::OverLimits, counts);
  out.knots = std::move(run->knots());
  ++counts.accepted;
  return true;
}

}  // namespace stiction::planning
