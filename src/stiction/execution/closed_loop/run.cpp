#include "stiction/execution/closed_loop/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/processor_time.hpp"
#include "stiction/core/random.hpp"
#include "stiction/execution/closed_loop/driver_link.hpp"
#include "stiction/execution/closed_loop/object_watch.hpp"
#include "stiction/execution/open_loop/fall.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using planning::SegmentKind;
using world::Model;

/// Keeps the seeds of later plans apart from the draws of the search.
constexpr std::uint64_t kPlanSeed = 0x9e7a1a11;
/// A piece that ends this near to its plan goes on at once [tolerances of the goal].
constexpr double kThere = 0.3;
/// What has not come to rest after so many windows is taken as it is.
constexpr int kMostWindows = 10;
/// A plan that ends short of the goal is carried out where it leaves at most this share of the way.
constexpr double kGain = 0.8;

/// Of objects that rest on what stops them, those lag behind their plan for some follow times.
constexpr double kFollowTimes = 2;

class Executor {
 public:
  Executor(Driver& plant, const planning::PlanningProblem& problem, const planning::PlannerOptions& planner, const RunOptions& how,
           const core::RunControl& control, RunResult& out)
      : model_(*problem.model),
        link_(plant, model_, how.tick, how.silence),
        problem_(problem),
        planner_(planner),
        how_(how),
        control_(control),
        out_(out),
        speed_(how.speed ? *how.speed : calc_run_speeds(model_, problem.goal.object)),
        lead_(problem.model),
        follow_time_(calc_follow_time(model_, problem.goal.object)),
        window_(how.settle_time + follow_time_),
        watch_(model_, problem.goal, window_, how.settle_time),
        strain_(model_.effort().cwiseQuotient(model_.stiffness())) {
    planner_.tolerance_fraction = std::min(planner_.tolerance_fraction, how.plan_fraction);
  }

  void go(const planning::Plan* first) {
    carry(first);
    finish();
  }

 private:
  // ---- the plant

  bool end(RunEnd what, std::string message = {}) {
    out_.end = what;
    out_.message = std::move(message);
    over_ = true;
    return false;
  }

  double now() const { return measured_.time - start_; }

  bool read() {
    if (!link_.read()) return end(RunEnd::Silent, link_.reason());
    measured_ = link_.measured();
    return true;
  }

  /// u, as far ahead of the joints as their motors can pull.                                                               (E.15)
  Eigen::VectorXd within_motors(const Eigen::VectorXd& u) const {
    const Eigen::VectorXd q_a = measured_.q.tail(model_.n_a());
    return u.cwiseMax(q_a - strain_).cwiseMin(q_a + strain_);
  }

  /// One command, and a look at the objects where it is time for one. False: the run is over.
  bool tick(const Eigen::VectorXd& wanted) {
    if (control_.cancelled()) return end(RunEnd::Cancelled, "interrupted; the robot holds");
    if (control_.expired()) return end(RunEnd::Deadline, "the time for the run is used up");
    if (now() >= how_.duration) return end(RunEnd::TimeUp, fmt::format("the goal was not reached within {:g} s", how_.duration));
    u_ = within_motors(wanted);
    if (!link_.command(u_)) return end(RunEnd::Silent, link_.reason());
    if (!read()) return false;
    if (now() >= next_look_ - 0.5 * how_.tick) look();
    return !over_;
  }

  void look() {
    next_look_ = now() + how_.watch_interval;
    watch_.add(now(), measured_.q);
    looked_ = true;
    record();
    check_fall();
  }

  void record() {
    if (state_ == RunState::Hold || state_ == RunState::Replan) q_plan_ = measured_.q;
    out_.times.push_back(now());
    q_.push_back(measured_.q), planned_.push_back(q_plan_), commands_.push_back(u_);
    out_.piece.push_back(static_cast<int>(out_.pieces.size()) - 1);
    if (!how_.on_sample) return;
    how_.on_sample(
        {now(), state_, measured_.q, q_plan_, u_, out_.piece.back(), static_cast<int>(out_.plans.size()), goal_share(measured_.q)});
  }

  double depth(const Eigen::VectorXd& q, int object) const {
    return world::object_pose(model_, q, object).p.dot(model_.scene().gravity.normalized());
  }

  /// Objects may be as deep as they are, and as what is planned (n_q × knots) has them.
  void set_floor(const Eigen::MatrixXd& planned) {
    floor_.assign(model_.objects().size(), std::numeric_limits<double>::infinity());
    for (int i = 0; i < static_cast<int>(floor_.size()); ++i) {
      const bool free = model_.scene().objects[static_cast<std::size_t>(i)].joint == world::ObjectJoint::Free;
      if (!free || model_.scene().gravity.norm() == 0) continue;
      double lowest = depth(measured_.q, i);
      for (Eigen::Index k = 0; k < planned.cols(); ++k) lowest = std::max(lowest, depth(planned.col(k), i));
      floor_[static_cast<std::size_t>(i)] = lowest + kFall * model_.scales().object(i).length;
    }
  }

  void check_fall() {
    for (int i = 0; i < static_cast<int>(floor_.size()) && !over_; ++i) {
      if (!(floor_[static_cast<std::size_t>(i)] < std::numeric_limits<double>::infinity())) continue;
      if (depth(measured_.q, i) < floor_[static_cast<std::size_t>(i)]) continue;
      out_.dropped = i;
      end(RunEnd::Dropped, fmt::format("'{}' fell", model_.objects()[static_cast<std::size_t>(i)].name));
    }
  }

  // ---- states

  double goal_share(const Eigen::VectorXd& q) const { return planning::goal_error(model_, q, problem_.goal).share(problem_.goal); }

  /// Commands rest until the objects do, or until `there` says at a look that it is near enough.
  template <class There>
  bool settle(const There& there) {
    watch_.forget();
    watch_.add(now(), measured_.q);
    const double begin = now();
    while (now() - begin < kMostWindows * window_) {
      looked_ = false;
      if (!tick(u_)) return false;
      if (!looked_) continue;
      if (watch_.rests()) {
        watch_.forget_motion();
        return true;
      }
      if (there()) return true;
    }
    return true;
  }
  bool settle() {
    state_ = RunState::Hold;
    return settle([] { return false; });
  }

  /// The goal has to hold.
  bool hold_goal() {
    state_ = RunState::Hold;
    const double begin = now();
    while (now() - begin < how_.hold) {
      if (!tick(u_) || goal_share(watch_.mean()) > 1) return false;
    }
    return true;
  }

  /// Commands go straight to u at the speed of pushes.
  bool move_to(const Eigen::VectorXd& u) {
    const Eigen::VectorXd from = u_;
    const double begin = now(), duration = calc_duration(from, u, speed_.push);
    while (now() - begin < duration) {
      if (!tick(from + std::min(1.0, (now() - begin + how_.tick) / duration) * (u - from))) return false;
    }
    return true;
  }

  /// The springs of the robot are let go.
  bool let_go() { return move_to(measured_.q.tail(model_.n_a())) && settle(); }

  /// From when on a plan counts as given: objects within kThere of it, joints as near as a push moves in a look.
  bool starts_here(const Trajectory& trajectory) const {
    const Eigen::VectorXd difference = trajectory.q.col(0).tail(model_.n_a()) - measured_.q.tail(model_.n_a());
    const bool joints = (difference.cwiseAbs().array() <= (speed_.push * how_.watch_interval).array()).all();
    return joints && share_between(model_, problem_.goal.object, trajectory.q.col(0), watch_.mean(), problem_.goal) <= kThere;
  }

  void carry(const planning::Plan* first) {
    if (!read()) return;
    start_ = measured_.time;
    u_ = measured_.u;
    q_plan_ = measured_.q;
    set_floor({});
    look();
    if (!settle()) return;
    std::string cause = "start";
    std::optional<Trajectory> trajectory;
    if (first != nullptr) {
      trajectory = make_trajectory(model_, *first, speed_, &lead_);
      if (!starts_here(*trajectory)) trajectory.reset(), cause = "the given plan starts elsewhere";
    }
    while (!over_) {
      if (is_at_goal()) {
        if (hold_goal()) {
          end(RunEnd::Reached);
          return;
        }
        cause = "the object left the goal";
        trajectory.reset();
        if (!over_) settle();
      } else if (trajectory || (may_plan() && (trajectory = make_plan(cause)))) {
        has_plan_ = true;
        cause = carry_out(*trajectory);
        trajectory.reset();
        if (!over_) settle();
      }
    }
  }

  bool is_at_goal() const { return goal_share(watch_.mean()) <= 1; }

  // ---- plans

  /// Every plan after the first counts, whatever calls for it. False: they are used up, and the run is over.
  bool may_plan() {
    if (!has_plan_) return has_plan_ = true;
    if (out_.replans == how_.replans) return end(RunEnd::Replans, fmt::format("the goal was not reached with {} replans", out_.replans));
    ++out_.replans;
    return true;
  }

  /// From what is measured; where there is none the springs are let go, and it is asked again, now with the friction of the scene: a place may be left by
  /// no push that holds with less.
  /// @returns nothing: the run is over, or the object came to its goal as the springs were let go
  std::optional<Trajectory> make_plan(const std::string& cause) {
    for (int refused = 0; refused < how_.refusals; ++refused) {
      if (refused > 0 && (!let_go() || is_at_goal())) return std::nullopt;
      planning::PlanResult result;
      ask_planner(refused == 0 ? cause : "no plan from where springs were strained", refused == 0 ? how_.friction : 1, result);
      if (control_.stop()) {
        end(control_.cancelled() ? RunEnd::Cancelled : RunEnd::Deadline, "stopped while planning; the robot holds");
        return std::nullopt;
      }
      const bool gains = result.plan.error.share(problem_.goal) <= kGain * goal_share(watch_.mean());
      const bool moves = std::any_of(result.plan.segments.begin(), result.plan.segments.end(),
                                     [](const auto& s) { return s.kind != SegmentKind::Settle && !s.knots.empty(); });
      if (!out_.first_plan) out_.first_plan = result;
      if (moves && (result.status == Status::Solved || gains)) return make_trajectory(model_, result.plan, speed_, &lead_);
    }
    const std::string& reason = out_.plans.back().reason;
    end(RunEnd::NoPlan, fmt::format("{} plans in a row failed{}", how_.refusals, reason.empty() ? "" : ": " + reason));
    return std::nullopt;
  }

  /// @param friction  every μ of the plan times this
  void ask_planner(const std::string& cause, double friction, planning::PlanResult& result) {
    state_ = RunState::Replan;
    planning::PlanningProblem problem = problem_;
    problem.q_start = watch_.mean();
    planning::PlannerOptions options = planner_;
    options.friction *= friction;
    if (const std::size_t n = out_.plans.size(); n > 0) options.seed = core::Random(planner_.seed ^ kPlanSeed, n).bits();
    core::RunControl control = control_;
    const auto budget = core::RunControl::Clock::now() +
                        std::chrono::duration_cast<core::RunControl::Clock::duration>(std::chrono::duration<double>(how_.plan_timeout));
    control.deadline = control_.deadline ? std::min(*control_.deadline, budget) : budget;
    const double before = core::processor_time();
    if (how_.plan_processor_time) {
      control.abandoned = [this, before] {
        return (control_.abandoned && control_.abandoned()) || core::processor_time() - before > *how_.plan_processor_time;
      };
    }
    result.status = planning::plan_from(problem, u_, options, control, result);
    if (result.status == Status::Cancelled && !control_.cancelled()) result.status = Status::MaxIterations;
    out_.plans.push_back({now(), result.wall_s, core::processor_time() - before, result.status, cause, result.reason});
    out_.planning_s += result.wall_s;
    link_.pause();
  }

  // ---- pieces

  /// @returns why it ended, for the next plan
  std::string carry_out(const Trajectory& trajectory) {
    set_floor(trajectory.q);
    link_.pause();  // the trajectory took its time
    state_ = RunState::Push;
    if (!move_to(trajectory.u.col(0))) return {};
    double zero = now();  // of the trajectory
    for (const Piece& piece : trajectory.pieces) {
      RunPiece& report = out_.pieces.emplace_back();
      report.kind = piece.kind;
      report.plan = static_cast<int>(out_.plans.size()) - 1;
      report.begin_s = now();
      state_ = piece.kind == SegmentKind::Regrasp ? RunState::Regrasp : RunState::Push;
      const bool held = follow(trajectory, piece, zero) && arrive(trajectory, piece, zero);
      report.end_s = now();
      report.off = off_;
      report.given_up = !held;
      if (over_) return {};
      if (!held)
        return fmt::format("{} was {:.1f} tolerances off its plan", piece.kind == SegmentKind::Regrasp ? "a regrasp" : "a push", off_);
      if (goal_share(measured_.q) <= planner_.tolerance_fraction) return "the goal did not hold";
    }
    return "the plan ended beside the goal";
  }

  /// A piece in time, watched. @param zero  time of the run at which the trajectory began
  bool follow(const Trajectory& trajectory, const Piece& piece, double zero) {
    const double begin = trajectory.times[piece.first_knot], end = trajectory.times[piece.last_knot];
    const double looked_back = how_.settle_time + kFollowTimes * follow_time_;
    Eigen::VectorXd u(model_.n_a());
    while (now() - zero < end - 0.5 * how_.tick) {
      const double t = std::min(now() - zero + how_.tick, end);
      interpolate_command(trajectory, t, u);
      interpolate(model_, trajectory, t, q_plan_);
      looked_ = false;
      if (!tick(u)) return false;
      if (!looked_) continue;
      off_ = share_off_path(model_, trajectory, std::max(begin, t - looked_back), std::min(end, t + how_.watch_interval),
                            how_.watch_interval, measured_.q, problem_.goal);
      if (off_ > how_.off_on_the_way) return false;
    }
    return true;
  }

  /// The object is where the piece ends, at once or once it rests; the rest of the trajectory comes later by as much.
  bool arrive(const Trajectory& trajectory, const Piece& piece, double& zero) {
    const Eigen::VectorXd q_end = trajectory.q.col(piece.last_knot);
    const auto off = [&](const Eigen::VectorXd& q) { return off_ = share_between(model_, problem_.goal.object, q_end, q, problem_.goal); };
    if (off(measured_.q) <= kThere) return true;
    const double begin = now();
    if (!settle([&] { return off(measured_.q) <= kThere; })) return false;
    zero += now() - begin;
    return off(watch_.mean()) <= how_.off_at_the_end;
  }

  // ---- the end

  void finish() {
    const auto n = static_cast<Eigen::Index>(q_.size());
    out_.q.resize(model_.n_q(), n), out_.q_plan.resize(model_.n_q(), n), out_.u.resize(model_.n_a(), n);
    for (Eigen::Index k = 0; k < n; ++k) {
      out_.q.col(k) = q_[static_cast<std::size_t>(k)];
      out_.q_plan.col(k) = planned_[static_cast<std::size_t>(k)];
      out_.u.col(k) = commands_[static_cast<std::size_t>(k)];
    }
    if (n > 0) {
      out_.error = planning::goal_error(model_, watch_.mean(), problem_.goal);
      out_.duration_s = out_.times.back();
    }
  }

  const Model& model_;
  DriverLink link_;
  const planning::PlanningProblem& problem_;
  planning::PlannerOptions planner_;
  const RunOptions& how_;
  const core::RunControl& control_;
  RunResult& out_;
  RunSpeeds speed_;
  DragFeedforward lead_;
  double follow_time_, window_;
  ObjectWatch watch_;
  Eigen::VectorXd strain_;  ///< that a motor bears at most (n_a)

  Measurement measured_;
  double start_ = 0;  ///< of the run, by the clock of the plant
  double next_look_ = 0;
  bool looked_ = false;  ///< in the last tick
  bool over_ = false;
  bool has_plan_ = false;  ///< one was given or asked for
  RunState state_ = RunState::Hold;
  double off_ = 0;  ///< of the last look, in tolerances
  Eigen::VectorXd u_, q_plan_;
  std::vector<double> floor_;  ///< per object: how deep it may be
  std::vector<Eigen::VectorXd> q_, planned_, commands_;
};

}  // namespace

Status run(Driver& plant, const planning::PlanningProblem& problem, const planning::PlannerOptions& options, const RunOptions& how,
           const core::RunControl& control, RunResult& out, const planning::Plan* first) {
  const auto start = core::RunControl::Clock::now();
  how.validate();
  if (!problem.model) core::throw_invalid("problem.model", "nothing", "a model");
  if (problem.goal.object < 0 || problem.goal.object >= static_cast<int>(problem.model->objects().size()))
    core::throw_invalid("goal.object", std::to_string(problem.goal.object), "the index of an object");
  if (problem.model->n_a() == 0) core::throw_invalid("problem.model", "no robot", "one that can push");
  options.validate(*problem.model);
  out = RunResult{};
  Executor(plant, problem, options, how, control, out).go(first);
  out.wall_s = core::seconds_since(start);
  out.status = out.end == RunEnd::Reached     ? Status::Solved
               : out.end == RunEnd::Cancelled ? Status::Cancelled
               : out.end == RunEnd::Silent    ? Status::NumericalFailure
                                              : Status::MaxIterations;
  return out.status;
}

}  // namespace stiction::execution
