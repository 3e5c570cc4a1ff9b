#include "stiction/planning/carry.hpp"

#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/processor_time.hpp"
#include "stiction/planning/refine/builder.hpp"
#include "stiction/planning/refine/shift_plan.hpp"
#include "stiction/planning/settle_start.hpp"

namespace stiction::planning {
namespace refinement {
namespace {

using core::Status;

/// The state from which the plan is to go on, until its objects rest. nullopt: they do not, and the reason says why.
std::optional<Trace> settle(const std::shared_ptr<const world::Model>& model, const CarriedTo& to, const PlannerOptions& options,
                            const core::RunControl& control, CarryResult& out) {
  const Setting setting({.model = model, .q_start = to.q, .goal = to.goal, .q_goal = {}}, options);
  ThreadScratch scratch(model, control);
  Totals totals;
  PlanResult result;
  std::optional<Trace> at = settle_start(setting, to.u, scratch, totals, result);
  out.reason = result.reason;
  out.steps += totals.steps;
  return at;
}

Status run(const std::shared_ptr<const world::Model>& model, const Plan& plan, const CarriedTo& to, const PlannerOptions& options,
           const RefineOptions& refine_options, const core::RunControl& control, CarryResult& out) {
  core::RunControl quiet = control;  // there is no measure of how far it has come
  quiet.on_progress = nullptr;
  const auto ended = [&] {
    return control.cancelled() ? Status::Cancelled : control.stop() ? Status::MaxIterations : Status::NumericalFailure;
  };
  const std::optional<Trace> at = settle(model, to, options, quiet, out);
  if (!at) return ended();
  Plan shifted = shift_plan(*model, plan, to.shifts);
  shifted.goal = to.goal;
  Problem problem(model, shifted, options, refine_options, quiet);
  Scratch scratch(model, quiet);
  Builder builder(problem, scratch, RegraspOrder::AsPlanned);
  const bool built = builder.build_from(to.q, at->u, at->knots);
  out.steps += builder.work().steps;
  out.reason = builder.reason();
  if (!built) return ended();
  RefineResult refined = builder.result();
  out.plan = std::move(refined.plan);
  out.reconnected = refined.reconnected;
  out.rest_planned_anew = refined.rest_planned_anew;
  SegmentKind before = SegmentKind::Settle;
  for (const Segment& segment : out.plan.segments) {
    out.regrasps += segment.kind == SegmentKind::Regrasp && before != SegmentKind::Regrasp;
    out.pushes += segment.kind == SegmentKind::Contact && before != SegmentKind::Contact;
    before = segment.kind;
  }
  return Status::Solved;
}

}  // namespace
}  // namespace refinement

RefineOptions keep_plan(const Plan& plan) {
  RefineOptions out;
  out.drop_pushes = out.cut_tails = false;
  out.h = plan.step.h;
  out.extensions = 0;
  return out;
}

core::Status carry(const std::shared_ptr<const world::Model>& model, const Plan& plan, const CarriedTo& to, const PlannerOptions& options,
                   const RefineOptions& refine_options, const core::RunControl& control, CarryResult& out) {
  const auto start = core::RunControl::Clock::now();
  const double before = core::processor_time();
  if (!model) core::throw_invalid("model", "nothing", "a model");
  refine_options.validate();
  options.validate(*model);
  world::require_configuration(*model, "plan.q_start", plan.q_start);
  world::require_configuration(*model, "to.q", to.q);
  core::require_size("to.u", to.u.size(), model->n_a());
  if (plan.segments.empty()) core::throw_invalid("plan.segments", "none", "a plan that leads somewhere");
  if (to.goal.object < 0 || to.goal.object >= static_cast<int>(model->objects().size()))
    core::throw_invalid("to.goal.object", std::to_string(to.goal.object), "the index of an object");
  out = {};
  out.status = refinement::run(model, plan, to, options, refine_options, control, out);
  out.processor_s = core::processor_time() - before;
  out.wall_s = core::seconds_since(start);
  return out.status;
}

}  // namespace stiction::planning
