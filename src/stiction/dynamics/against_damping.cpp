#include "stiction/dynamics/against_damping.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "stiction/world/object_space.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics {
namespace {

/// An object follows if it is off by at most this share of its motion, in the norm of its damping, or by less than what counts as motion.
constexpr double kOff = 0.2;
/// The search ends when objects are off by this share, or after kMostRounds steps.
constexpr double kConverged = 0.05;
constexpr int kMostRounds = 8;
/// Weight of the robot's motion beside that of damped objects.
constexpr double kRobotWeight = 0.03;
/// A robot that moves less counts as one that moves by this [joint units].
constexpr double kLeastMotion = 1e-6;
/// Regularisation of the least squares, as a share of the trace of its matrix.
constexpr double kRegularisation = 1e-6;

Eigen::VectorXd of_damped(const DampedMotion& motion, const Eigen::VectorXd& delta) {
  return (motion.damping.array() > 0).select(delta, 0.0);
}

/// W of (E.17). Objects count by √D_v, so by the work that their motion takes.
Eigen::VectorXd calc_weights(const world::Model& model, const DampedMotion& motion) {
  const int n = model.n_vu(), n_a = model.n_a();
  Eigen::VectorXd out(model.n_v());
  out << motion.damping.head(n).cwiseSqrt(), model.scales().joints().cwiseInverse();
  out.head(n) /= out.head(n).cwiseProduct(motion.planned.head(n)).norm();
  out.tail(n_a) *= kRobotWeight / std::max(out.tail(n_a).cwiseProduct(motion.planned.tail(n_a)).norm(), kLeastMotion);
  return out;
}

/// Least squares of W (B δu − e), which has more rows than unknowns. @param units  of δu
Eigen::VectorXd least_squares(const Eigen::MatrixXd& B, const Eigen::VectorXd& weights, const Eigen::VectorXd& units,
                              const Eigen::VectorXd& e) {
  const Eigen::MatrixXd A = weights.asDiagonal() * B * units.asDiagonal();
  Eigen::MatrixXd H = A.transpose() * A;
  H.diagonal().array() += kRegularisation * H.trace();
  return units.cwiseProduct(H.ldlt().solve(A.transpose() * weights.cwiseProduct(e)));
}

}  // namespace

bool moves_nothing(const world::Model& model, const Eigen::VectorXd& delta) {
  const double least = world::share::kMotionless;
  return world::largest_share(model, delta.head(model.n_vu()), least * model.scales().robots().length, least) < 1;
}

bool find_command(const world::Model& model, const DampedMotion& motion, const StepOptions& options, StepWorkspace& work,
                  StepResult& result, Eigen::VectorXd& command) {
  command = motion.u;
  if (moves_nothing(model, of_damped(motion, motion.planned))) return true;
  StepOptions with_B = options;
  with_B.smoothing = Exact{};
  with_B.with_A = with_B.effort_limits = false;
  with_B.with_B = true;
  const int n = model.n_vu();
  const Eigen::VectorXd weights = calc_weights(model, motion);
  for (int round = 1;; ++round) {
    work.forget();
    if (step(model, {motion.q, command, nullptr, &motion.damping}, with_B, work, result) != core::Status::Solved) return false;
    const Eigen::VectorXd off = motion.planned - result.delta;
    const double share = weights.head(n).cwiseProduct(off.head(n)).norm();
    if (share <= kConverged || moves_nothing(model, of_damped(motion, off))) return true;
    if (round == kMostRounds) return share <= kOff;
    command += least_squares(result.B, weights, model.scales().joints(), off);
  }
}

}  // namespace stiction::dynamics
