#include "stiction/planning/refine/regrasp_anew.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "stiction/contact/free_path.hpp"
#include "stiction/core/random.hpp"
#include "stiction/planning/contact_limits.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning::refinement {
namespace {

/// A branch whose posture differs by more than this between two pushes has moved [rad or m].
constexpr double kMoved = 5e-3;

/// How far objects may be from where they rested [m, rad].
struct Allowance {
  double position, angle;
};

/// Simulates the commands of a regrasp and watches the objects.
class WatchedRegrasp {
 public:
  WatchedRegrasp(CommandFollower& follower, const Push& push)
      : follower_(follower),
        problem_(follower.problem()),
        sizes_(follower.sizes()),
        push_(push),
        q_rest_(follower.q),
        release_{problem_.options.release_tol_position, problem_.options.release_tol_angle},
        regrasp_{problem_.options.regrasp_tol_position, problem_.options.regrasp_tol_angle} {}

  /// To a command while the objects are let go of.
  bool release(const Eigen::VectorXd& u, Segment& segment) { return roll_to(u, sizes_.substep, release_, segment); }

  /// Lets go, and goes to the posture and the command from which the push starts.
  bool go(const Moves& moves, double clearance, core::Random& random, Segment& segment) {
    const world::Model& model = problem_.model;
    const world::RobotChains& chains = problem_.chains;
    Eigen::VectorXd u = follower_.u;  // springs of moving branches are unloaded where they are
    for (const int j : chains.joints_of(moves.moving)) u[j] = follower_.q[model.n_qu() + j];
    for (const int j : chains.joints_of(moves.relaxed)) u[j] = push_.u_entry[j];
    if (!release(u, segment)) return false;
    q_rest_ = follower_.q;
    if (moves.moving == 0) return hold(segment);

    Eigen::VectorXd goal = follower_.q.tail(model.n_a());
    const auto joints = chains.joints_of(moves.moving);
    for (const int j : joints) goal[j] = push_.q_entry[model.n_qu() + j];
    const contact::PathOptions path_options{.clearance = clearance};
    std::vector<Eigen::VectorXd> path;
    if (contact::find_path(model, chains, moves.moving, follower_.q, goal, path_options, random, geometry(), path) !=
        contact::PathOutcome::Found)
      return false;
    bool was_clear = false;
    for (std::size_t k = 0; k < path.size(); ++k) {
      u = follower_.u;
      for (const int j : joints) u[j] = k + 1 == path.size() ? push_.u_entry[j] : path[k][j];
      const bool clear = is_clear(moves.moving, path[k], 0.5 * clearance);
      if (!roll_to(u, was_clear && clear ? sizes_.free_substep : sizes_.substep, regrasp_, segment)) return false;
      was_clear = clear;
    }
    return hold(segment);
  }

  bool is_free_on_its_way(const Segment& segment) {
    return planning::is_free_on_its_way(problem_.model, problem_.chains, segment.knots, geometry());
  }

  bool holds_slippery(const Eigen::VectorXd& q_before, const Segment& segment) {
    return planning::holds_slippery(problem_, q_before, segment.knots, sizes_.exact, follower_.scratch(), follower_.work) == Outcome::Held;
  }

 private:
  contact::GeometryWorkspace& geometry() { return follower_.scratch().geometry; }

  /// Holds the command until the objects rest in the new grip. @returns false where they slide out of it
  bool hold(Segment& segment) {
    const double resting_move = kRestingMove * problem_.model.scales().robots().length / sizes_.cuts;
    const double resting_turn = kRestingTurn / sizes_.cuts;
    for (int k = 0; k < kMostHeld * sizes_.cuts; ++k) {
      const Eigen::VectorXd before = follower_.q;
      if (!follower_.advance(follower_.u, segment) || !stays(follower_.q, regrasp_)) return false;
      if (problem_.goal.share(before, follower_.q, resting_move, resting_turn) <= 1) return true;
    }
    return false;
  }

  /// The objects are where they rested before, or where they are wanted.
  bool stays(const Eigen::VectorXd& q, const Allowance& allowance) const {
    return problem_.goal.share(q_rest_, q, allowance.position, allowance.angle) <= 1 || problem_.miss(push_.q_entry, q) <= kFarOff;
  }

  /// Nothing is nearer than so much to the branches in `moving` at a posture.
  bool is_clear(world::ChainMask moving, const Eigen::VectorXd& q_a, double clearance) {
    Eigen::VectorXd q = follower_.q;
    q.tail(problem_.model.n_a()) = q_a;
    problem_.chains.pairs_of(moving, geometry().pairs);
    world::calc_kinematics(problem_.model, q, geometry().kinematics_work, geometry().kinematics);
    return !contact::any_nearer(problem_.model, geometry().kinematics, geometry().pairs, clearance, geometry().contact_work);
  }

  /// @returns false where the objects neither stay nor are where they are wanted
  bool roll_to(const Eigen::VectorXd& u, const dynamics::SubstepLimits& limits, const Allowance& allowance, Segment& segment) {
    if ((u - follower_.u).cwiseAbs().maxCoeff() == 0) return true;
    dynamics::RolloutResult& rollout = follower_.scratch().rollout_result;
    const core::Status status = dynamics::rollout(problem_.model, follower_.q, follower_.u, u, sizes_.exact, limits,
                                                  follower_.scratch().steps, rollout, dynamics::Overrun::Accept, &problem_.control);
    if (!follower_.work.add(rollout.steps, status)) return false;
    const double depth = std::max(rollout.penetration, calc_penetration(problem_.model, rollout.knots.back().q, geometry()));
    if (depth > problem_.allowed.penetration) return false;
    for (const auto& knot : rollout.knots) {
      if (!stays(knot.q, allowance) || problem_.press.share(knot.contacts, sizes_.exact.h) > problem_.allowed.press) return false;
    }
    follower_.q = rollout.knots.back().q;
    follower_.u = rollout.knots.back().u;
    segment.knots.insert(segment.knots.end(), std::make_move_iterator(rollout.knots.begin()), std::make_move_iterator(rollout.knots.end()));
    return true;
  }

  CommandFollower& follower_;
  const Problem& problem_;
  const StepSizes& sizes_;
  const Push& push_;
  Eigen::VectorXd q_rest_;  // where the objects rest (n_q)
  Allowance release_, regrasp_;
};

}  // namespace

Moves moves_to(const Problem& problem, const Cursor& at, const Push& push) {
  Moves out;
  const int n_qu = problem.model.n_qu();
  for (int c = 0; c < problem.chains.size(); ++c) {
    double posture = 0, command = 0;
    for (const int j : problem.chains.joints(c)) {
      posture = std::max(posture, std::abs(push.q_entry[n_qu + j] - at.q[n_qu + j]));
      command = std::max(command, std::abs(push.u_entry[j] - at.u[j]));
    }
    if (posture > kMoved) {
      out.moving |= world::ChainMask{1} << c;
    } else if (command > 0) {
      out.relaxed |= world::ChainMask{1} << c;
    }
  }
  return out;
}

bool regrasp_anew(CommandFollower& follower, const Push& push, std::size_t number, const Moves& moves, Run& run) {
  const Eigen::VectorXd q_before = follower.q;
  Segment segment{SegmentKind::Regrasp, {}};
  core::Random random(follower.problem().refine.seed, number);
  WatchedRegrasp regrasp(follower, push);
  if (!regrasp.go(moves, run.clearance, random, segment) || !regrasp.is_free_on_its_way(segment) ||
      !regrasp.holds_slippery(q_before, segment))
    return false;
  if (!segment.knots.empty()) run.segments.push_back(std::move(segment));
  return true;
}

bool regrasp_as_planned(CommandFollower& follower, const Push& push, Run& run) {
  Segment back{SegmentKind::Regrasp, {}};
  WatchedRegrasp regrasp(follower, push);
  if (!regrasp.release(push.u_regrasp, back) || !regrasp.is_free_on_its_way(back)) return false;
  if (!back.knots.empty()) run.segments.push_back(std::move(back));
  Segment& segment = run.segments.emplace_back(Segment{SegmentKind::Regrasp, {}});
  return follower.replay(*push.regrasp, segment) && regrasp.is_free_on_its_way(segment);
}

}  // namespace stiction::planning::refinement
