#include "stiction/planning/regrasp.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "stiction/contact/contact_sampler.hpp"
#include "stiction/contact/free_path.hpp"
#include "stiction/dynamics/disturbances.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {

bool fits_cones(const dynamics::Knot& knot, double friction_scale) {
  return std::all_of(knot.contacts.begin(), knot.contacts.end(), [&](const dynamics::ContactImpulse& c) {
    return c.lambda.tail<2>().norm() <= friction_scale * c.contact.friction * c.lambda[0];
  });
}

Outcome holds_slippery(const Setting& setting, Eigen::VectorXd q, std::span<const dynamics::Knot> knots, const dynamics::StepOptions& full,
                       SimulationScratch& scratch, Work& work) {
  const PlannerOptions& options = setting.options;
  dynamics::StepOptions slippery = full;
  slippery.friction_scale *= options.regrasp_friction;
  std::size_t k = 0;
  while (k < knots.size() && fits_cones(knots[k], slippery.friction_scale)) ++k;
  if (k > 0) q = knots[k - 1].q;
  scratch.steps.forget();
  for (; k < knots.size(); ++k) {
    if (scratch.stop()) return Outcome::Failed;
    if (!work.add(1, dynamics::step(setting.model, {q, knots[k].u}, slippery, scratch.steps, scratch.step_result))) return Outcome::Failed;
    q = scratch.step_result.q_next;
    if (setting.goal.share(knots[k].q, q, options.regrasp_tol_position, options.regrasp_tol_angle) > 1) return Outcome::Moved;
  }
  return Outcome::Held;
}

namespace {

using core::Status;
using Posture = Eigen::VectorXd;

/// How far an object may be from where it should be.
struct Allowance {
  double position;  ///< [m]
  double angle;     ///< [rad]
};

/// Simulates the commands of a regrasp and watches the object.
class RegraspRun {
 public:
  RegraspRun(const Setting& setting, const Eigen::VectorXd& q0, const Eigen::VectorXd& u0, SimulationScratch& scratch, Regrasp& out)
      : q(q0), u(u0), setting_(setting), options_(setting.options), scratch_(scratch), q0_(q0), q_rest_(q0), out_(out) {
    out_.knots.clear();
    scratch_.steps.forget();
  }

  Eigen::VectorXd q, u;  ///< state and command reached

  /// Moves the command to u_next while the object is let go of.
  Outcome release(const Eigen::VectorXd& u_next) { return follow(u_next, {options_.release_tol_position, options_.release_tol_angle}); }

  /// Holds the command until the object rests; what follows is judged against where that is.
  Outcome settle() {
    bool rests = false;
    const Outcome outcome = hold({options_.release_tol_position, options_.release_tol_angle}, rests);
    if (outcome == Outcome::Held) q_rest_ = q;
    return outcome;
  }

  /// Holds the command until the object rests in the new grip: Moved where it slides out of it.
  Outcome keep() {
    bool rests = false;
    const Outcome outcome = hold({options_.regrasp_tol_position, options_.regrasp_tol_angle}, rests);
    return outcome == Outcome::Held && !rests ? Outcome::Moved : outcome;
  }

  /// The objects stay where they rest with gravity aside, from four sides.
  bool stays_with_gravity_aside() {
    bool stays = true;
    for (int draw = 0; draw < dynamics::kDisturbances && stays; ++draw) stays = stays_with_gravity_aside(draw);
    scratch_.steps.forget();
    return stays;
  }

  /// Moves the command to u_next while the object rests.
  Outcome move(const Eigen::VectorXd& u_next) { return follow(u_next, {options_.regrasp_tol_position, options_.regrasp_tol_angle}); }

  Outcome follow_slippery() { return holds_slippery(setting_, q0_, out_.knots, step_, scratch_, out_); }

 private:
  bool stays_with_gravity_aside(int draw) {
    Eigen::VectorXd q_aside = q;
    bool rests = false;
    scratch_.steps.forget();
    for (int k = 0; k < kMostHeld && !rests; ++k) {
      const Eigen::VectorXd aside = dynamics::calc_weights_aside(setting_.model, q_aside, kAside, draw);
      const dynamics::StepInput input{q_aside, u, &aside};
      if (!out_.add(1, dynamics::step(setting_.model, input, step_, scratch_.steps, scratch_.step_result))) return false;
      rests = rest(q_aside, scratch_.step_result.q_next);
      q_aside = scratch_.step_result.q_next;
      if (setting_.goal.share(q, q_aside, options_.regrasp_tol_position, options_.regrasp_tol_angle) > 1) return false;
    }
    return true;
  }

  /// The objects, from one step to the next.
  bool rest(const Eigen::VectorXd& before, const Eigen::VectorXd& after) const {
    return setting_.goal.share(before, after, kRestingMove * setting_.model.scales().robots().length, kRestingTurn) <= 1;
  }

  /// Holds the command for up to kMostHeld steps, or until the object rests.
  Outcome hold(const Allowance& allowance, bool& rests) {
    for (int k = 0; k < kMostHeld && !rests; ++k) {
      const Eigen::VectorXd before = q;
      const Outcome outcome = follow(u, allowance);
      if (outcome != Outcome::Held) return outcome;
      rests = rest(before, q);
    }
    return Outcome::Held;
  }

  /// At full friction; appends the knots. While the object rests it is judged against the place where it came to rest, else against the
  /// start.
  Outcome follow(const Eigen::VectorXd& u_next, const Allowance& allowance) {
    auto& rolled = scratch_.rollout_result;
    const Status status = dynamics::rollout(setting_.model, q, u, u_next, step_, *options_.substep, scratch_.steps, rolled,
                                            dynamics::Overrun::Accept, scratch_.geometry.control);
    if (!out_.add(rolled.steps, status)) return Outcome::Failed;
    for (const auto& knot : rolled.knots) {
      if (setting_.goal.share(q_rest_, knot.q, allowance.position, allowance.angle) > 1) return Outcome::Moved;
      if (setting_.press.share(knot.contacts, step_.h) > kMostPress) return Outcome::Moved;
    }
    if (rolled.max_slide > options_.substep->slide) return Outcome::Moved;
    q = rolled.knots.back().q;
    u = rolled.knots.back().u;
    out_.knots.insert(out_.knots.end(), std::make_move_iterator(rolled.knots.begin()), std::make_move_iterator(rolled.knots.end()));
    return Outcome::Held;
  }

  const Setting& setting_;
  const PlannerOptions& options_;
  SimulationScratch& scratch_;
  const Eigen::VectorXd& q0_;
  Eigen::VectorXd q_rest_;
  Regrasp& out_;
  const dynamics::StepOptions step_ = options_.step_options();
};

/// The command u with the joints of the branches in `moving` at a posture.
Eigen::VectorXd command_of(const world::RobotChains& chains, world::ChainMask moving, const Posture& posture, Eigen::VectorXd u) {
  for (const int j : chains.joints_of(moving)) u[j] = posture[j];
  return u;
}

/// The branches in `relaxed` stop pushing, those in `moving` back off, and the object settles: Moved where it goes too far, or after
/// them so that they would touch it on their way. False in `clear` when they cannot back off.
Outcome let_go(const Setting& setting, world::ChainMask relaxed, world::ChainMask moving, contact::GeometryWorkspace& geometry,
               RegraspRun& run, bool& clear) {
  const world::Model& model = setting.model;
  const double clearance = setting.options.regrasp_clearance;
  clear = true;
  // Springs of branches that stop pushing are unloaded, the others keep their grip.
  Outcome outcome = run.release(command_of(setting.chains, relaxed, run.q.tail(model.n_a()), run.u));
  if (outcome != Outcome::Held) return outcome;
  std::vector<Posture> path;
  Eigen::VectorXd q_clear = run.q;
  clear = contact::retreat(model, setting.chains, moving, clearance, q_clear, geometry, path);
  if (!clear) return Outcome::Moved;
  for (const auto& posture : path) {
    outcome = run.release(command_of(setting.chains, moving, posture, run.u));
    if (outcome != Outcome::Held) return outcome;
  }
  outcome = run.settle();
  if (outcome != Outcome::Held) return outcome;
  setting.chains.pairs_of(moving, geometry.pairs);
  world::calc_kinematics(model, run.q, geometry.kinematics_work, geometry.kinematics);
  const bool touched = contact::any_nearer(model, geometry.kinematics, geometry.pairs, 0.5 * clearance, geometry.contact_work);
  return touched ? Outcome::Moved : Outcome::Held;
}

/// A posture to grasp with.
struct Candidate {
  Promise promise;
  Posture q_a;
};

/// Best first. Of those that promise most, some become what the simulation says: a local model sees forces across gaps that the exact dynamics does not make.
std::vector<Candidate> draw_candidates(const Setting& setting, world::ChainMask draw, Eigen::VectorXd q, const GraspJudge& judge,
                                       core::Random& random, contact::GeometryWorkspace& geometry) {
  const PlannerOptions& options = setting.options;
  std::vector<Candidate> out;
  const Eigen::VectorXd q_before = q;
  for (int k = 0; k < options.grasp_candidates && !geometry.stop(); ++k) {
    const auto sample = contact::sample_contact(setting.model, setting.chains, options.sampler, draw, q_before, random, geometry);
    if (!sample) continue;
    q.tail(sample->q_a.size()) = sample->q_a;
    out.push_back({judge.promise ? judge.promise(q) : Promise{}, sample->q_a});
  }
  const auto sort = [&](std::size_t n) {
    std::stable_sort(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(n),
                     [](const Candidate& a, const Candidate& b) { return a.promise.distance < b.promise.distance; });
  };
  sort(out.size());
  if (!judge.simulated) return out;
  const std::size_t trials = std::min(static_cast<std::size_t>(options.grasp_trials), out.size());
  for (Candidate& candidate : std::span(out).first(trials)) {
    q.tail(candidate.q_a.size()) = candidate.q_a;
    candidate.promise.distance = judge.simulated(q, candidate.promise.command);
  }
  sort(trials);
  return out;
}

}  // namespace

bool is_free_on_its_way(const world::Model& model, const world::RobotChains& chains, const std::vector<dynamics::Knot>& knots,
                        contact::GeometryWorkspace& work) {
  constexpr double kElsewhere = 0.1;  // [rad, L]
  const double free = world::share::kContact * model.scales().robots().length;
  const double touching = 0.1 * free;  // what is pushed away keeps a gap of some micrometres
  for (int c = 0; c < chains.size(); ++c) {
    double excursion = 0;
    for (const auto& knot : knots) {
      for (const int j : chains.joints(c))
        excursion = std::max(excursion, std::abs((knot.q - knots.front().q)[model.n_qu() + j]) / model.scales().joint(j));
    }
    if (excursion < kElsewhere) continue;
    bool was_free = false, touched = false;
    for (const auto& knot : knots) {
      world::calc_kinematics(model, knot.q, work.kinematics_work, work.kinematics);
      const double gap = contact::calc_min_distance(model, work.kinematics, chains.pairs_against(c),
                                                    -std::numeric_limits<double>::infinity(), work.contact_work);
      if (gap >= free && touched) return false;
      was_free = was_free || gap >= free;
      touched = touched || (was_free && gap <= touching);
    }
    if (!was_free) return false;
  }
  return true;
}

bool try_regrasp(const Setting& setting, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Release& release,
                 const GraspJudge& judge, core::Random& random, SimulationScratch& scratch, Regrasp& out, RegraspCounts& counts) {
  const world::Model& model = setting.model;
  const world::RobotChains& chains = setting.chains;
  contact::GeometryWorkspace& geometry = scratch.geometry;
  static_cast<Work&>(out) = {};
  out.stuck = true;
  out.loose = false;
  ++counts.tried;
  const world::ChainMask moved = release.moved;
  if (moved == 0) {
    ++counts.no_sample;
    return false;
  }
  const auto count_failure = [&](Outcome outcome) {
    ++(outcome == Outcome::Failed ? counts.failed_step : counts.object_moved);
    return false;
  };

  // First with the grip of the branches that hold, then with everything let go.
  std::optional<RegraspRun> run;
  contact::PathOptions path_options;
  path_options.clearance = setting.options.regrasp_clearance;
  Outcome outcome = Outcome::Moved;
  for (const world::ChainMask relaxed : {moved, chains.all()}) {
    run.emplace(setting, q, u, scratch, out);
    bool clear = false;
    outcome = let_go(setting, relaxed, moved, geometry, *run, clear);
    if (!clear) {
      ++counts.no_path;
      return false;
    }
    if (outcome == Outcome::Held || relaxed == chains.all()) break;
  }
  if (outcome != Outcome::Held) return count_failure(outcome);
  out.stuck = false;
  out.loose = !run->stays_with_gravity_aside();
  if (out.loose && !release.loose) return count_failure(Outcome::Moved);

  const auto candidates = draw_candidates(setting, moved, run->q, judge, random, geometry);
  if (candidates.empty()) {
    ++counts.no_sample;
    return false;
  }
  std::vector<Posture> path;
  const bool found = std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
    return contact::find_path(model, chains, moved, run->q, candidate.q_a, path_options, random, geometry, path) ==
           contact::PathOutcome::Found;
  });
  if (!found) {
    ++counts.no_path;
    return false;
  }
  for (const auto& posture : path) {  // commands: the moving joints follow the path, the others hold
    outcome = run->move(command_of(chains, moved, posture, run->u));
    if (outcome != Outcome::Held) return count_failure(outcome);
  }
  outcome = run->keep();
  if (outcome != Outcome::Held) return count_failure(outcome);
  if (!is_free_on_its_way(model, chains, out.knots, geometry)) {
    ++counts.no_path;
    return false;
  }
  outcome = run->follow_slippery();
  if (outcome != Outcome::Held) return count_failure(outcome);
  ++counts.accepted;
  return true;
}

}  // namespace stiction::planning
