#include "stiction/planning/refine/attempt.hpp"

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include "stiction/planning/contact_limits.hpp"
#include "stiction/planning/refine/feedback.hpp"
#include "stiction/planning/refine/impc.hpp"
#include "stiction/planning/refine/regrasp_anew.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning::refinement {
namespace {

/// A push that ends farther than this from where it did in the plan, in tolerances of the goal, is not made good by those after it.
constexpr double kLost = 2;
/// What is left is planned from where whole and half sub-steps are no farther apart than this, in tolerances of the goal, and to no farther away from it.
constexpr double kAgree = 0.45;
/// Weights γ of (E.6) that a push is tried with until it ends near enough, from none to firm feedback.
constexpr std::initializer_list<double> kFeedback = {kNoFeedback, 1e-1, 3e-2, 1e-2, 3e-3};

/// A plan as far as it was built anew, and where that leads.
class Builder {
 public:
  Builder(const Problem& problem, const Trial& trial, Crew& crew, int worker, const Turn& turn)
      : problem_(problem),
        trial_(trial),
        sizes_(problem, trial.cuts),
        crew_(crew),
        scratch_(crew.of(worker)),
        turn_(turn),
        built_(problem.plan),
        at_{problem.plan.q_start, problem.plan.u_start, {.q = problem.plan.q_start, .u = problem.plan.u_start}},
        q_goal_(problem.q_goal) {
    built_.step.h = sizes_.exact.h;
    built_.substep = sizes_.free_substep;
    built_.segments.clear();
    out_.rests = trial.rest;
  }

  Attempt run() {
    Attempt out;
    out.worked = build() && !built_.segments.empty() && reaches_goal(end_of(built_), at_.fine.q) &&
                 calc_penetration(problem_.model, end_of(built_), scratch_.geometry) <= problem_.allowed.penetration;
    out.work = work_;
    if (!out.worked) return out;
    built_.error = goal_error(problem_.model, end_of(built_), problem_.plan.goal);
    out_.plan = std::move(built_);
    out_.fine_error = goal_error(problem_.model, at_.fine.q, problem_.plan.goal);
    out_.q_fine = at_.fine.q;
    out_.variant = trial_.name;
    out_.rest_planned_anew = searches_;
    out.refined = std::move(out_);
    return out;
  }

 private:
  bool build() {
    if (!settle(problem_.plan, SegmentKind::Settle)) return false;
    std::vector<Push> pushes = *trial_.pushes;
    sure_.push_back(here());
    for (std::size_t i = 0; i < pushes.size();) {
      if (stops(problem_.control, &turn_)) return false;
      const bool done = reach_and_push(pushes[i], i, i + 1 == pushes.size());
      if (!done && (sizes_.coarse || !plan_anew(pushes))) return false;
      i = done ? i + 1 : 0;
    }
    return true;
  }

  /// What is left to do, from the last place that small steps are sure of and that no search has begun at; if that does not come to rest, from the one before.
  bool plan_anew(std::vector<Push>& pushes) {
    PlannerOptions options = problem_.options;
    options.friction = problem_.plan.step.friction_scale;
    options.trees = 1;  // every second one has a friction of its own
    options.stop_at_goal = true;
    options.tolerance_fraction = std::min(options.tolerance_fraction, kAgree);
    options.threads = crew_.pool.size();
    options.anytime = false;
    core::RunControl control = problem_.control;
    control.abandoned = [this] { return stops(problem_.control, &turn_); };
    PlanResult rest;
    while (rest.status == core::Status::NumericalFailure && !sure_.empty() && extensions_ < problem_.refine.extensions && !control.stop()) {
      back_to(sure_.back());
      sure_.pop_back();
      options.seed = problem_.options.seed + static_cast<std::uint64_t>(++searches_);
      options.max_iterations = static_cast<int>(problem_.refine.extensions - extensions_);
      const PlanningProblem from_here{problem_.problem.model, at_.q, problem_.plan.goal, q_goal_.head(problem_.model.n_qu())};
      (void)plan_from(from_here, at_.u, options, control, rest);
      extensions_ += rest.iterations;
      work_ += {rest.steps, rest.failed_steps};
    }
    if (rest.status != core::Status::Solved || !settle(rest.plan, SegmentKind::Contact)) return false;
    pushes = problem_.shortened(rest.plan);
    q_goal_ = at_goal(problem_.model, end_of(rest.plan), problem_.plan.goal);
    return true;
  }

  /// What a plan does before its first push.
  bool settle(const Plan& plan, SegmentKind as) {
    return replay([&](CommandFollower& follower) {
      return std::all_of(plan.segments.begin(), plan.segments.end(), [&](const Segment& segment) {
        return segment.kind != SegmentKind::Settle || follower.replay(segment, built_.segments.emplace_back(Segment{as, {}}));
      });
    });
  }

  /// The regrasp before a push, where there is one, and the push. At the steps of the plan another clearance is tried where it comes to nothing.
  bool reach_and_push(const Push& push, std::size_t number, bool last) {
    const auto push_on = [&] { return sizes_.coarse ? replay(push) : follow(push, last); };
    if (!push.regrasp && !push.merged) return push_on();
    const Place before = here();
    std::vector<double> clearances;
    if (problem_.refine.reconnect) clearances = problem_.refine.clearances;
    for (double& clearance : clearances) clearance *= problem_.model.scales().robots().length;
    if (!push.merged && push.regrasp) clearances.push_back(0);
    while (!clearances.empty()) {
      const std::optional<double> clearance = regrasp(push, number, clearances);
      if (!clearance) return false;
      if (push_on()) return true;
      if (!sizes_.coarse) return false;
      std::erase(clearances, *clearance);
      back_to(before);
    }
    return false;
  }

  /// From where the robot is to where the push starts: with the largest clearance that leaves the objects where the push wants them, or where they are; else
  /// with what leaves them nearest to it, the commands of the plan among it.
  /// @param clearances  that may count, 0: the commands of the plan   @returns that which was taken
  std::optional<double> regrasp(const Push& push, std::size_t number, const std::vector<double>& clearances) {
    const Moves moves = moves_to(problem_, at_, push);
    std::vector<Run> runs(clearances.size());
    for (std::size_t k = 0; k < runs.size(); ++k) runs[k].clearance = clearances[k];
    const double missed = std::max(problem_.miss(push.q_entry, at_.q), problem_.miss(push.q_entry, at_.fine.q));
    std::optional<Run> best = best_of(
        start(), std::move(runs), push.q_entry, std::max(problem_.refine.miss, missed + kSamePlace),
        [&](CommandFollower& follower, Run& run) {
          return run.clearance > 0 ? regrasp_anew(follower, push, number, moves, run) : regrasp_as_planned(follower, push, run);
        },
        crew_, work_);
    if (!best) return {};
    const double clearance = best->clearance;
    if (clearance > 0) {
      out_.least_clearance = out_.reconnected++ > 0 ? std::min(out_.least_clearance, clearance) : clearance;
    }
    take(*best);
    return clearance;
  }

  /// A push in small steps ends elsewhere than it did in the plan: feedback on the objects, as little as brings it near enough, then iMPC. It ends at rest
  /// where that does not take it too far away. One that misses, but brings the objects nearer the goal, is kept all the same: what is left is planned anew.
  bool follow(const Push& push, bool last) {
    const Eigen::VectorXd& q_target = last ? q_goal_ : push.edges.back().knots.back().q;
    const auto will_do = [&](const Run& run) { return last ? reaches_goal(run.end.q, run.end.fine.q) : run.missed <= kLost; };
    std::vector<Way> ways(kFeedback.size());
    std::optional<Run> nearer;
    for (const bool rests : {true, false}) {
      if (rests && !trial_.rest) continue;
      std::vector<Run> runs(kFeedback.size());
      for (std::size_t k = 0; k < runs.size(); ++k) {
        runs[k].gamma = kFeedback.begin()[k];
        runs[k].way = &ways[k];
        runs[k].rests = rests;
      }
      std::optional<Run> best = best_of(
          start(), std::move(runs), q_target, problem_.refine.miss,
          [&](CommandFollower& follower, Run& run) { return push_with_feedback(follower, push, q_target, run); }, crew_, work_);
      if (best && best->missed > kFarOff)
        out_.corrected += correct_by_impc(start(), q_target, scratch_, crew_.pool.size(), mpc_work_, *best, work_);
      if (best && will_do(*best)) {
        take_push(*best);
        return true;
      }
      if (best && !nearer && problem_.miss(q_goal_, best->end.q) < problem_.miss(q_goal_, at_.q) && agrees(best->end))
        nearer = std::move(best);
    }
    if (nearer) take_push(*nearer);
    return false;
  }

  void take_push(Run& run) {
    out_.led += run.gamma != kNoFeedback;
    out_.rests = out_.rests && run.rests;
    take(run);
  }

  bool agrees(const Cursor& at) const { return problem_.miss(at.q, at.fine.q) <= kAgree; }

  /// A trial as far as it has come.
  struct Place {
    Cursor at;
    std::size_t segments;
    RefineResult counts;
  };
  Place here() const { return {at_, built_.segments.size(), out_}; }
  void back_to(const Place& place) {
    at_ = place.at;
    built_.segments.resize(place.segments);
    out_ = place.counts;
  }

  /// A push with the commands of the plan.
  bool replay(const Push& push) {
    return replay([&](CommandFollower& follower) {
      for (const Segment& edge : push.edges) {
        if (!follower.replay(edge, built_.segments.emplace_back(Segment{edge.kind, {}}))) return false;
      }
      return !trial_.rest || follower.come_to_rest(built_.segments.back());
    });
  }

  /// On to where commands lead at whole sub-steps, and then at half of them.
  /// @param commands  (CommandFollower&) → bool, appends segments
  template <class Commands>
  bool replay(const Commands& commands) {
    const std::size_t first = built_.segments.size();
    CommandFollower follower(problem_, sizes_, at_.q, at_.u, &turn_, scratch_);
    const bool followed = commands(follower);
    work_ += follower.work;
    at_.q = std::move(follower.q);
    at_.u = std::move(follower.u);
    return followed && go_on_in_half_steps(problem_.press, std::span(built_.segments).subspan(first), sizes_.exact, problem_.allowed,
                                           problem_.control, scratch_, at_.fine, work_);
  }

  void take(Run& run) {
    at_ = std::move(run.end);
    std::move(run.segments.begin(), run.segments.end(), std::back_inserter(built_.segments));
    if (agrees(at_)) sure_.push_back(here());
  }

  Start start() const { return {problem_, sizes_, at_, &turn_}; }

  /// At the sub-step and at half of it.
  bool reaches_goal(const Eigen::VectorXd& q, const Eigen::VectorXd& q_fine) const {
    return problem_.reaches_goal(q, q_fine, problem_.options.share_when_refined());
  }

  const Problem& problem_;
  const Trial& trial_;
  const StepSizes sizes_;
  Crew& crew_;
  Scratch& scratch_;
  const Turn& turn_;
  Plan built_;
  Cursor at_;
  Eigen::VectorXd q_goal_;  // where what is left of the plan ends
  std::vector<Place>
      sure_;  // from where no search has begun: where the plan begins, ends of pushes and regrasps at which whole and half sub-steps agree
  int searches_ = 0;     // for what is left …
  long extensions_ = 0;  // … and theirs
  RefineResult out_;
  Work work_;
  double mpc_work_ = 0;  // so far
};

}  // namespace

Attempt attempt(const Problem& problem, const Trial& trial, Crew& crew, int worker, const Turn& turn) {
  return Builder(problem, trial, crew, worker, turn).run();
}

}  // namespace stiction::planning::refinement
