#include "stiction/planning/refine.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/refine/attempt.hpp"

namespace stiction::planning {
namespace refinement {
namespace {

using core::Status;

/// Where the given plan leads at half the sub-step; its start, if it leads nowhere.
HalfSteps look_at_given_plan(const Problem& problem, Scratch& scratch, Work& work) {
  const Plan& plan = problem.plan;
  HalfSteps fine{.q = plan.q_start, .u = plan.u_start};
  if (!go_on_in_half_steps(problem.press, plan.segments, StepSizes(problem, 1).exact, kAnything, {}, scratch, fine, work))
    fine.q = plan.q_start;
  return fine;
}

/// The given plan is what comes out, with forces: one that was read from a file comes without.
void keep_given_plan(const Problem& problem, const HalfSteps& given, Scratch& scratch, RefineResult& out, Work& work) {
  out = RefineResult{};
  out.plan = problem.plan;
  out.variant = "unchanged";
  Eigen::VectorXd q = out.plan.q_start;
  for (Segment& segment : out.plan.segments) {
    add_forces(problem.model, StepSizes(problem, 1).exact, q, segment, scratch, work);
    if (!segment.knots.empty()) q = segment.knots.back().q;
  }
  out.fine_error = goal_error(problem.model, given.q, problem.plan.goal);
  out.q_fine = given.q;
}

std::size_t count_knots(const std::vector<Push>& pushes) {
  std::size_t n = 0;
  for (const Push& push : pushes) {
    for (const Segment& edge : push.edges) n += edge.knots.size();
  }
  return n;
}

/// Side by side where there are threads. @returns the first in order that works   @param work  of those up to it, counts up
Attempt first_that_works(const Problem& problem, const std::vector<Trial>& trials, Crew& crew, Work& work) {
  const int n = static_cast<int>(trials.size());
  std::vector<Attempt> attempts(trials.size());
  const int tried = crew.pool.run_until(n, [&](int item, int worker, const Turn& turn) {
    Attempt& one = attempts[static_cast<std::size_t>(item)];
    one = attempt(problem, trials[static_cast<std::size_t>(item)], crew, worker, turn);
    return one.worked ? item + 1 : n;
  });
  Attempt out;
  for (Attempt& one : std::span(attempts).first(static_cast<std::size_t>(tried))) {
    work += one.work;
    if (one.worked) out = std::move(one);
  }
  return out;
}

/// The trials in the order in which they are wanted, up to the one that works: in small steps, which plan anew what they leave, then at the steps of the plan.
/// @returns as planning::refine; `out` holds the plan and what became of it, not the counts of before and after
Status run_trials(const std::shared_ptr<const world::Model>& model, const Plan& plan, const PlannerOptions& options,
                  const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out) {
  core::RunControl quiet = control;  // there is no measure of how far a refinement has come
  quiet.on_progress = nullptr;
  Crew crew(model, options.threads > 0 ? options.threads : core::hardware_threads(), quiet);
  Problem problem(model, plan, options, refine_options, quiet);
  Work work;
  const HalfSteps given = look_at_given_plan(problem, crew.of(0), work);
  const auto finish = [&](Status status, Attempt best) {
    if (best.worked) {
      out = std::move(best.refined);
    } else {
      keep_given_plan(problem, given, crew.of(0), out, work);
    }
    out.steps = work.steps;
    out.failed_steps = work.failed_steps;
    return status;
  };
  if (plan.segments.empty() || !problem.reaches_goal(end_of(plan), given.q, 1.0)) return finish(Status::NumericalFailure, {});
  problem.set_allowed(given.worst);

  const std::vector<Push> shorter = problem.shortened(plan);
  const int cuts = std::max(1, static_cast<int>(std::ceil(plan.step.h / refine_options.h * (1 - 1e-12))));
  Attempt best = first_that_works(problem, {{"shortened", &shorter, refine_options.rest, cuts}}, crew, work);
  const bool as_wanted = best.worked;
  if (!best.worked) {
    // Pushes in small steps that cannot end at rest end as they do.
    const auto rests = cuts > 1 && refine_options.rest ? std::vector{true, false} : std::vector{refine_options.rest};
    const std::vector<Push> pushes = split_at_regrasps(plan);
    std::vector<Trial> others;
    const auto add = [&](const char* name, const std::vector<Push>& list) {
      for (const bool rest : rests) others.push_back({name, &list, rest, 1});
    };
    if (cuts > 1) add("shortened", shorter);
    if (count_knots(shorter) != count_knots(pushes)) add("reconnected", pushes);
    best = first_that_works(problem, others, crew, work);
  }
  const Status status = as_wanted || !control.stop() ? Status::Solved : control.cancelled() ? Status::Cancelled : Status::MaxIterations;
  return finish(status, std::move(best));
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
