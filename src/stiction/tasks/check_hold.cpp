#include <fmt/format.h>

#include <array>
#include <cmath>

#include "stiction/tasks/check_replay.hpp"

// Tests whether objects stay in place while robot branches are away from them.

namespace stiction::tasks {
namespace {

constexpr double kAside = 0.1;   // tilt of gravity [rad]
constexpr int kMostSteps = 20;   // largest number of steps per tilt direction
constexpr double kStill = 1e-3;  // an object rests if it moves less than this share of the allowed motion in a step

}  // namespace

/// A release is unstable if an object moves under tilted gravity, at the knot where the branches are farthest away.
void Replay::see_hold(std::size_t segment, const StoredKnot& away) {
  for (int side = 0; side < 4; ++side) {
    const auto slip = slip_aside(away, side);
    if (slip && slip->position <= stays_.position && slip->angle <= stays_.angle) continue;
    const std::string how = slip ? fmt::format("{:.3g} mm, {:.3g} rad", 1e3 * slip->position, slip->angle) : "a step that is not solved";
    unstable_releases_.see(static_cast<double>(++unstable_), [&] { return fmt::format("{} in segment {}", how, segment); });
    return;
  }
}

/// Largest displacement and largest rotation of the objects; nothing if a step is not solved.
std::optional<PoseError> Replay::slip_aside(const StoredKnot& away, int side) {
  const Eigen::VectorXd start = normalised(model_, away.q);
  Eigen::VectorXd q = start;
  PoseError slip{0, 0};
  for (int k = 0; k < kMostSteps && slip.position <= stays_.position && slip.angle <= stays_.angle; ++k) {
    const Eigen::VectorXd aside = calc_gravity_aside(q, side);
    if (dynamics::step(model_, {q, away.u, &aside}, step_options_, step_work_, result_) != core::Status::Solved) return std::nullopt;
    PoseError moved{0, 0};
    for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) {
      const world::Pose X_0 = world::object_pose(model_, start, i), X_1 = world::object_pose(model_, q, i),
                        X_2 = world::object_pose(model_, result_.q_next, i);
      slip = {std::max(slip.position, (X_2.p - X_0.p).norm()), std::max(slip.angle, angle_between(X_0.R, X_2.R))};
      moved = {std::max(moved.position, (X_2.p - X_1.p).norm()), std::max(moved.angle, angle_between(X_1.R, X_2.R))};
    }
    q = result_.q_next;
    if (moved.position <= kStill * stays_.position && moved.angle <= kStill * stays_.angle) break;
  }
  return slip;
}

/// Extra force on free objects if gravity is tilted by kAside and its component along the old direction is unchanged (n_v).
Eigen::VectorXd Replay::calc_gravity_aside(const Eigen::VectorXd& q, int side) const {
  const Eigen::Vector3d gravity = model_.scene().gravity;
  Eigen::VectorXd tau = Eigen::VectorXd::Zero(model_.n_v());
  if (gravity.isZero(0)) return tau;
  const Eigen::Vector3d down = gravity.normalized(), first = down.unitOrthogonal();
  const std::array<Eigen::Vector3d, 2> axes{first, down.cross(first)};
  const Eigen::Vector3d acceleration = (side < 2 ? 1 : -1) * std::tan(kAside) * gravity.norm() * axes[static_cast<std::size_t>(side % 2)];
  for (int i = 0; i < static_cast<int>(model_.objects().size()); ++i) {
    const auto& object = model_.objects()[static_cast<std::size_t>(i)];
    const auto& spec = model_.scene().objects[static_cast<std::size_t>(i)];
    if (spec.joint != world::ObjectJoint::Free) continue;
    const Eigen::Matrix3d R = world::object_pose(model_, q, i).R;
    const Eigen::Vector3d force = spec.weight_share * object.mass * acceleration;
    tau.segment<3>(object.v_begin) = force;
    tau.segment<3>(object.v_begin + 3) = R.transpose() * (R * spec.p_BCom).cross(force);
  }
  return tau;
}

}  // namespace stiction::tasks
