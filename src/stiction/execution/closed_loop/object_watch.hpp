#pragma once

#include <deque>
#include <limits>

#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// How far an object is between two configurations, in tolerances of the goal.
double share_between(const world::Model& model, int object, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1,
                     const planning::Goal& goal);

/// The same of the objects of the goal, the largest.
double share_between(const world::Model& model, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1, const planning::Goal& goal);

/// How far they are from where a plan has them, in tolerances of its pushes: those of the goal, and no less than 0.05 L and 0.1 rad. The next push finds the
/// objects there, however well the goal has to be met.
/// @param last_push  coordinates count alone that the goal bounds: after the last push of a plan nothing depends on the others
double share_off(const world::Model& model, const Eigen::VectorXd& q_plan, const Eigen::VectorXd& q, const planning::Goal& goal,
                 bool last_push = false);

/// The objects over the last looks: whether they rest, and where.
class ObjectWatch {
 public:
  /// @param window  that has to show no motion [s]
  /// @param least   that does where nothing moves in it even at the speed at which little is moved in a window [s], ≤ window
  ObjectWatch(const world::Model& model, const planning::Goal& goal, double window, double least)
      : model_(model), goal_(goal), window_(window), least_(least) {}

  void set_window(double window) { window_ = window; }
  void add(double time, const Eigen::VectorXd& q);
  void forget() { seen_.clear(); }
  /// The least window, the window, or 2, 4 or 8 of them, is full, and no object moved from its first half to its second by more than noise does in a window …
  /// @param slow  … or by more than it would at this speed [tolerances of the goal in a second]: long windows show it in spite of noise
  bool rests(double slow = std::numeric_limits<double>::infinity()) const { return find_rest(slow) > 0; }
  /// An object moved by more than the tolerances of the goal from one half of the window to the other: something has hold of it.
  bool is_carried() const { return share_moved(window_) > 1; }
  /// Where they rest: what was seen before they did is forgotten, so that mean() is not where they came through.
  void forget_motion(double slow = std::numeric_limits<double>::infinity());
  /// Objects as they are in the mean of the window, joints as last seen (n_q).
  Eigen::VectorXd mean() const { return mean(begin_of(window_), seen_.size()); }

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

/// How far the objects of the goal are from where a trajectory had them at any time in [begin, end], as share_off() has it.
/// @param interval  between the times that are looked at [s], > 0
double share_off_path(const world::Model& model, const Trajectory& trajectory, double begin, double end, double interval,
                      const Eigen::VectorXd& q, const planning::Goal& goal, bool last_push = false);

}  // namespace stiction::execution
