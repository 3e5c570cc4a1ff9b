#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "stiction/tasks/check.hpp"

namespace stiction::tasks {

/// The worst value of a figure so far, and its place.
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

/// Angle of the rotation from R0 to R1 [rad], accurate also for small angles.
inline double angle_between(const Eigen::Matrix3d& R0, const Eigen::Matrix3d& R1) {
  const Eigen::Quaterniond q(R0.transpose() * R1);
  return 2 * std::atan2(q.vec().norm(), std::abs(q.w()));
}

struct PoseError {
  double position, angle;  ///< [m], [rad]
};

/// Distance from the goal stated in the file; the largest one for several objects.
PoseError goal_error(const world::Model& model, const PlanFile& plan, const Eigen::VectorXd& q);

/// The objects of the goal stated in the file.
std::vector<int> goal_objects(const world::Model& model, const PlanFile& plan);

/// The state with all quaternions normalised, so that an edited file can still be simulated. quaternion_norm then judges the file.
Eigen::VectorXd normalised(const world::Model& model, Eigen::VectorXd q);

}  // namespace stiction::tasks
