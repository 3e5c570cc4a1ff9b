#include "stiction/execution/closed_loop/plan_source.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/core/processor_time.hpp"
#include "stiction/core/random.hpp"
#include "stiction/execution/closed_loop/plan_join.hpp"
#include "stiction/planning/thresholds.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using planning::SegmentKind;

/// Keeps the seeds of later plans apart from the draws of the search.
constexpr std::uint64_t kPlanSeed = 0x9e7a1a11;
/// A plan that ends short of the goal is carried out if it leaves at most this share of the distance.
constexpr double kGain = 0.8;
/// A plan is continued at most this often without the object coming nearer to the goal by kNearer tolerances: otherwise something blocks it.
constexpr int kJoinsInVain = 2;
constexpr double kNearer = 1;

/// Least number of extensions in a short search.
constexpr long kLeastSearch = 200;

bool moves(const planning::Plan& plan) {
  return std::any_of(plan.segments.begin(), plan.segments.end(),
                     [](const auto& s) { return s.kind != SegmentKind::Settle && !s.knots.empty(); });
}

}  // namespace

PlanSource::PlanSource(const planning::PlanningProblem& problem, const planning::PlannerOptions& options, const RunOptions& how,
                       const RunSpeeds& speed)
    : problem_(problem), options_(options), how_(how), speed_(speed), lead_(problem.model), enough_(options.tolerance_fraction) {
  options_.tolerance_fraction = std::min(options_.tolerance_fraction, how.plan_fraction);
}

Answer PlanSource::ask(const Question& question, const core::RunControl& control) {
  Answer out;
  const double before = core::processor_time();
  if (!join(question, out)) {
    search(question, control, out.result);
    judge(question, out);
  }
  out.processor_s = core::processor_time() - before;
  if (how_.planning_rate > 0) {
    const auto steps = static_cast<double>(out.result.steps + out.result.linearisations + out.join_steps);
    out.charge_s = (how_.plan_step_time ? steps * *how_.plan_step_time : out.processor_s) / how_.planning_rate;
  }
  if (!out.joined) {
    thought_ += out.charge_s, ++searches_;
    nearest_ = std::numeric_limits<double>::infinity(), in_vain_ = 0;
  }
  return out;
}

double PlanSource::share(const Eigen::VectorXd& q) const {
  return planning::goal_error(*problem_.model, q, problem_.goal).share(problem_.goal);
}

/// Keeps the plan of a search if it is worth carrying out: it reaches the goal or, after a search that was not short, comes nearer to it.
void PlanSource::judge(const Question& from, Answer& out) {
  const planning::Plan& plan = out.result.plan;
  const bool gains = !from.is_short && plan.error.share(problem_.goal) <= kGain * share(from.q);
  out.slips = out.result.start_slips;
  if (moves(plan) && (out.result.status == Status::Solved || gains)) {
    out.trajectory = take(plan);
    durations_ += out.trajectory->duration(), shares_ += share(from.q);
    ++found_, usual_ = out.result.iterations;
  }
}

void PlanSource::forget_plan() {
  last_.reset();
  nearest_ = std::numeric_limits<double>::infinity(), in_vain_ = 0;
}

Trajectory PlanSource::take(const planning::Plan& plan) {
  Trajectory out = make_trajectory(*problem_.model, plan, speed_, &lead_);
  last_ = plan;
  return out;
}

/// Expected time of a new plan from q, from earlier plans [s]: for the search, and for the execution in proportion to the distance.
double PlanSource::expected_time(const Eigen::VectorXd& q) const {
  if (searches_ == 0 || shares_ <= 0) return std::numeric_limits<double>::infinity();
  return thought_ / static_cast<double>(searches_) + share(q) * durations_ / shares_;
}

/// True if the object came nearer to the goal since the plan was last continued, or if the plan was not yet continued in vain too often.
bool PlanSource::came_nearer(const Eigen::VectorXd& q) {
  const double here = share(q);
  const bool nearer = here < nearest_ - kNearer;
  nearest_ = std::min(nearest_, here);
  in_vain_ = nearer ? 0 : in_vain_ + 1;
  return in_vain_ <= kJoinsInVain;
}

/// Continues the current plan. @returns false if it does not lead to the goal, or takes longer than a new plan is expected to
bool PlanSource::join(const Question& from, Answer& out) {
  if (!how_.join || !last_) return false;
  if (last_->step.friction_scale != options_.step_options(*problem_.model).friction_scale * from.friction) return false;
  if (!came_nearer(from.q)) return false;
  const auto start = core::RunControl::Clock::now();
  Join join = join_plan(problem_.model, *last_, from.q, from.u, {.enough = fraction()});
  out.join_steps = join.steps;
  if (join.status != Status::Solved) return false;
  Trajectory trajectory = make_trajectory(*problem_.model, join.plan, speed_, &lead_);
  if (trajectory.duration() > expected_time(from.q)) return false;
  last_ = join.plan;
  out.joined = true;
  out.trajectory = std::move(trajectory);
  out.result.status = Status::Solved;
  out.result.plan = std::move(join.plan);
  out.result.seed = options_.seed;
  out.result.wall_s = core::seconds_since(start);
  return true;
}

void PlanSource::search(const Question& from, const core::RunControl& run, planning::PlanResult& out) const {
  planning::PlanningProblem problem = problem_;
  problem.q_start = from.q;
  problem.start_may_move = how_.off_at_the_end;
  planning::PlannerOptions options = options_;
  options.friction *= from.friction;
  if (from.is_short && found_ > 0)
    options.max_iterations = static_cast<int>(std::min<long>(options.max_iterations, std::max(kLeastSearch, 2 * usual_)));
  if (from.number > 0) options.seed = core::Random(options_.seed ^ kPlanSeed, from.number).bits();
  core::RunControl control = run;
  const auto budget = core::RunControl::Clock::now() +
                      std::chrono::duration_cast<core::RunControl::Clock::duration>(std::chrono::duration<double>(how_.plan_timeout));
  control.deadline = run.deadline ? std::min(*run.deadline, budget) : budget;
  double limit = how_.plan_processor_time.value_or(std::numeric_limits<double>::infinity());
  if (how_.planning_rate > 0 && !how_.plan_step_time) limit = std::min(limit, from.time_left * how_.planning_rate);
  // A plan within the tolerances will do if many more extensions find none within plan_fraction of them, which leaves room for errors.
  long within = -1;
  bool will_do = false;
  control.on_progress = [&](const core::Progress& progress) {
    if (run.on_progress) run.on_progress(progress);
    if (within < 0 && progress.best <= enough_) within = progress.iteration;
    will_do =
        within >= 0 && progress.iteration > within + std::max(planning::threshold::kLeastPatience, planning::threshold::kPatience * within);
  };
  control.abandoned = [&, before = core::processor_time()] {
    return (run.abandoned && run.abandoned()) || will_do || (std::isfinite(limit) && core::processor_time() - before > limit);
  };
  out.status = planning::plan_from(problem, from.u, options, control, out);
  if (out.status == Status::Cancelled && !run.cancelled()) out.status = Status::MaxIterations;
  if (will_do && out.plan.error.share(problem.goal) <= enough_) out.status = Status::Solved;
}

}  // namespace stiction::execution
