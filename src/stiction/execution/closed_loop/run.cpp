#include "stiction/execution/closed_loop/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <thread>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/closed_loop/active_hold.hpp"
#include "stiction/execution/closed_loop/driver_link.hpp"
#include "stiction/execution/closed_loop/finger_gait.hpp"
#include "stiction/execution/closed_loop/object_watch.hpp"
#include "stiction/execution/closed_loop/plan_source.hpp"
#include "stiction/execution/closed_loop/step_back.hpp"
#include "stiction/execution/open_loop/fall.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using planning::SegmentKind;
using world::Model;

/// A piece that ends this near to its plan goes on at once [tolerances of the goal].
constexpr double kThere = 0.3;
/// The fingers of a hand have turned an object far enough [tolerances of the goal].
constexpr double kThereInHand = 0.85;
/// What has not come to rest after so many windows is taken as it is.
constexpr int kMostWindows = 10;
/// An object that comes this far while commands rest is caught [tolerances of the goal].
constexpr double kLeaves = 0.2;
/// Between two looks of the active hold [s].
constexpr double kHoldPeriod = 0.01;

/// Of objects that rest on what stops them, those lag behind their plan for some follow times.
constexpr double kFollowTimes = 2;

class Executor {
 public:
  Executor(Driver& plant, std::span<const planning::PlanningProblem> goals, const planning::PlannerOptions& planner, const RunOptions& how,
           const core::RunControl& control, RunResult& out)
      : model_(*goals.front().model),
        link_(plant, model_, how.tick, how.silence, how.absence),
        real_time_(plant.real_time()),
        goals_(goals),
        problem_(goals.front()),
        how_(how),
        control_(control),
        out_(out),
        speed_(make_speeds()),
        source_(problem_, planner, how, speed_),
        follow_time_(calc_follow_time(model_, problem_.goal.object)),
        window_(how.settle_time + follow_time_),
        watch_(model_, problem_.goal, window_, how.settle_time),
        strain_(model_.effort().cwiseQuotient(model_.stiffness())) {
    if (how.active_hold) catch_what_moves();
  }

  void go(const planning::Plan* first) {
    carry(first);
    finish();
  }

 private:
  // ---- the plant

  bool end(RunEnd what, std::string message = {}) {
    const bool names_goal = goals_.size() > 1 && what != RunEnd::Reached;
    out_.end = what;
    out_.message = names_goal ? fmt::format("goal {} of {}: {}", goal_ + 1, goals_.size(), message) : std::move(message);
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
    if (now() >= how_.duration)
      return end(RunEnd::TimeUp,
                 fmt::format("{} within {:g} s", goals_.size() > 1 ? "not reached" : "the goal was not reached", how_.duration));
    u_ = within_motors(wanted);
    if (!link_.command(u_)) return end(RunEnd::Silent, link_.reason());
    if (!read()) return false;
    if (link_.take_displaced()) {
      displaced_ = true;
      set_floor({});
    }
    if (now() >= next_look_ - 0.5 * how_.tick) look();
    return !over_;
  }

  /// A command of a robot that has nothing to carry out: it rests as long as the object does.
  bool hold_tick() {
    if (!hold_) return tick(u_);
    if (!holds_) {
      holds_ = calm_ = true;
      q_held_ = measured_.q;
      hold_->start(q_held_);
    }
    if (calm_ && share_between(model_, q_held_, measured_.q, problem_.goal) > kLeaves) calm_ = false, next_hold_ = now();
    if (calm_) return tick(u_);
    if (now() >= next_hold_ - 0.5 * how_.tick) {
      const double period = std::max(kHoldPeriod, how_.tick);
      next_hold_ = now() + period;
      Eigen::VectorXd wanted = u_;
      (void)hold_->update(measured_.q, period, wanted);  // where it finds nothing the command stays
      step_ = (wanted - u_) * (how_.tick / period);
    }
    caught_ = true;
    return tick(u_ + step_);
  }

  void look() {
    next_look_ = now() + how_.watch_interval;
    if (measured_.object_time > seen_time_) watch_.add(now(), measured_.q);  // poses that stay away say nothing of rest
    if (how_.hold == 0 && !touch_ && measured_.object_time > seen_time_ && goal_share(measured_.q) <= 1) touch_ = {now(), measured_.q};
    seen_time_ = measured_.object_time;
    looked_ = true;
    record();
    check_fall();
    if (touch_ && is_last_goal() && !over_) next_goal();
  }

  void record() {
    if (state_ == RunState::Hold || state_ == RunState::Replan) q_plan_ = measured_.q;
    out_.times.push_back(now());
    q_.push_back(measured_.q), planned_.push_back(q_plan_), commands_.push_back(u_);
    out_.piece.push_back(static_cast<int>(out_.pieces.size()) - 1);
    if (!how_.on_sample) return;
    how_.on_sample({now(), state_, measured_.q, q_plan_, u_, out_.piece.back(), static_cast<int>(out_.plans.size()),
                    goal_share(measured_.q), static_cast<int>(goal_)});
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
    while (!link_.sees_objects()) {
      if (!tick(u_)) return false;
    }
    watch_.forget();
    watch_.add(now(), measured_.q);
    const double begin = now();
    while (now() - begin < kMostWindows * window_ || (watch_.is_carried() && now() - begin < how_.absence)) {
      looked_ = false;
      if (!hold_tick()) return false;
      if (!looked_) continue;
      if (const double slow = kThere / thinking_time(); watch_.rests(slow)) {
        watch_.forget_motion(slow);
        holds_ = false;
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
      if (!hold_tick() || goal_share(watch_.mean()) > 1) return false;
    }
    return true;
  }

  /// Commands go straight to u at the speed of pushes.
  bool move_to(const Eigen::VectorXd& u) {
    holds_ = caught_ = false;
    const Eigen::VectorXd from = u_;
    const double begin = now(), duration = calc_duration(from, u, speed_.push);
    while (now() - begin < duration) {
      if (!tick(from + std::min(1.0, (now() - begin + how_.tick) / duration) * (u - from))) return false;
    }
    return true;
  }

  /// The springs of the robot are let go.
  bool let_go() { return move_to(measured_.q.tail(model_.n_a())) && settle(); }

  /// … and where that was no help, the robot steps back from what stands by itself.
  bool step_back() {
    for (const Eigen::VectorXd& posture : find_step_back(model_, measured_.q)) {
      if (!move_to(posture)) return false;
    }
    return settle();
  }

  /// The object is within so many tolerances of q, the joints as near as a push moves in a look: a plan from q can begin.
  bool is_at(const Eigen::VectorXd& q, double near) const {
    const Eigen::VectorXd difference = q.tail(model_.n_a()) - measured_.q.tail(model_.n_a());
    const bool joints = (difference.cwiseAbs().array() <= (speed_.push * how_.watch_interval).array()).all();
    return joints && share_between(model_, q, watch_.mean(), problem_.goal) <= near;
  }

  void carry(const planning::Plan* first) {
    if (!read()) return;
    start_ = measured_.time;
    u_ = measured_.u;
    q_plan_ = measured_.q;
    set_floor({});
    out_.goals.push_back({});
    look();
    if (!settle()) return;
    std::string cause = "start";
    std::optional<Trajectory> trajectory;
    if (first != nullptr) {
      trajectory = source_.take(*first);
      if (!is_at(trajectory->q.col(0), kThere)) trajectory.reset(), cause = "the given plan starts elsewhere";
    }
    while (!over_) {
      if (touch_ || is_at_goal()) {
        if (hold_goal()) {
          next_goal();
          cause = "the next goal";
          continue;
        }
        cause = "the object left the goal";
        trajectory.reset();
        if (!over_) settle();
      } else if (!trajectory && turns_in_hand()) {
        cause = turn_in_hand();
        if (!over_) settle();
      } else if (trajectory || (may_plan() && (trajectory = make_plan(cause)))) {
        has_plan_ = true;
        cause = carry_out(*trajectory);
        trajectory.reset();
        if (!over_) settle();
      }
    }
  }

  // ---- goals in a row

  RunSpeeds make_speeds() const { return how_.speed ? *how_.speed : calc_run_speeds(model_, problem_.goal.object, how_.speed_factor); }

  bool is_last_goal() const { return goal_ + 1 == goals_.size(); }

  void leave_goal(bool reached) {
    RunGoal& goal = out_.goals.back();
    goal.reached = reached;
    goal.end_s = touch_ ? touch_->time : now();
    goal.replans = out_.replans - replans_before_;
    goal.error = planning::goal_error(model_, touch_ ? touch_->q : watch_.mean(), problem_.goal);
  }

  /// Things went on moving since the goal before was reached: where they came through counts.
  void look_back(double since) {
    for (std::size_t k = 0; k < q_.size() && !touch_; ++k) {
      if (out_.times[k] > since && goal_share(q_[k]) <= 1) touch_ = {out_.times[k], q_[k]};
    }
  }

  /// The goal is reached: the next one is aimed at from where things are, or the run is over. What was learnt of the plant stays.
  void next_goal() {
    leave_goal(true);
    if (is_last_goal()) {
      end(RunEnd::Reached);
      return;
    }
    const int object = problem_.goal.object;
    ++goal_;
    problem_.goal = goals_[goal_].goal, problem_.q_goal = goals_[goal_].q_goal;
    RunGoal next;
    next.begin_s = out_.goals.back().end_s;
    out_.goals.push_back(next);
    touch_.reset();
    replans_before_ = out_.replans;
    has_plan_ = asked_ = false;
    gait_.reset();
    source_.forget_plan();
    if (how_.hold == 0) look_back(out_.goals.back().begin_s);
    if (problem_.goal.object == object) return;
    speed_ = make_speeds();
    follow_time_ = calc_follow_time(model_, problem_.goal.object);
    window_ = how_.settle_time + follow_time_;
    watch_.set_window(window_);
    hold_.reset();
    if (how_.active_hold) catch_what_moves();
  }

  // ---- fingers one by one

  void catch_what_moves() {
    hold_.emplace(problem_.model, problem_.goal.object, how_.friction);
    if (!hold_->applies()) hold_.reset();
  }

  /// Decided where this is first asked: what fingers have hold of does not roll away.
  bool turns_in_hand() {
    if (std::exchange(asked_, true) || !how_.finger_gait) return gait_.has_value();
    gait_.emplace(problem_.model, problem_.goal, how_.friction);
    if (gait_->applies(watch_.mean())) {
      catch_what_moves();
    } else {
      gait_.reset();
    }
    return gait_.has_value();
  }

  /// The fingers turn the object to its goal. @returns why that ended, for the next plan
  std::string turn_in_hand() {
    const double period = std::max(kHoldPeriod, how_.tick);
    gait_->start(watch_.mean());
    set_floor({});
    displaced_ = false;
    begin_piece(SegmentKind::Contact);
    next_hold_ = now();
    int finger = -1;
    while (!gait_->has_turned() || goal_share(measured_.q) > kThereInHand) {
      if (now() >= next_hold_ - 0.5 * how_.tick) {
        next_hold_ = now() + period;
        Eigen::VectorXd wanted = u_;
        (void)gait_->update(measured_.q, period, wanted);  // where it finds nothing the fingers that hold stay
        step_ = (wanted - u_) * (how_.tick / period);
        q_plan_ = gait_->reference();
        if (gait_->finger() != finger) {
          finger = gait_->finger();
          end_piece();
          begin_piece(finger >= 0 ? SegmentKind::Regrasp : SegmentKind::Contact);
        }
      }
      if (gait_->stalls() || !tick(u_ + step_) || is_displaced() || touch_) break;
    }
    end_piece();
    holds_ = false;
    const bool stalls = gait_->stalls();
    if (stalls) gait_.reset();
    return stalls ? "the fingers did not turn the object to its goal" : "the object left the goal";
  }

  void begin_piece(SegmentKind kind) {
    state_ = kind == SegmentKind::Regrasp ? RunState::Regrasp : RunState::Push;
    RunPiece& report = out_.pieces.emplace_back();
    report.kind = kind;
    report.plan = static_cast<int>(out_.plans.size()) - 1;
    report.begin_s = now();
  }

  void end_piece() {
    out_.pieces.back().end_s = now();
    out_.pieces.back().off = off_ = share_between(model_, q_plan_, measured_.q, problem_.goal);
  }

  bool is_at_goal() const { return goal_share(watch_.mean()) <= 1; }

  // ---- plans

  /// What a search has taken of the clock in this run (mean) [s]; 0 before the first.
  double thinking_time() const {
    double sum = 0;
    int searches = 0;
    for (const RunPlan& plan : out_.plans) {
      if (!plan.joined) sum += plan.clock_s, ++searches;
    }
    return searches > 0 ? sum / searches : 0;
  }

  /// Every plan after the first counts, whatever calls for it. False: they are used up, and the run is over.
  bool may_plan() {
    if (!has_plan_) return has_plan_ = true;
    if (out_.replans - replans_before_ == how_.replans)
      return end(RunEnd::Replans, fmt::format("the goal was not reached with {} replans", how_.replans));
    ++out_.replans;
    return true;
  }

  /// From what is measured. A robot that can step back from objects which stand by themselves does so after a short search: what it wedges or what leans on it
  /// makes a bad start. Where that is no help either, the springs are let go, then the robot steps back once more, and the planner is asked with the friction of the
  /// scene: a place may be left by no push that holds with less. That goes for a start that does not rest with less as well.
  /// @returns nothing: the run is over, or the object is no more where the plan begins, or came to its goal as the springs were let go; `cause` then says
  ///          for what the next plan is
  std::optional<Trajectory> make_plan(std::string& cause) {
    bool slips = false, strained = true, can_step_back = source_.found() > 0 && !find_step_back(model_, measured_.q).empty();
    std::string why = cause;
    for (int refused = 0; refused < how_.refusals; ++refused) {
      const bool is_short = refused == 0 && can_step_back;
      Answer answer;
      if (refused == 1 && std::exchange(can_step_back, false)) {
        if (!step_back() || is_at_goal()) return std::nullopt;
        why = "no plan from where the robot touched";
      } else if (refused > 0) {
        if (!slips && (!(strained ? let_go() : step_back()) || is_at_goal())) return std::nullopt;
        why = slips      ? "no rest at the start with the friction of plans"
              : strained ? "no plan from where springs were strained"
                         : "no plan from where the robot touched";
        strained = false;
      }
      const double friction = strained ? how_.friction : 1;
      if (!ask(why, friction, is_short, answer)) return std::nullopt;
      slips = answer.slips && friction < 1;
      if (!out_.first_plan && !answer.joined) out_.first_plan = std::move(answer.result);
      if (!answer.trajectory) continue;
      if (!answer.late) return std::move(answer.trajectory);
      cause = "the object moved while the planner worked";
      settle();
      return std::nullopt;
    }
    const std::string& reason = out_.plans.back().reason;
    end(RunEnd::NoPlan, fmt::format("{} plans in a row failed{}", how_.refusals, reason.empty() ? "" : ": " + reason));
    return std::nullopt;
  }

  /// @param friction  every μ of the plan times this  @param is_short  see PlanSource::ask
  bool ask(const std::string& cause, double friction, bool is_short, Answer& answer) {
    state_ = RunState::Replan;
    const Eigen::VectorXd q = watch_.mean(), u = u_;
    const std::size_t number = out_.plans.size();
    const double begin = now();
    const auto work = [&](const core::RunControl& control) { answer = source_.ask(q, u, number, friction, is_short, control); };
    const bool goes_on = real_time_ ? think_beside(work) : think_first(work, answer);
    const planning::PlanResult& result = answer.result;
    out_.plans.push_back({begin, result.wall_s, answer.processor_s, now() - begin, result.status, cause, result.reason, answer.joined});
    out_.planning_s += result.wall_s;
    if (goes_on && answer.trajectory && !is_at(q, how_.off_at_the_end)) answer.late = true;
    return goes_on;
  }

  /// A plant that waits for its commands: the planner works, and then the clock goes on by what that took.
  template <class Work>
  bool think_first(const Work& work, const Answer& answer) {
    const double begin = now();
    work(control_);
    if (control_.stop()) return end(control_.cancelled() ? RunEnd::Cancelled : RunEnd::Deadline, "stopped while planning; the robot holds");
    link_.pause();
    if (!read()) return false;
    while (now() - begin < answer.charge_s - 0.5 * how_.tick) {
      if (!hold_tick()) return false;
    }
    return true;
  }

  /// A plant with a clock of its own: it is commanded while the planner works on another thread.
  template <class Work>
  bool think_beside(const Work& work) {
    std::atomic<bool> done{false}, unwanted{false};
    std::exception_ptr error;
    core::RunControl control = control_;
    control.on_progress = nullptr;  // the thread of the run tells of it
    control.abandoned = [&unwanted] { return unwanted.load(std::memory_order_relaxed); };
    std::jthread planner([&] {
      try {
        work(control);
      } catch (...) {
        error = std::current_exception();
      }
      done.store(true);
    });
    try {
      do {
        (void)hold_tick();
      } while (!over_ && !done.load());
    } catch (...) {
      unwanted.store(true);
      throw;
    }
    unwanted.store(true);
    planner.join();
    if (error) std::rethrow_exception(error);
    return !over_;
  }

  // ---- pieces

  /// @returns why it ended, for the next plan
  std::string carry_out(const Trajectory& trajectory) {
    set_floor(trajectory.q);
    displaced_ = false;
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
      report.given_up = !held && !touch_;
      if (over_ || touch_) return {};
      if (!held && displaced_) return "the object was put elsewhere";
      if (!held)
        return fmt::format("{} was {:.1f} tolerances off its plan", piece.kind == SegmentKind::Regrasp ? "a regrasp" : "a push", off_);
      if (goal_share(measured_.q) <= source_.fraction()) return "the goal did not hold";
    }
    return "the plan ended beside the goal";
  }

  /// The objects are away, or were put elsewhere.
  bool is_displaced() { return displaced_ = displaced_ || !link_.sees_objects(); }

  static bool is_last(const Trajectory& trajectory, const Piece& piece) { return &piece == &trajectory.pieces.back(); }

  /// A piece in time, watched. @param zero  time of the run at which the trajectory began
  bool follow(const Trajectory& trajectory, const Piece& piece, double zero) {
    const double begin = trajectory.times[piece.first_knot], end = trajectory.times[piece.last_knot];
    const double looked_back = how_.settle_time + kFollowTimes * follow_time_;
    Eigen::VectorXd u(model_.n_a());
    while (now() - zero < end - 0.5 * how_.tick) {
      const double t = std::min(now() - zero + how_.tick, end);
      interpolate_command(trajectory, t, u);
      interpolate(model_, trajectory, t, q_plan_);
      looked_ = holds_ = caught_ = false;
      if (!tick(u) || is_displaced()) return false;
      if (!looked_) continue;
      if (touch_) return false;
      off_ = share_off_path(model_, trajectory, std::max(begin, t - looked_back), std::min(end, t + how_.watch_interval),
                            how_.watch_interval, measured_.q, problem_.goal, is_last(trajectory, piece));
      if (off_ > how_.off_on_the_way) return false;
    }
    return true;
  }

  /// The object is where the piece ends, at once or once it rests; the rest of the trajectory comes later by as much.
  bool arrive(const Trajectory& trajectory, const Piece& piece, double& zero) {
    const Eigen::VectorXd q_end = trajectory.q.col(piece.last_knot);
    const auto off = [&](const Eigen::VectorXd& q) {
      return off_ = is_last(trajectory, piece) ? share_that_counts(model_, q_end, q, problem_.goal)
                                               : share_between(model_, q_end, q, problem_.goal);
    };
    if (off(measured_.q) <= kThere) return true;
    const double begin = now();
    const Eigen::VectorXd u_end = u_;
    if (!settle([&] { return touch_ || off(measured_.q) <= kThere; })) return false;
    if (caught_ && !move_to(u_end)) return false;  // fingers are elsewhere
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
    if (!out_.goals.empty() && !out_.reached()) leave_goal(touch_.has_value());
    if (n > 0) {
      out_.error = planning::goal_error(model_, watch_.mean(), problem_.goal);
      out_.duration_s = out_.times.back();
    }
  }

  const Model& model_;
  DriverLink link_;
  bool real_time_;
  std::span<const planning::PlanningProblem> goals_;
  std::size_t goal_ = 0;               ///< of them, the one on the way to which the run is …
  planning::PlanningProblem problem_;  ///< … which is this
  int replans_before_ = 0;             ///< it was aimed at
  struct Touch {
    double time;
    Eigen::VectorXd q;
  };
  std::optional<Touch> touch_;  ///< when it was first seen to be reached, and where things were, if it need not be held
  const RunOptions& how_;
  const core::RunControl& control_;
  RunResult& out_;
  RunSpeeds speed_;
  PlanSource source_;
  double follow_time_, window_;
  ObjectWatch watch_;
  Eigen::VectorXd strain_;  ///< that a motor bears at most (n_a)

  Measurement measured_;
  double start_ = 0;  ///< of the run, by the clock of the plant
  double next_look_ = 0;
  double seen_time_ = -std::numeric_limits<double>::infinity();  ///< of the objects at the last look, by the clock of the plant
  bool looked_ = false;                                          ///< in the last tick
  bool over_ = false;
  bool has_plan_ = false;  ///< one was given or asked for
  std::optional<ActiveHold> hold_;
  std::optional<FingerGait> gait_;
  bool asked_ = false;   ///< whether fingers turn the object
  bool caught_ = false;  ///< fingers moved since the last command of a plan
  bool holds_ = false;   ///< since the last command of a plan
  bool calm_ = true;
  Eigen::VectorXd q_held_;
  double next_hold_ = 0;  ///< when it looks again
  Eigen::VectorXd step_;  ///< of the commands in a tick (n_a)
  RunState state_ = RunState::Hold;
  bool displaced_ = false;  ///< since a plan began
  double off_ = 0;          ///< of the last look, in tolerances
  Eigen::VectorXd u_, q_plan_;
  std::vector<double> floor_;  ///< per object: how deep it may be
  std::vector<Eigen::VectorXd> q_, planned_, commands_;
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
