#pragma once

#include <deque>
#include <limits>

#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// Distance of one object between two configurations (n_q each) [tolerances of the goal].
double share_between(const world::Model& model, int object, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1,
                     const planning::Goal& goal);

/// The same, the largest over the objects of the goal.
double share_between(const world::Model& model, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1, const planning::Goal& goal);

/// Distance of the objects of the goal between a planned and a measured configuration (n_q), in tolerances of pushes: those of the goal, but at least 0.05 L
/// and 0.1 rad. The next push must find the objects there, even if the goal has tighter tolerances.
/// @param last_push  true: only coordinates that the goal bounds count, since nothing depends on the others after the last push
double share_off(const world::Model& model, const Eigen::VectorXd& q_plan, const Eigen::VectorXd& q, const planning::Goal& goal,
                 bool last_push = false);

/// Object poses over the last looks: tells whether the objects rest, and where.
class ObjectWatch {
 public:
  /// @param window  length of the window in which nothing may move [s]
  /// @param least   shortest window that suffices if the objects are slow enough in it, see rests() [s], ≤ window
  ObjectWatch(const world::Model& model, const planning::Goal& goal, double window, double least)
      : model_(model), goal_(goal), window_(window), least_(least) {}

  void set_window(double window) { window_ = window; }
  void add(double time, const Eigen::VectorXd& q);
  void forget() { seen_.clear(); }
  /// True if the objects rest: in one of the windows `least`, `window`, or 2, 4 or 8 times `window`, that is full, no object moved from the first half to the
  /// second by more than noise does, nor by more than it would at the speed `slow`. Long windows show slow motion in spite of noise.
  /// @param slow  speed below which an object counts as at rest [tolerances of the goal per second]
  bool rests(double slow = std::numeric_limits<double>::infinity()) const { return find_rest(slow) > 0; }
  /// True if an object moved by more than the tolerances of the goal from one half of the window to the other: somebody or something carries it.
  bool is_carried() const { return share_moved(window_) > 1; }
  /// Once the objects rest, forgets the looks before that, so that mean() does not average over their motion.
  void forget_motion(double slow = std::numeric_limits<double>::infinity());
  /// Configuration with the mean object poses of the window and the last joint positions (n_q).
  Eigen::VectorXd mean() const { return mean(begin_of(window_), seen_.size()); }
  /// The same for a time to come, if free and planar objects go on as they moved from the first half of the looks to the second. Hinges and sliders, whose
  /// friction and limits stop them, stay. @param time  from now on [s], ≥ 0
  Eigen::VectorXd expected(double time) const;

 private:
  struct Seen {
    double time;
    Eigen::VectorXd q;
  };
  Eigen::VectorXd mean(std::size_t begin, std::size_t end) const;
  std::size_t begin_of(double window) const;
  double share_moved(double window) const;
  double find_rest(double slow) const;

  const world::Model& model_;
  const planning::Goal& goal_;
  double window_, least_;
  std::deque<Seen> seen_;
};

/// Least share_off() of the objects of the goal from a trajectory at any time in [begin, end].
/// @param interval  time between the compared points of the trajectory [s], > 0
double share_off_path(const world::Model& model, const Trajectory& trajectory, double begin, double end, double interval,
                      const Eigen::VectorXd& q, const planning::Goal& goal, bool last_push = false);

}  // namespace stiction::execution
