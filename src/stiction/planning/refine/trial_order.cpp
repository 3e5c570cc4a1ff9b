#include "stiction/planning/refine/trial_order.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "stiction/planning/refine/given_plan.hpp"

namespace stiction::planning::refinement {
namespace {

using core::Status;

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

}  // namespace

Status run_trials(const std::shared_ptr<const world::Model>& model, const Plan& plan, const PlannerOptions& options,
                  const RefineOptions& refine_options, const core::RunControl& control, RefineResult& out) {
  core::RunControl quiet = control;  // there is no measure of how far a refinement has come
  quiet.on_progress = nullptr;
  Crew crew(model, options.threads > 0 ? options.threads : core::hardware_threads());
  for (Scratch& scratch : crew.scratch) scratch.geometry.control = &quiet;
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

}  // namespace stiction::planning::refinement
