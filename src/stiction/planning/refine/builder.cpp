#include "stiction/planning/refine/builder.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "stiction/planning/contact_limits.hpp"
#include "stiction/planning/refine/push_again.hpp"
#include "stiction/planning/refine/regrasp_again.hpp"

namespace stiction::planning::refinement {

using core::Status;

namespace {

/// Places of the objects that differ by less than this count as the same [tolerances].
constexpr double kSamePlace = 0.05;
/// A regrasp that leaves objects farther than this from where the push needs them is tried with less clearance as well [tolerances].
constexpr double kNearEnough = 0.2;

}  // namespace

Builder::Builder(Problem& problem, Scratch& scratch)
    : problem_(problem),
      scratch_(scratch),
      built_(problem.plan),
      at_{problem.plan.q_start, problem.plan.u_start, {.q = problem.plan.q_start, .u = problem.plan.u_start}} {
  built_.step.h = problem.pace.step.h;
  built_.substep = problem.pace.limits;
  built_.substep.joint_angle = problem.plan.substep.joint_angle;  // for branches that move freely
  built_.substep.joint_travel = problem.plan.substep.joint_travel;
  built_.segments.clear();
}

bool Builder::build() {
  if (!settle(problem_.plan.segments, SegmentKind::Settle)) return false;
  std::vector<Push> pushes = problem_.shortened(problem_.plan);
  sure_.push_back(here());
  for (std::size_t i = 0; i < pushes.size();) {
    if (problem_.control.stop()) return false;
    const bool last = i + 1 == pushes.size();
    if (regrasp(pushes[i], i) && push(pushes[i], last)) {
      ++i;
    } else if (plan_anew(pushes)) {
      i = 0;
    } else {
      return false;
    }
  }
  return !built_.segments.empty() && reaches_goal(end_of(built_), at_.fine.q) &&
         calc_penetration(problem_.model, end_of(built_), scratch_.geometry) <= problem_.allowed.penetration;
}

RefineResult Builder::result() {
  built_.error = goal_error(problem_.model, end_of(built_), problem_.plan.goal);
  out_.plan = std::move(built_);
  out_.fine_error = goal_error(problem_.model, at_.fine.q, problem_.plan.goal);
  out_.q_fine = at_.fine.q;
  out_.variant = "refined";
  out_.rest_planned_anew = searches_;
  return std::move(out_);
}

/// Follows the commands that a plan has before its first push.
bool Builder::settle(const std::vector<Segment>& segments, SegmentKind as) {
  for (const Segment& segment : segments) {
    if (segment.kind != SegmentKind::Settle) continue;
    Run run{.end = at_};
    Trace trace{.q = at_.q, .u = at_.u};
    if (Simulation(problem_, scratch_, work_).follow(commands_of(segment.knots), problem_.pace, {}, {}, trace) != Ending::Reached)
      return false;
    run.end.q = std::move(trace.q);
    run.end.u = std::move(trace.u);
    run.segments.push_back({as, std::move(trace.knots), false});
    finish(problem_, at_, run.end.q, scratch_, work_, run);
    if (!run.holds) return false;
    take(run);
  }
  return true;
}

/// Clearances that are tried, in this order; 0: the commands of the plan.
std::vector<double> Builder::clearances_of(const Push& push) const {
  std::vector<double> out;
  if (problem_.refine.reconnect) out = problem_.refine.clearances;
  if (push.regrasp && !push.merged) out.push_back(0);
  return out;
}

/// Goes from the present posture to the start of a push. Takes the largest clearance that leaves the objects where they are or where the
/// push needs them. Else takes the candidate that leaves them nearest to it; the commands of the plan are a candidate.
bool Builder::regrasp(const Push& push, std::size_t number) {
  if (!push.regrasp && !push.merged) return true;
  const double missed = std::max(problem_.miss(push.q_entry, at_.q), problem_.miss(push.q_entry, at_.fine.q));
  const double enough = std::max(kNearEnough, missed + kSamePlace), length = problem_.model.scales().robots().length;
  std::optional<Run> best;
  for (const double clearance : clearances_of(push)) {
    Run run;
    const bool done = clearance > 0 ? regrasp_again(problem_, at_, push, number, clearance * length, scratch_, work_, run)
                                    : regrasp_as_planned(problem_, at_, push, scratch_, work_, run);
    if (!done) continue;
    finish(problem_, at_, push.q_entry, scratch_, work_, run);
    if (run.holds && (!best || run.missed < best->missed)) best = std::move(run);
    if (best && best->missed <= enough) break;
  }
  if (!best) return false;
  if (best->clearance > 0)
    out_.least_clearance = out_.reconnected++ > 0 ? std::min(out_.least_clearance, best->clearance) : best->clearance;
  take(*best);
  return true;
}

/// Follows a push in small steps. The last push must reach the goal; the others may end up to kLost from their end in the plan.
bool Builder::push(const Push& push, bool last) {
  Run run;
  if (!push_again(problem_, at_, push, scratch_, work_, run)) return false;
  finish(problem_, at_, push.edges.back().knots.back().q, scratch_, work_, run);
  const bool there = run.holds && (last ? reaches_goal(run.end.q, run.end.fine.q) : run.missed <= threshold::kLost);
  if (there) take(run);
  return there;
}

/// Plans the remaining way from the last place where whole and half sub-steps agree and no search has started. If the objects do not come
/// to rest there, it takes the place before.
bool Builder::plan_anew(std::vector<Push>& pushes) {
  PlannerOptions options = problem_.options;
  options.friction = problem_.plan.step.friction_scale;
  options.tolerance_fraction = std::min(options.tolerance_fraction, threshold::kAgree);
  options.anytime = false;
  const Goal& goal = problem_.plan.goal;
  Eigen::VectorXd q_goal;  // empty if it follows from the goal pose
  if (goal.region || problem_.model.objects()[static_cast<std::size_t>(goal.object)].parent >= 0)
    q_goal = end_of(problem_.plan).head(problem_.model.n_qu());
  PlanResult rest;
  while (rest.status == Status::NumericalFailure && !sure_.empty() && extensions_ < problem_.refine.extensions &&
         !problem_.control.stop()) {
    const Place place = std::move(sure_.back());
    sure_.pop_back();
    at_ = place.at;
    built_.segments.resize(place.segments);
    out_ = place.counts;
    options.seed = problem_.options.seed + static_cast<std::uint64_t>(++searches_);
    options.max_iterations = static_cast<int>(problem_.refine.extensions - extensions_);
    const PlanningProblem from_here{problem_.problem.model, at_.q, goal, q_goal};
    (void)plan_from(from_here, at_.u, options, problem_.control, rest);
    extensions_ += rest.iterations;
    work_ += {rest.steps, rest.failed_steps};
  }
  if (rest.status != Status::Solved || !settle(rest.plan.segments, SegmentKind::Contact)) return false;
  pushes = problem_.shortened(rest.plan);
  return true;
}

void Builder::take(Run& run) {
  at_ = std::move(run.end);
  std::move(run.segments.begin(), run.segments.end(), std::back_inserter(built_.segments));
  if (agrees(at_)) sure_.push_back(here());
}

/// True if the goal is reached at the sub-step and at half of it.
bool Builder::reaches_goal(const Eigen::VectorXd& q, const Eigen::VectorXd& q_fine) const {
  return problem_.reaches_goal(q, q_fine, problem_.options.tolerance_fraction);
}

}  // namespace stiction::planning::refinement
