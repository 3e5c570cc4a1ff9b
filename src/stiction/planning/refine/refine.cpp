#include "stiction/planning/refine.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/contact_limits.hpp"
#include "stiction/planning/refine/push_again.hpp"
#include "stiction/planning/refine/regrasp_again.hpp"

namespace stiction::planning {
namespace refinement {
namespace {

using core::Status;

/// Places of the objects that differ by less than this are one [tolerances].
constexpr double kSamePlace = 0.05;

/// A plan as far as it was built anew, push by push, and where that leads.
class Builder {
 public:
  Builder(Problem& problem, Scratch& scratch)
      : problem_(problem),
        scratch_(scratch),
        built_(problem.plan),
        at_{problem.plan.q_start, problem.plan.u_start, {.q = problem.plan.q_start, .u = problem.plan.u_start}},
        q_goal_(problem.q_goal) {
    built_.step.h = problem.pace.step.h;
    built_.substep = problem.pace.limits;
    built_.substep.joint_angle = problem.plan.substep.joint_angle;  // of branches that move freely
    built_.substep.joint_travel = problem.plan.substep.joint_travel;
    built_.segments.clear();
  }

  bool build() {
    if (!settle(problem_.plan, SegmentKind::Settle)) return false;
    out_.rests = problem_.refine.rest;
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

  RefineResult result() {
    built_.error = goal_error(problem_.model, end_of(built_), problem_.plan.goal);
    out_.plan = std::move(built_);
    out_.fine_error = goal_error(problem_.model, at_.fine.q, problem_.plan.goal);
    out_.q_fine = at_.fine.q;
    out_.variant = "refined";
    out_.rest_planned_anew = searches_;
    return std::move(out_);
  }

  const Work& work() const { return work_; }

 private:
  /// As far as the plan was built.
  struct Place {
    Cursor at;
    std::size_t segments;
    RefineResult counts;
  };
  Place here() const { return {at_, built_.segments.size(), out_}; }

  /// What a plan does before its first push.
  bool settle(const Plan& plan, SegmentKind as) {
    for (const Segment& segment : plan.segments) {
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

  /// From where the robot is to where the push starts: with the largest clearance that leaves the objects where the push wants them, or where they are; else
  /// with what leaves them nearest to it, the commands of the plan among it.
  bool regrasp(const Push& push, std::size_t number) {
    if (!push.regrasp && !push.merged) return true;
    std::vector<double> clearances;
    if (problem_.refine.reconnect) clearances = problem_.refine.clearances;
    if (push.regrasp && !push.merged) clearances.push_back(0);  // the commands of the plan
    const double missed = std::max(problem_.miss(push.q_entry, at_.q), problem_.miss(push.q_entry, at_.fine.q));
    const double enough = std::max(problem_.refine.miss, missed + kSamePlace), length = problem_.model.scales().robots().length;
    std::optional<Run> best;
    for (const double clearance : clearances) {
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

  /// A push in small steps ends elsewhere than it did in the plan: feedback on the objects where that is too far away, then iMPC. It ends at rest where that
  /// does not take it too far away. A push that misses, but brings the objects nearer the goal, is kept: what is left is planned anew.
  bool push(const Push& push, bool last) {
    const Eigen::VectorXd q_target = last ? q_goal_ : push.edges.back().knots.back().q;
    const auto will_do = [&](const Run& run) { return last ? reaches_goal(run.end.q, run.end.fine.q) : run.missed <= threshold::kLost; };
    std::optional<Run> nearer;
    for (const bool rests : {true, false}) {
      if (rests && !problem_.refine.rest) continue;
      std::optional<Run> best = best_push(push, q_target, rests);
      if (best && best->missed > threshold::kFarOff)
        out_.corrected += correct_by_impc(problem_, at_, q_target, scratch_, mpc_work_, work_, *best);
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

  /// Without feedback where that ends near enough, else the better one.
  std::optional<Run> best_push(const Push& push, const Eigen::VectorXd& q_target, bool rests) {
    std::optional<Run> best;
    for (const bool feedback : {false, true}) {
      Run run;
      if (!follow_push(problem_, at_, push, q_target, feedback, scratch_, work_, run)) continue;
      if (rests && !come_to_rest(problem_, scratch_, work_, run)) continue;
      finish(problem_, at_, q_target, scratch_, work_, run);
      if (run.holds && (!best || run.missed < best->missed)) best = std::move(run);
      if (best && best->missed <= problem_.refine.miss) break;
    }
    return best;
  }

  /// What is left to do, from the last place at which whole and half sub-steps agree and that no search has begun at; if that does not come to rest, from the
  /// one before.
  bool plan_anew(std::vector<Push>& pushes) {
    PlannerOptions options = problem_.options;
    options.friction = problem_.plan.step.friction_scale;
    options.tolerance_fraction = std::min(options.tolerance_fraction, threshold::kAgree);
    options.anytime = false;
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
      const PlanningProblem from_here{problem_.problem.model, at_.q, problem_.plan.goal, q_goal_.head(problem_.model.n_qu())};
      (void)plan_from(from_here, at_.u, options, problem_.control, rest);
      extensions_ += rest.iterations;
      work_ += {rest.steps, rest.failed_steps};
    }
    if (rest.status != Status::Solved || !settle(rest.plan, SegmentKind::Contact)) return false;
    pushes = problem_.shortened(rest.plan);
    q_goal_ = at_goal(problem_.model, end_of(rest.plan), problem_.plan.goal);
    return true;
  }

  void take_push(Run& run) {
    out_.led += run.led;
    out_.rests = out_.rests && run.rests;
    take(run);
  }

  void take(Run& run) {
    at_ = std::move(run.end);
    std::move(run.segments.begin(), run.segments.end(), std::back_inserter(built_.segments));
    if (agrees(at_)) sure_.push_back(here());
  }

  bool agrees(const Cursor& at) const { return problem_.miss(at.q, at.fine.q) <= threshold::kAgree; }

  /// At the sub-step and at half of it.
  bool reaches_goal(const Eigen::VectorXd& q, const Eigen::VectorXd& q_fine) const {
    return problem_.reaches_goal(q, q_fine, problem_.options.tolerance_fraction);
  }

  Problem& problem_;
  Scratch& scratch_;
  Plan built_;
  Cursor at_;
  Eigen::VectorXd q_goal_;   // where what is left of the plan ends
  std::vector<Place> sure_;  // ends of pushes and regrasps at which whole and half sub-steps agree, from where no search has begun
  int searches_ = 0;         // for what is left …
  long extensions_ = 0;      // … and theirs
  RefineResult out_;
  Work work_;
  double mpc_work_ = 0;
};

/// The given plan at half of its own sub-steps.
Run look_at_given_plan(const Problem& problem, Scratch& scratch, Work& work) {
  const Plan& plan = problem.plan;
  Run run;
  run.end.fine = {.q = plan.q_start, .u = plan.u_start};
  Pace halves = problem.halves;
  halves.step.h = plan.step.h;
  Simulation simulation(problem, scratch, work);
  run.holds = std::ranges::all_of(plan.segments, [&](const Segment& segment) {
    return simulation.follow(commands_of(segment.knots), halves, {}, {}, run.end.fine) == Ending::Reached;
  });
  (void)simulation.ends_well({.most = problem.allowed}, run.end.fine);
  if (!run.holds) run.end.fine.q = plan.q_start;
  return run;
}

/// The given plan is what comes out, with forces: one that was read from a file comes without.
void keep_given_plan(const Problem& problem, const Eigen::VectorXd& q_fine, Scratch& scratch, RefineResult& out, Work& work) {
  out = RefineResult{};
  out.plan = problem.plan;
  out.variant = "unchanged";
  dynamics::StepOptions step = problem.pace.step;
  step.h = problem.plan.step.h;
  Eigen::VectorXd q = out.plan.q_start;
  for (Segment& segment : out.plan.segments) {
    add_forces(problem.model, step, q, segment, scratch, work);
    if (!segment.knots.empty()) q = segment.knots.back().q;
  }
  out.fine_error = goal_error(problem.model, q_fine, problem.plan.goal);
  out.q_fine = q_fine;
}

Status run(const std::shared_ptr<const world::Model>& model, const Plan& plan, const PlannerOptions& options,
           const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out) {
  core::RunControl quiet = control;  // there is no measure of how far a refinement has come
  quiet.on_progress = nullptr;
  Problem problem(model, plan, options, refine_options, quiet);
  Scratch scratch(model, quiet);
  Work work;
  const core::RunControl to_the_end;  // the given plan is looked at also in a run that was stopped
  Scratch unstopped(model, to_the_end);
  const Run given = look_at_given_plan(problem, unstopped, work);
  const bool at_goal = !plan.segments.empty() && problem.reaches_goal(end_of(plan), given.end.fine.q, 1.0);
  Status status = Status::NumericalFailure;
  bool built = false;
  if (at_goal) {
    const Worst& worst = given.end.fine.worst;
    problem.allowed = {std::max(problem.allowed.penetration, worst.penetration), std::max(problem.allowed.force_gap, worst.force_gap),
                       std::max(problem.allowed.press, worst.press)};
    Builder builder(problem, scratch);
    built = builder.build();
    work += builder.work();
    if (built) out = builder.result();
    status = built || !control.stop() ? Status::Solved : control.cancelled() ? Status::Cancelled : Status::MaxIterations;
  }
  if (!built) keep_given_plan(problem, given.end.fine.q, unstopped, out, work);
  out.steps = work.steps;
  out.failed_steps = work.failed_steps;
  return status;
}

void count(const Plan& plan, int& pushes, int& regrasps, long& knots) {
  SegmentKind before = SegmentKind::Settle;
  for (const Segment& segment : plan.segments) {
    knots += static_cast<long>(segment.knots.size());
    regrasps += segment.kind == SegmentKind::Regrasp && before != SegmentKind::Regrasp;
    pushes += segment.kind == SegmentKind::Contact && before != SegmentKind::Contact;
    before = segment.kind;
  }
}

}  // namespace
}  // namespace refinement

void RefineOptions::validate() const {
  if (clearances.empty()) core::throw_invalid("refine.clearances", "none", "at least one");
  for (const double clearance : clearances) core::require_positive("refine.clearances", clearance);
  core::require_positive("refine.h", h);
  if (mpc_iterations < 0) core::throw_invalid("refine.mpc_iterations", std::to_string(mpc_iterations), "0 or more");
  core::require_positive("refine.miss", miss);
  if (extensions < 0) core::throw_invalid("refine.extensions", std::to_string(extensions), "0 or more");
}

core::Status refine(const std::shared_ptr<const world::Model>& model, const Plan& plan, const PlannerOptions& options,
                    const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out) {
  const auto start = core::RunControl::Clock::now();
  if (!model) core::throw_invalid("model", "nothing", "a model");
  refine_options.validate();
  options.validate(*model);
  if (options.thesis)
    core::throw_invalid("options.thesis", "single steps and jumps", "a plan in sub-steps, with regrasps that can be carried out");
  world::require_configuration(*model, "plan.q_start", plan.q_start);
  core::require_size("plan.u_start", plan.u_start.size(), model->n_a());
  if (plan.goal.object < 0 || plan.goal.object >= static_cast<int>(model->objects().size()))
    core::throw_invalid("plan.goal.object", std::to_string(plan.goal.object), "the index of an object");
  out.status = refinement::run(model, plan, options, refine_options, control, out);
  refinement::count(plan, out.pushes_before, out.regrasps_before, out.knots_before);
  refinement::count(out.plan, out.pushes, out.regrasps, out.knots);
  out.wall_s = core::seconds_since(start);
  return out.status;
}

}  // namespace stiction::planning
