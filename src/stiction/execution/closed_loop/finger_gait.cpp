#include "stiction/execution/closed_loop/finger_gait.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "stiction/planning/regrasp.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {
namespace {

using core::Status;
using Eigen::VectorXd;

constexpr double kSpeed = 0.6;   ///< speed of a turn [rad/s]
constexpr double kCycle = 0.3;   ///< largest turn [rad]
constexpr double kClose = 1;     ///< time in which the fingers close on the object [s]
constexpr double kSettle = 0.3;  ///< time in which the object follows a turn [s]
/// Times in which a finger leaves the object, moves beside the place at which it first touched it, and comes back to this place [s].
constexpr std::array<double, 3> kReturn{0.12, 0.15, 0.12};
constexpr double kLift = 0.16;     ///< distance by which a finger leaves the object, in L
constexpr double kDamping = 1e-3;  ///< damping of the inverse kinematics that lifts a finger, in L²
constexpr double kGain = 0.5;      ///< a turn gains too little if the object comes nearer by less than this share of the turn
constexpr int kIdle = 2;           ///< the gait stalls after this many such turns in a row
constexpr double kReach = 0.5;     ///< largest distance to the position of the goal, in L
constexpr std::size_t kLeast = 3;  ///< least number of fingers

}  // namespace

FingerGait::FingerGait(const std::shared_ptr<const world::Model>& model, const planning::Goal& goal, double friction)
    : model_(model), goal_(goal), hold_(model, goal.object, friction), length_(model->scales().object(goal.object).length) {}

bool FingerGait::applies(VectorRef q) {
  if (hold_.fingers().pairs.size() < kLeast || goal_.region) return false;
  const Eigen::Vector3d p = world::object_pose(*model_, q, goal_.object).p;
  if ((goal_.X_WG.p - p).norm() > kReach * length_) return false;
  VectorXd q_open = q;
  for (int finger = 0; finger < static_cast<int>(hold_.fingers().pairs.size()); ++finger) {
    const VectorXd lift = calc_lift(q, finger);
    for (std::size_t k = 0; k < chain(finger).size(); ++k) q_open[model_->n_qu() + chain(finger)[k]] += lift[static_cast<Eigen::Index>(k)];
  }
  const planning::PlannerOptions options;
  const core::RunControl control;
  const planning::Setting setting({model_, q, goal_, {}}, options);
  planning::SimulationScratch scratch(model_, control);
  planning::Work work;
  const planning::RegraspSizes sizes{.pace = planning::substeps(setting)};
  return !planning::RegraspSimulation(setting, sizes, q_open, q_open.tail(model_->n_a()), scratch, work).is_stable();
}

void FingerGait::start(VectorRef q) {
  q_ref_ = q;
  from_ = world::object_pose(*model_, q, goal_.object);
  const Eigen::AngleAxisd way(goal_.X_WG.R * from_.R.transpose());
  axis_ = way.axis(), angle_ = way.angle();
  twist_ = 0, aimed_ = false;
  nearest_ = planning::goal_error(*model_, q, goal_).share(goal_), idle_ = 0;
  finger_ = -1;
  hold_.leave(finger_);
  enter(Phase::Close);
}

bool FingerGait::has_turned() const { return phase_ == Phase::Settle && time_ >= 0.5 * kSettle; }

bool FingerGait::stalls() const { return idle_ >= kIdle; }

void FingerGait::set_reference(const world::Pose& X_WB) {
  const int at = model_->objects()[static_cast<std::size_t>(goal_.object)].q_begin;
  q_ref_.segment<7>(at) << X_WB.p, Eigen::Quaterniond(X_WB.R).normalized().coeffs();
}

/// α of the object: of the angles that differ by whole turns, the one nearest to the last twist.
double FingerGait::calc_twist(VectorRef q) const {
  const Eigen::Quaterniond since(world::object_pose(*model_, q, goal_.object).R * from_.R.transpose());
  const double twist = 2 * std::atan2(since.vec().dot(axis_), since.w());
  return twist_ + std::remainder(twist - twist_, 2 * std::numbers::pi);
}

void FingerGait::begin_turn(VectorRef q) {
  twist_ = calc_twist(q);
  const double left = angle_ - twist_;
  const bool last = std::abs(left) <= kCycle;
  short_ = last && aimed_ ? short_ + left : 0;
  aimed_ = last;
  turn_ = std::clamp(left + short_, -kCycle, kCycle);
  finger_ = -1;
  hold_.leave(finger_);
  enter(Phase::Turn);
}

void FingerGait::turn() {
  const double done = std::min(kSpeed * time_, std::abs(turn_)), twist = twist_ + std::copysign(done, turn_);
  const double share = angle_ > 0 ? std::clamp(twist / angle_, 0.0, 1.0) : 1;
  set_reference({Eigen::AngleAxisd(twist, axis_).toRotationMatrix() * from_.R, from_.p + share * (goal_.X_WG.p - from_.p)});
  if (done >= std::abs(turn_)) enter(Phase::Settle);
}

/// Ends a turn: the reference takes the rotation that the object has reached, to hold it while fingers go back.
void FingerGait::end_turn(VectorRef q) {
  const double share = planning::goal_error(*model_, q, goal_).share(goal_);
  idle_ = share < nearest_ - kGain * std::abs(turn_) / goal_.tol_angle ? 0 : idle_ + 1;
  nearest_ = std::min(nearest_, share);
  set_reference({world::object_pose(*model_, q, goal_.object).R, world::object_pose(*model_, q_ref_, goal_.object).p});
}

/// Change of a finger's joints by which its last link leaves the object along the contact normal.
VectorXd FingerGait::calc_lift(VectorRef q, int finger) {
  const std::vector<int>& joints = chain(finger);
  const auto n = static_cast<Eigen::Index>(joints.size());
  const std::optional<FingerGap> gap = hold_.find_gap(q, finger);
  if (!gap) return VectorXd::Zero(n);
  Eigen::Matrix3Xd J = Eigen::Matrix3Xd::Zero(3, n);
  for (std::size_t k = 0; k < gap->dofs.size(); ++k) {
    const auto at = std::find(joints.begin(), joints.end(), gap->dofs[k] - model_->n_vu());
    if (at != joints.end()) J.col(at - joints.begin()) = gap->J.col(static_cast<Eigen::Index>(k));
  }
  const Eigen::Matrix3d damped = J * J.transpose() + kDamping * length_ * length_ * Eigen::Matrix3d::Identity();
  return J.transpose() * damped.ldlt().solve(Eigen::Vector3d(kLift * length_, 0, 0));
}

void FingerGait::begin_return(VectorRef q, const VectorXd& u, int finger) {
  finger_ = finger;
  const std::vector<int>& joints = chain(finger);
  const auto n = static_cast<Eigen::Index>(joints.size());
  VectorXd in_force(n), seen(n), home(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const int joint = joints[static_cast<std::size_t>(k)];
    in_force[k] = u[joint], seen[k] = q[model_->n_qu() + joint], home[k] = u_home_[joint];
  }
  stations_ = {in_force, seen + calc_lift(q, finger), home + calc_lift(q_home_, finger), home};
  hold_.leave(finger);
  enter(Phase::Return);
}

void FingerGait::move_finger(VectorXd& u) const {
  const std::vector<int>& joints = chain(finger_);
  double begin = 0;
  std::size_t k = 0;
  while (k + 1 < kReturn.size() && time_ > begin + kReturn[k]) begin += kReturn[k++];
  const double share = std::min(1.0, (time_ - begin) / kReturn[k]);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    const double wanted = stations_[k][i] + share * (stations_[k + 1][i] - stations_[k][i]);
    u[joints[j]] = std::clamp(wanted, model_->command_lower()[joints[j]], model_->command_upper()[joints[j]]);
  }
}

/// Enters the next phase if the present one is over.
void FingerGait::advance(VectorRef q, const VectorXd& u, double period) {
  const bool first = u_home_.size() == 0;
  if (phase_ == Phase::Close && time_ >= (first ? kClose : kSettle)) {
    if (first) q_home_ = q, u_home_ = u;
    begin_turn(q);
  } else if (phase_ == Phase::Settle && time_ >= kSettle) {
    end_turn(q);
    begin_return(q, u, 0);
  } else if (phase_ == Phase::Return && time_ > kReturn[0] + kReturn[1] + kReturn[2] + 0.5 * period) {
    if (finger_ + 1 < static_cast<int>(hold_.fingers().pairs.size())) {
      begin_return(q, u, finger_ + 1);
    } else {
      begin_turn(q);
    }
  }
}

Status FingerGait::update(VectorRef q, double period, VectorXd& u) {
  time_ += period;
  advance(q, u, period);
  if (phase_ == Phase::Turn) turn();
  if (phase_ == Phase::Return) move_finger(u);
  hold_.start(q_ref_);
  return hold_.update(q, period, u);
}

}  // namespace stiction::execution
