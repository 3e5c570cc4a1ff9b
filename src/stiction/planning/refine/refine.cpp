#include "stiction/planning/refine.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/refine/attempt.hpp"

namespace stiction::planning {
namespace refinement {
namespace {

using core::Status;

/// How the given plan does at half the sub-step.
struct GivenPlan {
  HalfSteps fine;
  bool reaches_goal = false;
};

GivenPlan look_at_given_plan(const Problem& problem, Scratch& scratch, Work& work) {
  const Plan& plan = problem.plan;
  GivenPlan given{.fine = {.q = plan.q_start, .u = plan.u_start}};
  if (!go_on_in_half_steps(problem.press, plan.segments, StepSizes(problem, 1).exact, kAnything, {}, scratch, given.fine, work))
    given.fine.q = plan.q_start;
  given.reaches_goal = !plan.segments.empty() && problem.reaches_goal(end_of(plan), given.fine.q, 1.0);
  return given;
}

/// The given plan is what comes out, with forces: one that was read from a file comes without.
void keep_given_plan(const Problem& problem, const GivenPlan& given, Scratch& scratch, RefineResult& out, Work& work) {
  out.plan = problem.plan;
  Eigen::VectorXd q = out.plan.q_start;
  for (Segment& segment : out.plan.segments) {
    add_forces(problem.model, StepSizes(problem, 1).exact, q, segment, scratch, work);
    if (!segment.knots.empty()) q = segment.knots.back().q;
  }
  out.variant = "unchanged";
  out.fine_error = goal_error(problem.model, given.fine.q, problem.plan.goal);
  out.q_fine = given.fine.q;
}

std::size_t count_knots(const std::vector<Push>& pushes) {
  std::size_t n = 0;
  for (const Push& push : pushes) {
    for (const Segment& edge : push.edges) n += edge.knots.size();
  }
  return n;
}

/// Trials one after the other, up to the first that works.
struct Sequence {
  std::vector<Trial> trials;
  Attempt last = {};  ///< of those that were tried
  bool came_through = false;
  Work work = {};
};

/// In the order in which they are wanted. What waits for how another one ended is tried after that.
std::vector<Sequence> list_sequences(const std::vector<Trial>& trials, bool rest) {
  std::vector<Sequence> list;
  for (const Trial& trial : trials) {
    if (trial.rest && !rest) continue;
    if (!trial.after_break) list.emplace_back();
    list.back().trials.push_back(trial);
  }
  return list;
}

/// What came of the trials that count.
struct Outcome {
  std::optional<RefineResult> refined;
  bool came_through = false;
};

Outcome first_that_works(const Problem& problem, std::vector<Sequence> list, Crew& crew, Work& work) {
  const int n = static_cast<int>(list.size());
  const int tried = crew.pool.run_until(n, [&](int item, int worker, const Turn& turn) {
    Sequence& sequence = list[static_cast<std::size_t>(item)];
    for (const Trial& trial : sequence.trials) {
      if (trial.after_break && !sequence.last.broke_soon) continue;
      sequence.last = attempt(problem, trial, crew, worker, turn);
      sequence.work += sequence.last.work;
      sequence.came_through = sequence.came_through || sequence.last.came_through;
      if (sequence.last.worked) return item + 1;
    }
    return n;
  });
  Outcome out;
  for (const Sequence& sequence : std::span(list).first(static_cast<std::size_t>(tried))) {
    work += sequence.work;
    out.came_through = out.came_through || sequence.came_through;
  }
  Attempt& last = list[static_cast<std::size_t>(tried) - 1].last;
  if (last.worked) out.refined = std::move(last.refined);
  return out;
}

/// The trials in the order in which they are wanted, up to the one that works.
/// Small steps are wanted most, and take most of the time. What comes to nothing at the steps of the plan seldom works at small ones, so that those come last,
/// and only where the plan was followed to its end, from which feedback leads to the goal, or where they take little.
/// @returns as planning::refine; `out` holds the plan and what became of it, not the counts of before and after
Status run_trials(const std::shared_ptr<const world::Model>& model, const Plan& plan, const PlannerOptions& options,
                  const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out) {
  core::RunControl quiet = control;  // there is no measure of how far a refinement has come
  quiet.on_progress = nullptr;
  Crew crew(model, options.threads > 0 ? options.threads : core::hardware_threads(), quiet);
  Problem problem(model, plan, options, refine_options, quiet);
  Work work;
  const GivenPlan given = look_at_given_plan(problem, crew.of(0), work);
  const auto finish = [&](Status status, std::optional<RefineResult> refined) {
    if (refined) {
      out = std::move(*refined);
    } else {
      keep_given_plan(problem, given, crew.of(0), out, work);
    }
    out.steps = work.steps;
    out.failed_steps = work.failed_steps;
    return status;
  };
  if (!given.reaches_goal) return finish(Status::NumericalFailure, {});
  problem.set_allowed(given.fine.worst);

  const std::vector<Push> pushes = split_at_regrasps(plan);
  std::vector<Push> shorter = pushes;
  if (refine_options.cut_tails) cut_tails(problem.motion, shorter);
  if (refine_options.drop_pushes) drop_pushes(problem.motion, shorter);

  const int cuts = std::max(1, static_cast<int>(std::ceil(plan.step.h / refine_options.h * (1 - 1e-12))));
  const std::vector<Trial> small{{"shortened", &shorter, true, cuts}, {"shortened", &shorter, false, cuts, refine_options.rest}};
  std::vector<Trial> planned = small;
  if (cuts > 1) planned = {{"shortened", &shorter, true, 1}, {"shortened", &shorter, false, 1}};
  if (count_knots(shorter) != count_knots(pushes)) {  // else it is the same again
    for (const bool rest : {true, false}) planned.push_back({"reconnected", &pushes, rest, 1});
  }
  Outcome outcome = first_that_works(problem, list_sequences(planned, refine_options.rest), crew, work);
  bool as_wanted = outcome.refined.has_value();
  const long least = (1L + 2L) * cuts * static_cast<long>(count_knots(shorter));  // steps of a small trial, at whole and half sub-steps
  if (cuts > 1 && (outcome.came_through || problem.cost(least) <= kLittleHope)) {
    Outcome in_small_steps = first_that_works(problem, list_sequences(small, refine_options.rest), crew, work);
    as_wanted = in_small_steps.refined.has_value();
    if (as_wanted) outcome.refined = std::move(in_small_steps.refined);
  }
  const Status status = as_wanted || !control.stop() ? Status::Solved : control.cancelled() ? Status::Cancelled : Status::MaxIterations;
  return finish(status, std::move(outcome.refined));
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
  core::require_positive("refine.mpc_miss", mpc_miss);
  core::require_nonnegative("refine.mpc_work", mpc_work);
  core::require_positive("refine.motionless_position", motionless_position);
  core::require_positive("refine.motionless_angle", motionless_angle);
}

core::Status refine(const std::shared_ptr<const world::Model>& model, const Plan& plan, const PlannerOptions& options,
                    const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out) {
  const auto start = core::RunControl::Clock::now();
  if (!model) core::throw_invalid("model", "nothing", "a model");
  refine_options.validate();
  if (!options.substep) core::throw_invalid("options.substep", "single steps", "a plan in sub-steps");
  if (!options.real_regrasps) core::throw_invalid("options.real_regrasps", "false", "true: jumps cannot be executed");
  world::require_configuration(*model, "plan.q_start", plan.q_start);
  core::require_size("plan.u_start", plan.u_start.size(), model->n_a());
  if (plan.goal.object < 0 || plan.goal.object >= static_cast<int>(model->objects().size()))
    core::throw_invalid("plan.goal.object", std::to_string(plan.goal.object), "the index of an object");
  out.status = refinement::run_trials(model, plan, options, refine_options, control, out);
  refinement::count(plan, out.pushes_before, out.regrasps_before, out.knots_before);
  refinement::count(out.plan, out.pushes, out.regrasps, out.knots);
  out.wall_s = core::seconds_since(start);
  return out.status;
}

}  // namespace stiction::planning
