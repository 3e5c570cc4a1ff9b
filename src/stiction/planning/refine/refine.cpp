#include "stiction/planning/refine.hpp"

#include <string>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/refine/trial_order.hpp"

namespace stiction::planning {
namespace {

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
  count(plan, out.pushes_before, out.regrasps_before, out.knots_before);
  count(out.plan, out.pushes, out.regrasps, out.knots);
  out.wall_s = core::seconds_since(start);
  return out.status;
}

}  // namespace stiction::planning
