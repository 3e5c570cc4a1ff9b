#include "stiction/planning/refine/half_steps.hpp"

#include <algorithm>

#include "stiction/planning/force_gap.hpp"

namespace stiction::planning::refinement {

bool go_on_in_half_steps(const Problem& problem, std::span<const Segment> segments, const dynamics::StepOptions& options,
                         const Worst& allowed, const core::RunControl& control, Scratch& scratch, HalfSteps& at, Work& work) {
  const world::Model& model = problem.model;
  scratch.half_steps.forget();
  for (const Segment& segment : segments) {
    for (const auto& knot : segment.knots) {
      if (control.stop()) return false;
      for (const Eigen::VectorXd& u : {Eigen::VectorXd(0.5 * (at.u + knot.u)), knot.u}) {
        ++work.steps;
        if (dynamics::step(model, {at.q, u}, options, scratch.half_steps, scratch.half_result) != core::Status::Solved) {
          ++work.failed_steps;
          return false;
        }
        if (at.started) at.worst.penetration = std::max(at.worst.penetration, calc_penetration(model, scratch.half_result));
        at.worst.force_gap =
            std::max(at.worst.force_gap, calc_force_gap(model, scratch.half_result.q_next, scratch.half_result.contacts, scratch.geometry));
        at.worst.press = std::max(at.worst.press, problem.press.share(scratch.half_result.contacts, options.h));
        at.started = true;
        at.q = scratch.half_result.q_next;
        if (at.worst.penetration > allowed.penetration || at.worst.force_gap > allowed.force_gap || at.worst.press > allowed.press)
          return false;
      }
      at.u = knot.u;
    }
  }
  if (at.started)
    at.worst.penetration = std::max(at.worst.penetration, calc_penetration(model, at.q, scratch.geometry));  // no step has looked
  return at.worst.penetration <= allowed.penetration;
}

}  // namespace stiction::planning::refinement
