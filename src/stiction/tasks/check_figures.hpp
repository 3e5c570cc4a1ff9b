#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "stiction/tasks/check.hpp"

namespace stiction::tasks {

/// The worst of a figure so far and where it was met.
struct Worst {
  double value = 0;
  std::string where;
  bool nan = false;

  /// `describe` is called only when x is the worst so far.
  template <class Describe>
  void see(double x, Describe&& describe) {
    if (std::isnan(x)) nan = true;
    if (x > value) {
      value = x;
      where = describe();
    }
  }
};

inline void add(CheckReport& out, std::string name, const Worst& worst, std::optional<double> limit, std::string unit) {
  out.items.push_back({.name = std::move(name),
                       .value = worst.nan ? std::numeric_limits<double>::max() : worst.value,
                       .limit = limit,
                       .unit = std::move(unit),
                       .pass = !worst.nan && (!limit || worst.value <= *limit),
                       .where = worst.where});
}

/// Angle of the rotation from R0 to R1 [rad], exact also where it is small.
inline double angle_between(const Eigen::Matrix3d& R0, const Eigen::Matrix3d& R1) {
  const Eigen::Quaterniond q(R0.transpose() * R1);
  return 2 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

struct PoseError {
  double position, angle;  ///< [m], [rad]
};

/// Distance from the goal that the file states; of several objects the largest.
PoseError goal_error(const world::Model& model, const PlanFile& plan, const Eigen::VectorXd& q);

/// The objects that the goal in the file is about.
std::vector<int> goal_objects(const world::Model& model, const PlanFile& plan);

/// The same state, with unit quaternions where it has others, so that an edited file can be simulated on and is judged by quaternion_norm.
Eigen::VectorXd normalised(const world::Model& model, Eigen::VectorXd q);

}  // namespace stiction::tasks
