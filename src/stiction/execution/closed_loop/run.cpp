#include "stiction/execution/closed_loop/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/closed_loop/commanded_robot.hpp"
#include "stiction/execution/closed_loop/finger_gait.hpp"
#include "stiction/execution/closed_loop/plan_maker.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using planning::SegmentKind;
using world::Model;

/// Fingers stop turning an object that is within this distance of the goal [tolerances of the goal].
constexpr double kThereInHand = 0.85;
/// A robot that does not catch up with its plan within this time is blocked [s].
constexpr double kLongestWait = 2;
/// Objects on joints lag behind their plan by at most this many follow times T_f (E.16).
constexpr double kFollowTimes = 2;

class Executor {
 public:
  Executor(Driver& plant, std::span<const planning::PlanningProblem> goals, const planning::PlannerOptions& planner, const RunOptions& how,
           const core::RunControl& control, RunResult& out)
      : model_(*goals.front().model),
        how_(how),
        out_(out),
        robot_(plant, goals, how, control, out),
        problem_(robot_.problem()),
        source_(problem_, planner, how, robot_.speed()),
        maker_(robot_, source_, model_, how, plant.real_time(), control, out),
        turning_(how.tick) {}

  void go(const planning::Plan* first) {
    if (robot_.begin() && robot_.settle()) bring_to_goals(first);
    robot_.finish();
  }

 private:
  /// Brings the object to all goals, until the last goal holds or the run is over.
  void bring_to_goals(const planning::Plan* first) {
    std::string cause = "start";
    std::optional<Trajectory> trajectory;
    if (first != nullptr) {
      trajectory = source_.take(*first);
      if (!robot_.is_at(trajectory->q.col(0), kThere)) trajectory.reset(), cause = "the given plan starts elsewhere";
    }
    bool had_plan = false;
    while (!robot_.is_over()) {
      if (robot_.is_at_goal()) {
        if (robot_.hold_goal()) {
          if (!robot_.next_goal()) return;
          cause = "the next goal";
          trajectory.reset();
          had_plan = asked_ = false;  // the plan source keeps what it learnt about the plant
          gait_.reset();
          source_.forget_plan();
          continue;
        }
        cause = "the object left the goal";
      } else if (turns_in_hand() && !trajectory) {  // in this order: decided before a given plan moves the object
        cause = turn_in_hand();
      } else {
        const bool is_first = !std::exchange(had_plan, true);
        if (!trajectory && !(trajectory = maker_.make(cause, !is_first))) continue;
        cause = carry_out(*trajectory);
      }
      trajectory.reset();
      if (!robot_.is_over()) robot_.settle();
    }
  }

  // ---- fingers one by one

  /// True if the fingers can turn the object in the hand. Decided at the first call, since an object that fingers already hold would not roll away.
  bool turns_in_hand() {
    if (std::exchange(asked_, true) || !how_.finger_gait) return gait_.has_value();
    gait_.emplace(problem_.model, problem_.goal, how_.friction);
    if (gait_->applies(robot_.rest())) {
      robot_.catch_what_moves();
    } else {
      gait_.reset();
    }
    return gait_.has_value();
  }

  /// Turns the object to its goal with the fingers. @returns why this ended, as the cause of the next plan
  std::string turn_in_hand() {
    gait_->start(robot_.rest());
    robot_.begin_motion({});
    begin_piece(SegmentKind::Contact);
    turning_.begin(robot_.now());
    int finger = -1;
    while (!gait_->has_turned() || robot_.goal_share(robot_.q()) > kThereInHand) {
      const Eigen::VectorXd u = turning_.next(robot_.now(), robot_.u(), [&](double period, Eigen::VectorXd& wanted) {
        (void)gait_->update(robot_.q(), period, wanted);  // after a failed update the fingers that hold keep their commands
        if (gait_->finger() == finger) return;
        finger = gait_->finger();
        end_piece(share_off(gait_->reference()));
        begin_piece(finger >= 0 ? SegmentKind::Regrasp : SegmentKind::Contact);
      });
      if (gait_->stalls() || !robot_.tick(u, gait_->reference()) || robot_.is_displaced() || robot_.has_touched()) break;
    }
    end_piece(share_off(gait_->reference()));
    if (!gait_->stalls()) return "the object left the goal";
    gait_.reset();
    return "the fingers did not turn the object to its goal";
  }

  // ---- pieces

  void begin_piece(SegmentKind kind) {
    robot_.enter(kind == SegmentKind::Regrasp ? RunState::Regrasp : RunState::Push);
    RunPiece& report = out_.pieces.emplace_back();
    report.kind = kind;
    report.plan = static_cast<int>(out_.plans.size()) - 1;
    report.begin_s = robot_.now();
  }

  void end_piece(double off, bool held = true) {
    RunPiece& report = out_.pieces.back();
    report.end_s = robot_.now();
    report.off = off_ = off;
    report.given_up = !held;
  }

  double share_off(const Eigen::VectorXd& q_plan) const { return execution::share_off(model_, q_plan, robot_.q(), problem_.goal); }

  /// Carries out a plan. @returns why this ended, as the cause of the next plan
  std::string carry_out(const Trajectory& trajectory) {
    robot_.begin_motion(trajectory.q);
    robot_.pause();  // computing the trajectory took time
    robot_.enter(RunState::Push);
    if (!robot_.move_to(trajectory.u.col(0))) return {};
    double zero = robot_.now();  // time of the run at which the trajectory begins
    for (const Piece& piece : trajectory.pieces) {
      begin_piece(piece.kind);
      const bool held = follow(trajectory, piece, zero) && arrive(trajectory, piece, zero);
      end_piece(off_, held || robot_.has_touched());
      if (robot_.is_over() || robot_.has_touched()) return {};
      if (!held && robot_.is_displaced()) return "the object was put elsewhere";
      if (!held && waited_ > kLongestWait) return "something held the robot up";
      if (!held)
        return fmt::format("{} was {:.1f} tolerances off its plan", piece.kind == SegmentKind::Regrasp ? "a regrasp" : "a push", off_);
      if (robot_.goal_share(robot_.q()) <= source_.fraction()) return "the goal did not hold";
    }
    return "the plan ended beside the goal";
  }

  static bool is_last(const Trajectory& trajectory, const Piece& piece) { return &piece == &trajectory.pieces.back(); }

  /// Follows a piece of the plan and watches the object. @param zero  time of the run at which the trajectory began, plus the time waited
  bool follow(const Trajectory& trajectory, const Piece& piece, double& zero) {
    const double begin = trajectory.times[piece.first_knot], end = trajectory.times[piece.last_knot];
    const double looked_back = how_.settle_time + kFollowTimes * robot_.follow_time();
    waited_ = 0;
    Eigen::VectorXd u(model_.n_a()), q_plan(model_.n_q());
    while (robot_.now() - zero < end - 0.5 * how_.tick) {
      const double t = std::min(robot_.now() - zero + how_.tick, end);
      interpolate_command(trajectory, t, u);
      interpolate(model_, trajectory, t, q_plan);
      if (!robot_.tick(u, q_plan) || robot_.is_displaced()) return false;
      const double wait = wait_for_robot(q_plan);
      zero += wait, waited_ += wait;
      if (!robot_.looked()) continue;
      if (robot_.has_touched() || waited_ > kLongestWait) return false;
      off_ = share_off_path(model_, trajectory, std::max(begin, t - looked_back), std::min(end, t + how_.watch_interval),
                            how_.watch_interval, robot_.q(), problem_.goal, is_last(trajectory, piece));
      if (off_ > how_.off_on_the_way) return false;
    }
    return true;
  }

  /// Time of a tick for which the plan waits for a robot whose joints are off their path: 0 up to kStray, the whole tick from 2 kStray on [s].        (E.25)
  double wait_for_robot(const Eigen::VectorXd& q_plan) const {
    const Eigen::VectorXd off = (robot_.q() - q_plan).tail(model_.n_a()).cwiseAbs().cwiseQuotient(model_.scales().joints());
    return how_.tick * std::clamp(off.maxCoeff() / kStray - 1, 0.0, 1.0);
  }

  /// Waits until the object is at the end of the piece, at once or after it rests. The rest of the trajectory is delayed by this time.
  bool arrive(const Trajectory& trajectory, const Piece& piece, double& zero) {
    const Eigen::VectorXd q_end = trajectory.q.col(piece.last_knot);
    const auto off = [&](const Eigen::VectorXd& q) {
      return off_ = execution::share_off(model_, q_end, q, problem_.goal, is_last(trajectory, piece));
    };
    if (off(robot_.q()) <= kThere) return true;
    const double begin = robot_.now();
    const Eigen::VectorXd u_end = robot_.u();
    if (!robot_.settle([&] { return robot_.has_touched() || off(robot_.q()) <= kThere; })) return false;
    if (robot_.caught() && !robot_.move_to(u_end)) return false;  // catching moved the fingers
    zero += robot_.now() - begin;
    return off(robot_.rest()) <= how_.off_at_the_end;
  }

  const Model& model_;
  const RunOptions& how_;
  RunResult& out_;
  CommandedRobot robot_;
  const planning::PlanningProblem& problem_;  ///< problem with the current goal
  PlanSource source_;
  PlanMaker maker_;
  std::optional<FingerGait> gait_;
  ChosenCommands turning_;
  bool asked_ = false;  ///< turns_in_hand() was decided
  double off_ = 0;      ///< distance from the path at the last look [tolerances]
  double waited_ = 0;   ///< time waited for the robot in the present piece [s]
};

}  // namespace

Status run(Driver& plant, const planning::PlanningProblem& problem, const planning::PlannerOptions& options, const RunOptions& how,
           const core::RunControl& control, RunResult& out, const planning::Plan* first) {
  return run(plant, std::span(&problem, 1), options, how, control, out, first);
}

Status run(Driver& plant, std::span<const planning::PlanningProblem> goals, const planning::PlannerOptions& options, const RunOptions& how,
           const core::RunControl& control, RunResult& out, const planning::Plan* first) {
  const auto start = core::RunControl::Clock::now();
  how.validate();
  if (goals.empty()) core::throw_invalid("goals", "none", "at least one");
  const auto& model = goals.front().model;
  if (!model) core::throw_invalid("problem.model", "nothing", "a model");
  for (std::size_t i = 0; i < goals.size(); ++i) {
    const std::string name = goals.size() == 1 ? "goal" : fmt::format("goals[{}]", i);
    const int object = goals[i].goal.object;
    if (goals[i].model != model) core::throw_invalid(name, "another model", "that of the first one");
    if (object < 0 || object >= static_cast<int>(model->objects().size()))
      core::throw_invalid(name + ".object", std::to_string(object), "the index of an object");
  }
  if (model->n_a() == 0) core::throw_invalid("problem.model", "no robot", "one that can push");
  options.validate(*model);
  out = RunResult{};
  Executor(plant, goals, options, how, control, out).go(first);
  out.wall_s = core::seconds_since(start);
  out.status = out.end == RunEnd::Reached     ? Status::Solved
               : out.end == RunEnd::Cancelled ? Status::Cancelled
               : out.end == RunEnd::Silent    ? Status::NumericalFailure
                                              : Status::MaxIterations;
  return out.status;
}

}  // namespace stiction::execution
