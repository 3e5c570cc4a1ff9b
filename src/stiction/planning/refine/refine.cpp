#include "stiction/planning/refine.hpp"

#include <algorithm>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/contact_limits.hpp"
#include "stiction/planning/refine/builder.hpp"

namespace stiction::planning {
namespace refinement {
namespace {

using core::Status;

/// Replays the given plan at half of its own sub-steps.
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

/// Makes the given plan the result, with contact forces, which a plan from a file does not have.
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
  core::RunControl quiet = control;  // a refinement has no measure of its progress
  quiet.on_progress = nullptr;
  Problem problem(model, plan, options, refine_options, quiet);
  Scratch scratch(model, quiet);
  Work work;
  const core::RunControl to_the_end;  // the given plan is replayed even if the run was stopped
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
    status = built || !control.stop() ? Status::Solved : control.status_when_stopped();
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
