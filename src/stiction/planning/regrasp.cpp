#include "stiction/planning/regrasp.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "stiction/contact/free_path.hpp"
#include "stiction/planning/press_limits.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {

bool fits_cones(const dynamics::Knot& knot, double friction_scale) {
  return std::all_of(knot.contacts.begin(), knot.contacts.end(), [&](const dynamics::ContactImpulse& c) {
    return c.lambda.tail<2>().norm() <= friction_scale * c.contact.friction * c.lambda[0];
  });
}

Outcome holds_slippery(const world::Model& model, const world::ObjectSpace& space, const PlannerOptions& options, Eigen::VectorXd q,
                       std::span<const dynamics::Knot> knots, const dynamics::StepOptions& full, dynamics::StepWorkspace& steps,
                       dynamics::StepResult& step, const core::RunControl* control, Work& work) {
  dynamics::StepOptions slippery = full;
  slippery.friction_scale *= options.regrasp_friction;
  std::size_t k = 0;
  while (k < knots.size() && fits_cones(knots[k], slippery.friction_scale)) ++k;
  if (k > 0) q = knots[k - 1].q;
  steps.forget();
  for (; k < knots.size(); ++k) {
    if (control != nullptr && control->stop()) return Outcome::Failed;
    ++work.steps;
    if (dynamics::step(model, {q, knots[k].u}, slippery, steps, step) != core::Status::Solved) {
      ++work.failed_steps;
      return Outcome::Failed;
    }
    q = step.q_next;
    if (!world::objects_agree(model, space, knots[k].q, q, options.regrasp_tol_position, options.regrasp_tol_angle)) return Outcome::Moved;
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
  RegraspRun(const world::Model& model, const world::RobotChains& chains, const PlannerOptions& options, const Eigen::VectorXd& q0,
             const Eigen::VectorXd& u0, dynamics::StepWorkspace& steps, const core::RunControl* control, Regrasp& out)
      : q(q0),
        u(u0),
        model_(model),
        options_(options),
        press_(model, chains, options.brace_force),
        steps_(steps),
        control_(control),
        space_(model),
        q0_(q0),
        q_rest_(q0),
        out_(out) {
    step_ = options.step_options();
    out_.knots.clear();
    steps_.forget();
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

  /// Moves the command to u_next while the object rests.
  Outcome move(const Eigen::VectorXd& u_next) { return follow(u_next, {options_.regrasp_tol_position, options_.regrasp_tol_angle}); }

  Outcome follow_slippery() {
    return holds_slippery(model_, space_, options_, q0_, out_.knots, step_, steps_, step_result_, control_, out_);
  }

 private:
  /// Holds the command for up to kMostHeld steps, or until the object rests.
  Outcome hold(const Allowance& allowance, bool& rests) {
    for (int k = 0; k < kMostHeld && !rests; ++k) {
      const Eigen::VectorXd before = q;
      const Outcome outcome = follow(u, allowance);
      if (outcome != Outcome::Held) return outcome;
      rests = world::objects_agree(model_, space_, before, q, kRestingMove * model_.scales().robots().length, kRestingTurn);
    }
    return Outcome::Held;
  }

  /// At full friction; appends the knots. While the object rests it is judged against the place where it came to rest, else against the
  /// start.
  Outcome follow(const Eigen::VectorXd& u_next, const Allowance& allowance) {
    const Status status =
        dynamics::rollout(model_, q, u, u_next, step_, *options_.substep, steps_, result_, dynamics::Overrun::Accept, control_);
    out_.steps += result_.steps;
    if (status != Status::Solved) {
      ++out_.failed_steps;
      return Outcome::Failed;
    }
    for (const auto& knot : result_.knots) {
      if (!world::objects_agree(model_, space_, q_rest_, knot.q, allowance.position, allowance.angle)) return Outcome::Moved;
    }
    for (const auto& knot : result_.knots) {
      if (press_.share(knot.contacts, step_.h) > kMostPress) return Outcome::Moved;
    }
    if (result_.max_slide > options_.substep->slide) return Outcome::Moved;
    q = result_.knots.back().q;
    u = result_.knots.back().u;
    out_.knots.insert(out_.knots.end(), std::make_move_iterator(result_.knots.begin()), std::make_move_iterator(result_.knots.end()));
    return Outcome::Held;
  }

  const world::Model& model_;
  const PlannerOptions& options_;
  PressLimits press_;
  dynamics::StepWorkspace& steps_;
  const core::RunControl* control_;
  world::ObjectSpace space_;
  const Eigen::VectorXd& q0_;
  Eigen::VectorXd q_rest_;
  Regrasp& out_;
  dynamics::StepOptions step_;
  dynamics::RolloutResult result_;
  dynamics::StepResult step_result_;
};

/// Command with which the branches in `relaxed` stop pushing: their springs are unloaded, the others keep their grip.
Eigen::VectorXd relaxed_command(const world::Model& model, const world::RobotChains& chains, world::ChainMask relaxed,
                                const Eigen::VectorXd& q, Eigen::VectorXd u) {
  for (const int j : chains.joints_of(relaxed)) u[j] = q[model.n_qu() + j];
  return u;
}

/// The command u with the joints of the branches in `moving` at a posture.
Eigen::VectorXd command_of(const world::RobotChains& chains, world::ChainMask moving, const Posture& posture, Eigen::VectorXd u) {
  for (const int j : chains.joints_of(moving)) u[j] = posture[j];
  return u;
}

/// The branches in `relaxed` stop pushing, those in `moving` back off, and the object settles: Moved where it goes too far, or after
/// them so that they would touch it on their way. False in `clear` when they cannot back off.
Outcome let_go(const world::Model& model, const world::RobotChains& chains, world::ChainMask relaxed, world::ChainMask moving,
               double clearance, contact::GeometryWorkspace& geometry, RegraspRun& run, bool& clear) {
  Outcome outcome = run.release(relaxed_command(model, chains, relaxed, run.q, run.u));
  clear = true;
  if (outcome != Outcome::Held) return outcome;
  std::vector<Posture> path;
  Eigen::VectorXd q_clear = run.q;
  clear = contact::retreat(model, chains, moving, clearance, q_clear, geometry, path);
  if (!clear) return Outcome::Moved;
  for (const auto& posture : path) {
    outcome = run.release(command_of(chains, moving, posture, run.u));
    if (outcome != Outcome::Held) return outcome;
  }
  outcome = run.settle();
  if (outcome != Outcome::Held) return outcome;
  chains.pairs_of(moving, geometry.pairs);
  world::calc_kinematics(model, run.q, geometry.kinematics_work, geometry.kinematics);
  const bool touched = contact::any_nearer(model, geometry.kinematics, geometry.pairs, 0.5 * clearance, geometry.contact_work);
  return touched ? Outcome::Moved : Outcome::Held;
}

/// A posture to grasp with.
struct Candidate {
  Promise promise;
  Posture q_a;
};

/// The first n become what the simulation says, best first: a local model sees forces across gaps that the exact dynamics does not make.
void simulate_best(const GraspJudge& judge, std::size_t n, Eigen::VectorXd q, std::vector<Candidate>& candidates) {
  if (!judge.simulated) return;
  n = std::min(n, candidates.size());
  const auto end = candidates.begin() + static_cast<std::ptrdiff_t>(n);
  for (auto it = candidates.begin(); it != end; ++it) {
    q.tail(it->q_a.size()) = it->q_a;
    it->promise.distance = judge.simulated(q, it->promise.command);
  }
  std::stable_sort(candidates.begin(), end, [](const Candidate& a, const Candidate& b) { return a.promise.distance < b.promise.distance; });
}

/// Best first.
std::vector<Candidate> draw_candidates(const world::Model& model, const world::RobotChains& chains, const PlannerOptions& options,
                                       world::ChainMask draw, const Eigen::VectorXd& q, const GraspJudge& judge, core::Random& random,
                                       contact::GeometryWorkspace& geometry) {
  std::vector<Candidate> out;
  Eigen::VectorXd q_grasp = q;
  for (int k = 0; k < options.grasp_candidates && !geometry.stop(); ++k) {
    const auto sample = contact::sample_contact(model, chains, options.sampler, draw, q, random, geometry);
    if (!sample) continue;
    q_grasp.tail(model.n_a()) = sample->q_a;
    out.push_back({judge.promise ? judge.promise(q_grasp) : Promise{}, sample->q_a});
  }
  std::stable_sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) { return a.promise.distance < b.promise.distance; });
  simulate_best(judge, static_cast<std::size_t>(options.grasp_trials), q, out);
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

bool try_regrasp(const world::Model& model, const world::RobotChains& chains, const PlannerOptions& options, const Eigen::VectorXd& q,
                 const Eigen::VectorXd& u, world::ChainMask draw, const GraspJudge& judge, core::Random& random,
                 contact::GeometryWorkspace& geometry, dynamics::StepWorkspace& steps, Regrasp& out, RegraspCounts& counts) {
  out.steps = 0;
  out.failed_steps = 0;
  out.stuck = true;
  ++counts.tried;
  if (draw == 0) {
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
  path_options.clearance = options.regrasp_clearance;
  Outcome outcome = Outcome::Moved;
  for (const world::ChainMask relaxed : {draw, chains.all()}) {
    run.emplace(model, chains, options, q, u, steps, geometry.control, out);
    bool clear = false;
    outcome = let_go(model, chains, relaxed, draw, path_options.clearance, geometry, *run, clear);
    if (!clear) {
      ++counts.no_path;
      return false;
    }
    if (outcome == Outcome::Held || relaxed == chains.all()) break;
  }
  if (outcome != Outcome::Held) return count_failure(outcome);
  out.stuck = false;

  const auto candidates = draw_candidates(model, chains, options, draw, run->q, judge, random, geometry);
  if (candidates.empty()) {
    ++counts.no_sample;
    return false;
  }
  std::vector<Posture> path;
  const bool found = std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
    return contact::find_path(model, chains, draw, run->q, candidate.q_a, path_options, random, geometry, path) ==
           contact::PathOutcome::Found;
  });
  if (!found) {
    ++counts.no_path;
    return false;
  }
  for (const auto& posture : path) {  // commands: the moving joints follow the path, the others hold
    outcome = run->move(command_of(chains, draw, posture, run->u));
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
