#include "stiction/execution/closed_loop/object_watch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

/// Objects rest if they move by less than this from one half of a window to the other [tolerances of the goal].
constexpr double kStill = 0.1;
/// Longest look-back, in windows.
constexpr double kLongest = 8;

double share_of(const planning::PathTolerances& most, const world::Model& model, int object, const Eigen::VectorXd& q0,
                const Eigen::VectorXd& q1) {
  const world::Pose X0 = world::object_pose(model, q0, object), X1 = world::object_pose(model, q1, object);
  return std::max((X0.p - X1.p).norm() / most.position, Eigen::Quaterniond(X0.R).angularDistance(Eigen::Quaterniond(X1.R)) / most.angle);
}

/// Tolerances of pushes: those of the goal, but no less than the tolerances that plans allow for objects that are let go.
planning::PathTolerances tolerances_of_pushes(const world::Model& model, int object, const planning::Goal& goal) {
  const planning::PathTolerances of_goal = planning::path_tolerances(model, goal);
  return {std::max(of_goal.position, world::share::kRelease * model.scales().object(object).length),
          std::max(of_goal.angle, world::share::kReleaseAngle)};
}

/// Distance between two configurations in the coordinates that the goal bounds [tolerances].
double share_that_counts(const world::Model& model, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1, const planning::Goal& goal) {
  planning::Goal there = goal;
  for (std::size_t o = 0; o < model.objects().size(); ++o) {
    const auto& object = model.objects()[o];
    Eigen::VectorXd at = q0.segment(object.q_begin, object.n_v);
    if (model.scene().objects[o].joint == world::ObjectJoint::Free)
      at.tail<3>() = planning::roll_pitch_yaw(world::object_pose(model, q0, static_cast<int>(o)).R);
    for (int i = 0; i < object.n_v; ++i) {
      double &lower = there.region->lower[object.v_begin + i], &upper = there.region->upper[object.v_begin + i];
      if (std::isfinite(lower) || std::isfinite(upper)) lower = upper = at[i];
    }
  }
  const planning::GoalError error = planning::goal_error(model, q1, there);
  const planning::PathTolerances most = tolerances_of_pushes(model, goal.object, goal);
  return std::max(error.position / most.position, error.angle / most.angle);
}

}  // namespace

double share_between(const world::Model& model, int object, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1,
                     const planning::Goal& goal) {
  return share_of(planning::path_tolerances(model, goal), model, object, q0, q1);
}

double share_between(const world::Model& model, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1, const planning::Goal& goal) {
  double share = 0;
  for (const int object : planning::goal_objects(model, goal)) share = std::max(share, share_between(model, object, q0, q1, goal));
  return share;
}

double share_off(const world::Model& model, const Eigen::VectorXd& q_plan, const Eigen::VectorXd& q, const planning::Goal& goal,
                 bool last_push) {
  if (last_push && goal.region) return share_that_counts(model, q_plan, q, goal);
  double share = 0;
  for (const int object : planning::goal_objects(model, goal))
    share = std::max(share, share_of(tolerances_of_pushes(model, object, goal), model, object, q_plan, q));
  return share;
}

void ObjectWatch::add(double time, const Eigen::VectorXd& q) {
  seen_.push_back({time, q});
  while (seen_.size() > 1 && seen_[1].time <= time - kLongest * window_) seen_.pop_front();
}

/// Index of the last look that is at least `window` before the latest one; 0 if there is none, or no look at all.
std::size_t ObjectWatch::begin_of(double window) const {
  std::size_t begin = seen_.empty() ? 0 : seen_.size() - 1;
  while (begin > 0 && seen_.back().time - seen_[begin].time < window * (1 - 1e-9)) --begin;
  return begin;
}

/// Motion of the object that moved most from the first half of a window to the second [tolerances]; infinite if the window is not full.
double ObjectWatch::share_moved(double window) const {
  const std::size_t begin = begin_of(window);
  if (seen_.size() - begin < 2 || seen_.back().time - seen_[begin].time < window * (1 - 1e-9))
    return std::numeric_limits<double>::infinity();
  const std::size_t half = begin + (seen_.size() - begin) / 2;
  const Eigen::VectorXd before = mean(begin, half), after = mean(half, seen_.size());
  double out = 0;
  for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) out = std::max(out, share_between(model_, i, before, after, goal_));
  return out;
}

/// Shortest window in which the objects rest [s]; 0: none.
double ObjectWatch::find_rest(double slow) const {
  const auto rests_over = [&](double window) { return share_moved(window) <= std::min(kStill * window / window_, slow * window / 2); };
  if (rests_over(least_)) return least_;
  for (double windows = 1; windows <= kLongest; windows *= 2) {
    if (rests_over(windows * window_)) return windows * window_;
  }
  return 0;
}

void ObjectWatch::forget_motion(double slow) {
  const double rest = find_rest(slow);
  if (rest <= 0 || share_moved(window_) <= kStill) return;
  while (seen_.size() > 1 && seen_.front().time < seen_.back().time - rest * (1 + 1e-9)) seen_.pop_front();
}

Eigen::VectorXd ObjectWatch::mean(std::size_t begin, std::size_t end) const {
  const Eigen::VectorXd& last = seen_[end - 1].q;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(model_.n_v()), difference(model_.n_v()), out(model_.n_q());
  for (std::size_t i = begin; i < end; ++i) {
    world::local(model_, last, seen_[i].q, difference);
    sum += difference;
  }
  sum /= static_cast<double>(end - begin);
  sum.tail(model_.n_a()).setZero();
  world::retract(model_, last, sum, out);
  return out;
}

Eigen::VectorXd ObjectWatch::expected(double time) const {
  const std::size_t half = seen_.size() / 2;
  Eigen::VectorXd out = mean();
  if (half == 0) return out;
  const auto time_of = [&](std::size_t begin, std::size_t end) { return 0.5 * (seen_[begin].time + seen_[end - 1].time); };
  const double between = time_of(half, seen_.size()) - time_of(0, half);
  Eigen::VectorXd way(model_.n_v());
  world::local(model_, mean(0, half), mean(half, seen_.size()), way);
  way.tail(model_.n_a()).setZero();
  for (const world::ObjectInfo& object : model_.objects())
    if (object.n_v == 1) way[object.v_begin] = 0;
  world::retract(model_, mean(), way * (time / between), out);
  return out;
}

double share_off_path(const world::Model& model, const Trajectory& trajectory, double begin, double end, double interval,
                      const Eigen::VectorXd& q, const planning::Goal& goal, bool last_push) {
  Eigen::VectorXd planned(model.n_q());
  double least = std::numeric_limits<double>::infinity();
  for (double t = end;; t -= interval) {
    interpolate(model, trajectory, std::max(t, begin), planned);
    least = std::min(least, share_off(model, planned, q, goal, last_push));
    if (t <= begin) return least;
  }
}

}  // namespace stiction::execution
