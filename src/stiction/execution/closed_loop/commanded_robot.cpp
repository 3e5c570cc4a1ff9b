#include "stiction/execution/closed_loop/commanded_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "stiction/execution/closed_loop/step_back.hpp"
#include "stiction/execution/open_loop/fall.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/planning/contact_limits.hpp"
#include "stiction/planning/thresholds.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

/// settle() waits for at most this many windows; after them it accepts objects that still move.
constexpr int kMostWindows = 10;
/// The fingers catch an object that moves farther than this while commands rest [tolerances of the goal].
constexpr double kLeaves = 0.2;
/// The way of a moving object is searched in such parts for what stops it, up to the longest way [lengths of the object].
constexpr double kPart = 0.25, kFarthest = 100;
/// Time between two choices of finger commands [s].
constexpr double kChoicePeriod = 0.01;

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Where the objects come to rest if the commands stay (n_q × 1), by quasi-static steps as in the planner; no column if they do not.
Eigen::MatrixXd find_rest(const std::shared_ptr<const world::Model>& model, const Eigen::VectorXd& q, const Eigen::VectorXd& u) {
  const double least = world::share::kMotionless * model->scales().robots().length;
  dynamics::StepWorkspace work(model);
  dynamics::StepResult step;
  Eigen::VectorXd at = q;
  for (int k = 0; k < planning::threshold::kMostSettling; ++k) {
    if (dynamics::step(*model, {at, u}, {}, work, step) != core::Status::Solved) break;
    if (world::largest_share(*model, step.delta, least, world::share::kMotionless) <= 1) return at;
    at = step.q_next;
  }
  return Eigen::MatrixXd(model->n_q(), 0);
}

}  // namespace

ChosenCommands::ChosenCommands(double tick) : tick_(tick), period_(std::max(kChoicePeriod, tick)) {}

CommandedRobot::CommandedRobot(Driver& plant, std::span<const planning::PlanningProblem> goals, const RunOptions& how,
                               const core::RunControl& control, RunResult& out)
    : goals_(goals),
      problem_(goals.front()),
      model_(*problem_.model),
      how_(how),
      control_(control),
      out_(out),
      link_(plant, model_, how.tick, how.silence, how.absence),
      watch_(model_, problem_.goal, how.settle_time, how.settle_time),
      strain_(model_.effort().cwiseQuotient(model_.stiffness())),
      held_(how.tick) {
  aim();
}

/// Sets everything that depends on the object of the goal.
void CommandedRobot::aim() {
  speed_ = how_.speed ? *how_.speed : calc_run_speeds(model_, problem_.goal.object, how_.speed_factor);
  follow_time_ = calc_follow_time(model_, problem_.goal.object);
  window_ = how_.settle_time + follow_time_;
  watch_.set_window(window_);
  hold_.reset();
  if (how_.active_hold) catch_what_moves();
}

void CommandedRobot::leave_goal(bool reached) {
  RunGoal& goal = out_.goals.back();
  goal.reached = reached;
  goal.end_s = touch_ ? touch_->time : now();
  goal.error = planning::goal_error(model_, touch_ ? touch_->q : rest(), problem_.goal);
}

bool CommandedRobot::next_goal() {
  leave_goal(true);
  if (is_last_goal()) return end(RunEnd::Reached);
  const int object = problem_.goal.object;
  ++goal_;
  problem_.goal = goals_[goal_].goal, problem_.q_goal = goals_[goal_].q_goal;
  RunGoal next;
  next.begin_s = out_.goals.back().end_s;
  out_.goals.push_back(next);
  touch_.reset();
  if (how_.hold == 0) look_back(next.begin_s);
  if (problem_.goal.object != object) aim();
  return true;
}

/// Marks the new goal as touched if the object passed through it after the goal before was reached: the robot did not stop there.
void CommandedRobot::look_back(double since) {
  for (std::size_t k = 0; k < q_.size() && !touch_; ++k) {
    if (out_.times[k] > since && goal_share(q_[k]) <= 1) touch_ = {out_.times[k], q_[k]};
  }
}

bool CommandedRobot::begin() {
  if (!read()) return false;
  start_ = measured_.time;
  u_ = measured_.u;
  q_plan_ = measured_.q;
  set_floor(find_rest(problem_.model, measured_.q, u_));  // what hangs above its support comes down first
  out_.goals.push_back({});
  look();
  return !over_;
}

bool CommandedRobot::end(RunEnd what, std::string message) {
  const bool names_goal = goals_.size() > 1 && what != RunEnd::Reached;
  out_.end = what;
  out_.message = names_goal ? fmt::format("goal {} of {}: {}", goal_ + 1, goals_.size(), message) : std::move(message);
  over_ = true;
  return false;
}

bool CommandedRobot::read() {
  if (!link_.read()) return end(RunEnd::Silent, link_.reason());
  measured_ = link_.measured();
  return true;
}

double CommandedRobot::goal_share(const Eigen::VectorXd& q) const {
  return planning::goal_error(model_, q, problem_.goal).share(problem_.goal);
}

bool CommandedRobot::is_at(const Eigen::VectorXd& q, double near) const {
  const Eigen::VectorXd difference = q.tail(model_.n_a()) - measured_.q.tail(model_.n_a());
  const bool joints = (difference.cwiseAbs().array() <= (speed_.push * how_.watch_interval).array()).all();
  return joints && share_between(model_, q, rest(), problem_.goal) <= near;
}

void CommandedRobot::begin_motion(const Eigen::MatrixXd& planned) {
  set_floor(planned);
  displaced_ = false;
}

/// Limits u so that it is no farther ahead of the joints than their motors can pull.                                       (E.15)
Eigen::VectorXd CommandedRobot::within_motors(const Eigen::VectorXd& u) const {
  const Eigen::VectorXd q_a = measured_.q.tail(model_.n_a());
  return u.cwiseMax(q_a - strain_).cwiseMin(q_a + strain_);
}

bool CommandedRobot::tick(const Eigen::VectorXd& wanted) {
  looked_ = false;
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

bool CommandedRobot::tick(const Eigen::VectorXd& wanted, const Eigen::VectorXd& q_plan) {
  holds_ = caught_ = false;
  q_plan_ = q_plan;
  return tick(wanted);
}

bool CommandedRobot::hold_tick() {
  if (!hold_) return tick(u_);
  if (!holds_) {
    holds_ = calm_ = true;
    q_held_ = measured_.q;
    hold_->start(q_held_);
  }
  if (calm_ && share_between(model_, q_held_, measured_.q, problem_.goal) > kLeaves) calm_ = false, held_.begin(now());
  if (calm_) return tick(u_);
  caught_ = true;
  return tick(held_.next(now(), u_, [&](double period, Eigen::VectorXd& wanted) {
    (void)hold_->update(measured_.q, period, wanted);  // a failed update leaves the command unchanged
  }));
}

void CommandedRobot::look() {
  next_look_ = now() + how_.watch_interval;
  if (measured_.object_time > seen_time_) {  // a repeated pose is no evidence of rest
    watch_.add(now(), measured_.q);
    if (how_.hold == 0 && !touch_ && goal_share(measured_.q) <= 1) touch_ = {now(), measured_.q};
  }
  seen_time_ = measured_.object_time;
  looked_ = true;
  record();
  check_fall();
  if (touch_ && is_last_goal() && !over_) next_goal();
}

void CommandedRobot::record() {
  if (state_ == RunState::Hold || state_ == RunState::Replan) q_plan_ = measured_.q;
  out_.times.push_back(now());
  q_.push_back(measured_.q), planned_.push_back(q_plan_), commands_.push_back(u_);
  out_.piece.push_back(static_cast<int>(out_.pieces.size()) - 1);
  if (!how_.on_sample) return;
  how_.on_sample({now(), state_, measured_.q, q_plan_, u_, out_.piece.back(), static_cast<int>(out_.plans.size()), goal_share(measured_.q),
                  static_cast<int>(goal_)});
}

double CommandedRobot::depth(const Eigen::VectorXd& q, int object) const {
  return world::object_pose(model_, q, object).p.dot(model_.scene().gravity.normalized());
}

/// Sets the depth at which each object counts as fallen: kFall L below its present place and every planned one (n_q × knots).
void CommandedRobot::set_floor(const Eigen::MatrixXd& planned) {
  floor_.assign(model_.objects().size(), kNever);
  for (int i = 0; i < static_cast<int>(floor_.size()); ++i) {
    const bool free = model_.scene().objects[static_cast<std::size_t>(i)].joint == world::ObjectJoint::Free;
    if (!free || model_.scene().gravity.norm() == 0) continue;
    double lowest = depth(measured_.q, i);
    for (Eigen::Index k = 0; k < planned.cols(); ++k) lowest = std::max(lowest, depth(planned.col(k), i));
    floor_[static_cast<std::size_t>(i)] = lowest + kFall * model_.scales().object(i).length;
  }
}

void CommandedRobot::check_fall() {
  for (int i = 0; i < static_cast<int>(floor_.size()) && !over_; ++i) {
    const double floor = floor_[static_cast<std::size_t>(i)];
    if (floor == kNever || depth(measured_.q, i) < floor) continue;
    out_.dropped = i;
    end(RunEnd::Dropped, fmt::format("'{}' fell", model_.objects()[static_cast<std::size_t>(i)].name));
  }
}

Eigen::VectorXd CommandedRobot::expected(double time) const {
  Eigen::VectorXd out = rest();
  if (watch_.rests(kThere / thinking_time()) || touches_objects(model_, measured_.q)) return out;
  const Eigen::VectorXd end = watch_.expected(time);
  double ways = 0;  // of the object that goes farthest [lengths of the object]
  for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) {
    const Eigen::Vector3d way = world::object_pose(model_, end, i).p - world::object_pose(model_, out, i).p;
    ways = std::max(ways, way.norm() / model_.scales().object(i).length);
  }
  contact::GeometryWorkspace work(model_);
  if (ways > kFarthest) time *= kFarthest / ways, ways = kFarthest;
  const int parts = static_cast<int>(std::ceil(ways / kPart));
  for (int k = 1; k <= parts; ++k) {
    Eigen::VectorXd q = watch_.expected(time * k / parts);
    if (planning::calc_penetration(model_, q, work) > 1) break;
    out = std::move(q);
  }
  return out;
}

/// Mean time of the regrasps of this run [s]; 0 before the first one.
double CommandedRobot::approach_time() const {
  double sum = 0;
  int regrasps = 0;
  for (const RunPiece& piece : out_.pieces) {
    if (piece.kind == planning::SegmentKind::Regrasp) sum += piece.end_s - piece.begin_s, ++regrasps;
  }
  return regrasps > 0 ? sum / regrasps : 0;
}

/// Mean time on the plant's clock that a search took in this run [s]; 0 before the first search.
double CommandedRobot::thinking_time() const {
  double sum = 0;
  int searches = 0;
  for (const RunPlan& plan : out_.plans) {
    if (!plan.joined) sum += plan.clock_s, ++searches;
  }
  return searches > 0 ? sum / searches : 0;
}

bool CommandedRobot::settle(const std::function<bool()>& there) {
  while (!link_.sees_objects()) {
    if (!tick(u_)) return false;
  }
  watch_.forget();
  watch_.add(now(), measured_.q);
  const double begin = now();
  while (now() - begin < kMostWindows * window_ || (watch_.is_carried() && now() - begin < how_.absence)) {
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

bool CommandedRobot::settle() {
  state_ = RunState::Hold;
  return settle([] { return false; });
}

bool CommandedRobot::hold_goal() {
  state_ = RunState::Hold;
  const double begin = now();
  while (now() - begin < how_.hold) {
    if (!hold_tick() || !is_at_goal()) return false;
  }
  return true;
}

bool CommandedRobot::move_to(const Eigen::VectorXd& u) {
  holds_ = caught_ = false;
  const Eigen::VectorXd from = u_;
  const double begin = now(), duration = calc_duration(from, u, speed_.push);
  while (now() - begin < duration) {
    if (!tick(from + std::min(1.0, (now() - begin + how_.tick) / duration) * (u - from))) return false;
  }
  return true;
}

bool CommandedRobot::step_back() {
  for (const Eigen::VectorXd& posture : find_step_back(model_, measured_.q)) {
    if (!move_to(posture)) return false;
  }
  return settle();
}

void CommandedRobot::catch_what_moves() {
  hold_.emplace(problem_.model, problem_.goal.object, how_.friction);
  if (!hold_->applies()) hold_.reset();
}

void CommandedRobot::finish() {
  const auto n = static_cast<Eigen::Index>(q_.size());
  out_.q.resize(model_.n_q(), n), out_.q_plan.resize(model_.n_q(), n), out_.u.resize(model_.n_a(), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    out_.q.col(k) = q_[static_cast<std::size_t>(k)];
    out_.q_plan.col(k) = planned_[static_cast<std::size_t>(k)];
    out_.u.col(k) = commands_[static_cast<std::size_t>(k)];
  }
  if (!out_.goals.empty() && !out_.reached()) leave_goal(touch_.has_value());
  if (n > 0) {
    out_.error = planning::goal_error(model_, rest(), problem_.goal);
    out_.duration_s = out_.times.back();
  }
}

}  // namespace stiction::execution
