#include "stiction/planning/refine/given_plan.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "stiction/planning/refine/trial.hpp"

namespace stiction::planning::refinement {
namespace {

Plan with_forces(const Problem& problem, Scratch& scratch, Work& work) {
  Plan out = problem.plan;
  Eigen::VectorXd q = out.q_start;
  const dynamics::StepOptions options = StepSizes(problem, 1).exact;
  dynamics::StepResult& result = scratch.result;
  for (Segment& segment : out.segments) {
    for (dynamics::Knot& knot : segment.knots) {
      knot.contacts.clear();
      ++work.steps;
      if (dynamics::step(problem.model, {q, knot.u}, options, scratch.steps, result) == core::Status::Solved) {
        std::copy_if(result.contacts.begin(), result.contacts.end(), std::back_inserter(knot.contacts),
                     [](const auto& c) { return c.active; });
      } else {
        ++work.failed_steps;
      }
      q = knot.q;
    }
  }
  return out;
}

}  // namespace

GivenPlan look_at_given_plan(const Problem& problem, Scratch& scratch, Work& work) {
  constexpr double kAnything = std::numeric_limits<double>::infinity();
  const Plan& plan = problem.plan;
  GivenPlan given{.fine = {.q = plan.q_start, .u = plan.u_start, .worst = {}}};
  const dynamics::StepOptions exact = StepSizes(problem, 1).exact;
  if (!go_on_in_half_steps(problem, plan.segments, exact, {kAnything, kAnything, kAnything}, {}, scratch, given.fine, work))
    given.fine.q = plan.q_start;
  given.reaches_goal = !plan.segments.empty() && problem.reaches_goal(end_of(plan), given.fine.q, 1.0);
  return given;
}

void keep_given_plan(const Problem& problem, const GivenPlan& given, Scratch& scratch, RefineResult& out, Work& work) {
  out.plan = with_forces(problem, scratch, work);
  out.variant = "unchanged";
  out.fine_error = goal_error(problem.model, given.fine.q, problem.plan.goal);
  out.q_fine = given.fine.q;
}

}  // namespace stiction::planning::refinement
