#pragma once

#include <deque>

#include "stiction/execution/open_loop/trajectory.hpp"

namespace stiction::execution {

/// How far an object is between two configurations, in tolerances of the goal.
double share_between(const world::Model& model, int object, const Eigen::VectorXd& q0, const Eigen::VectorXd& q1,
                     const planning::Goal& goal);

/// The objects over the last looks: whether they rest, and where.
class ObjectWatch {
 public:
  /// @param window  that has to show no motion [s]
  /// @param least   that does where nothing moves in it even at the speed at which little is moved in a window [s], ≤ window
  ObjectWatch(const world::Model& model, const planning::Goal& goal, double window, double least)
      : model_(model), goal_(goal), window_(window), least_(least) {}

  void add(double time, const Eigen::VectorXd& q);
  void forget() { seen_.clear(); }
  /// The window, or the least of it, is full, and no object is elsewhere in its second half than in its first.
  bool rests() const;
  /// Where they rest: what was seen before they did is forgotten, so that mean() is not where they came through.
  void forget_motion();
  /// Objects as they are in the mean of the window, joints as last seen (n_q).
  Eigen::VectorXd mean() const { return mean(0, seen_.size()); }

 private:
  struct Seen {
    double time;
    Eigen::VectorXd q;
  };
  Eigen::VectorXd mean(std::size_t begin, std::size_t end) const;
  bool rests_over(double window) const;

  const world::Model& model_;
  const planning::Goal& goal_;
  double window_, least_;
  std::deque<Seen> seen_;
};

/// How far the object of the goal is from where a trajectory had it at any time in [begin, end], in tolerances of the goal.
/// @param interval  between the times that are looked at [s], > 0
double share_off_path(const world::Model& model, const Trajectory& trajectory, double begin, double end, double interval,
                      const Eigen::VectorXd& q, const planning::Goal& goal);

}  // namespace stiction::execution
