#include "stiction/planning/regrasp.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>

#include "stiction/planning/object_space.hpp"
#include "stiction/planning/press_limits.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning {

bool fits_cones(const dynamics::Knot& knot, double friction_scale) {
  return std::all_of(knot.contacts.begin(), knot.contacts.end(), [&](const dynamics::ContactImpulse& c) {
    return c.lambda.tail<2>().norm() <= friction_scale * c.contact.friction * c.lambda[0];
  });
}

namespace {

using core::Status;
using Posture = Eigen::VectorXd;

enum class Outcome {
  Held,
  Moved,
  Failed
};

/// How far an object may be from where it should be.
struct Allowance {
  double position;  ///< [m]
  double angle;     ///< [rad]
};

/// Simulates the commands of a regrasp and watches the object.
class RegraspRun {
 public:
  RegraspRun(const world::Model& model, const RobotChains& chains, const PlannerOptions& options, const Eigen::VectorXd& q0,
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

  /// The object does the same with less friction. A step whose forces lie in the smaller cones already is the solution of the step
  /// with less friction (it stays feasible, since v_n ≥ μ‖v_t‖ only gets weaker, and complementary), so the simulation starts at the
  /// first knot whose forces do not.
  Outcome follow_slippery() {
    std::size_t k = 0;
    while (k < out_.knots.size() && fits_cones(out_.knots[k], options_.friction * options_.regrasp_friction)) ++k;
    Eigen::VectorXd q_slippery = k == 0 ? q0_ : out_.knots[k - 1].q;
    dynamics::StepOptions slippery = step_;
    slippery.friction_scale = options_.friction * options_.regrasp_friction;
    steps_.forget();
    for (; k < out_.knots.size(); ++k) {
      ++out_.steps;
      if (dynamics::step(model_, {q_slippery, out_.knots[k].u}, slippery, steps_, step_result_) != Status::Solved) {
        ++out_.failed_steps;
        return Outcome::Failed;
      }
      q_slippery = step_result_.q_next;
      if (!objects_agree(model_, space_, out_.knots[k].q, q_slippery, options_.regrasp_tol_position, options_.regrasp_tol_angle))
        return Outcome::Moved;
    }
    return Outcome::Held;
  }

 private:
  /// Holds the command for up to kMostHeld steps, or until the object rests.
  Outcome hold(const Allowance& allowance, bool& rests) {
    for (int k = 0; k < kMostHeld && !rests; ++k) {
      const Eigen::VectorXd before = q;
      const Outcome outcome = follow(u, allowance);
      if (outcome != Outcome::Held) return outcome;
      rests = objects_agree(model_, space_, before, q, kRestingMove * model_.scales().robots().length, kRestingTurn);
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
      if (!objects_agree(model_, space_, q_rest_, knot.q, allowance.position, allowance.angle)) return Outcome::Moved;
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
  ObjectSpace space_;
  const Eigen::VectorXd& q0_;
  Eigen::VectorXd q_rest_;
  Regrasp& out_;
  dynamics::StepOptions step_;
  dynamics::RolloutResult result_;
  dynamics::StepResult step_result_;
};

/// Command with which the branches in `relaxed` stop pushing: their springs are unloaded, the others keep their grip.
Eigen::VectorXd relaxed_command(const world::Model& model, const RobotChains& chains, ChainMask relaxed, const Eigen::VectorXd& q,
                                Eigen::VectorXd u) {
  for (const int j : chains.joints_of(relaxed)) u[j] = q[model.n_qu() + j];
  return u;
}

/// The command u with the joints of the branches in `moving` at a posture.
Eigen::VectorXd command_of(const RobotChains& chains, ChainMask moving, const Posture& posture, Eigen::VectorXd u) {
  for (const int j : chains.joints_of(moving)) u[j] = posture[j];
  return u;
}

/// The branches in `relaxed` stop pushing, those in `moving` back off, and the object settles: Moved where it goes too far, or after
/// them so that they would touch it on their way. False in `clear` when they cannot back off.
Outcome let_go(const world::Model& model, const RobotChains& chains, ChainMask relaxed, ChainMask moving, double clearance,
               GeometryWorkspace& geometry, RegraspRun& run, bool& clear) {
  Outcome outcome = run.release(relaxed_command(model, chains, relaxed, run.q, run.u));
  clear = true;
  if (outcome != Outcome::Held) return outcome;
  std::vector<Posture> path;
  Eigen::VectorXd q_clear = run.q;
  clear = retreat(model, chains, moving, clearance, q_clear, geometry, path);
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
std::vector<Candidate> draw_candidates(const world::Model& model, const RobotChains& chains, const PlannerOptions& options,
                                       const GraspDraw& draw, const Eigen::VectorXd& q, const GraspJudge& judge, core::Random& random,
                                       GeometryWorkspace& geometry) {
  std::vector<Candidate> out;
  Eigen::VectorXd q_grasp = q;
  for (int k = 0; k < options.grasp_candidates && !geometry.stop(); ++k) {
    const auto sample = sample_contact(model, chains, options.sampler, draw, q, random, geometry);
    if (!sample) continue;
    q_grasp.tail(model.n_a()) = sample->q_a;
    out.push_back({judge.promise ? judge.promise(q_grasp) : Promise{}, sample->q_a});
  }
  std::stable_sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) { return a.promise.distance < b.promise.distance; });
  simulate_best(judge, static_cast<std::size_t>(options.grasp_trials), q, out);
  return out;
}

}  // namespace

bool is_free_on_its_way(const world::Model& model, const RobotChains& chains, const std::vector<dynamics::Knot>& knots,
                        GeometryWorkspace& work) {
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

bool try_regrasp(const world::Model& model, const RobotChains& chains, const PlannerOptions& options, const Eigen::VectorXd& q,
                 const Eigen::VectorXd& u, const GraspDraw& draw, const GraspJudge& judge, core::Random& random,
                 GeometryWorkspace& geometry, dynamics::StepWorkspace& steps, Regrasp& out, RegraspCounts& counts) {
  out.steps = 0;
  out.failed_steps = 0;
  out.stuck = true;
  ++counts.tried;
  if (draw.moved == 0) {
    ++counts.no_sample;
    return false;
  }
  const auto count_failure = [&](Outcome outcome) {
    ++(outcome == Outcome::Failed ? counts.failed_step : counts.object_moved);
    return false;
  };

  // First with the grip of the branches that hold, then with everything let go.
  std::optional<RegraspRun> run;
  PathOptions path_options;
  path_options.clearance = options.regrasp_clearance;
  Outcome outcome = Outcome::Moved;
  for (const ChainMask relaxed : {draw.moved, chains.all()}) {
    run.emplace(model, chains, options, q, u, steps, geometry.control, out);
    bool clear = false;
    outcome = let_go(model, chains, relaxed, draw.moved, path_options.clearance, geometry, *run, clear);
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
    return find_path(model, chains, draw.moved, run->q, candidate.q_a, path_options, random, geometry, path) == PathOutcome::Found;
  });
  if (!found) {
    ++counts.no_path;
    return false;
  }
  for (const auto& posture : path) {  // commands: the moving joints follow the path, the others hold
    outcome = run->move(command_of(chains, draw.moved, posture, run->u));
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
