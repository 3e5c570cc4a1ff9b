#include "contact_ticks.hpp"

#include "stiction/core/random.hpp"
#include "stiction/world/point_jacobian.hpp"

namespace stiction::bench {
namespace {

constexpr double kLambdaMax = 15;  // [N]
constexpr int kLinks = 4;          // the last ones are touched
constexpr double kReach = 0.1;     // of contact points from the origins of their links [m]
constexpr double kSpread = 0.02;   // of the reference where no contact is [rad]

Eigen::Vector3d direction(core::Random& random) {
  Eigen::Vector3d v;
  do
    for (double& x : v) x = random.normal();
  while (v.norm() == 0);
  return v.normalized();
}

}  // namespace

std::vector<ContactTick> make_contact_ticks(const world::Model& model, const control::RobotLimits& robot, int contacts, int count,
                                            std::uint64_t seed) {
  const Eigen::Index n = model.n_a();
  const int last = static_cast<int>(model.bodies().size()) - 1;
  core::Random random(seed, static_cast<std::uint64_t>(contacts));
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  control::RowMatrix J_point = control::RowMatrix::Zero(6, n);
  std::vector<ContactTick> ticks(static_cast<std::size_t>(count));
  for (ContactTick& t : ticks) {
    t.q.resize(n);
    for (Eigen::Index j = 0; j < n; ++j) t.q[j] = random.uniform(robot.lower[j], robot.upper[j]) / 2;
    world::calc_kinematics(model, t.q, work, kinematics);
    t.J_u.resize(contacts, n);
    t.lambda.resize(contacts);
    t.lambda_max.setConstant(contacts, kLambdaMax);
    Eigen::VectorXd behind(contacts);
    for (int i = 0; i < contacts; ++i) {
      const int body = last - random.index(kLinks);
      const Eigen::Vector3d p_W = kinematics.X_WB[static_cast<std::size_t>(body)].p + kReach * random.uniform() * direction(random);
      world::calc_point_jacobian(model, kinematics, body, p_W, J_point);
      t.J_u.row(i) = direction(random).transpose() * J_point.topRows<3>();
      t.lambda[i] = random.uniform(0, 1.2 * kLambdaMax);
      behind[i] = random.uniform(0.02, 0.05);
    }
    const Eigen::VectorXd soft = robot.stiffness.cwiseInverse();
    t.q_cmd = t.q - soft.cwiseProduct(t.J_u.transpose() * t.lambda);
    const Eigen::MatrixXd G = t.J_u * soft.asDiagonal() * t.J_u.transpose();
    t.q_ref = t.q - soft.cwiseProduct(t.J_u.transpose() * G.completeOrthogonalDecomposition().solve(behind));
    for (double& x : t.q_ref) x += kSpread * random.normal();
    t.damping = random.uniform();
  }
  return ticks;
}

}  // namespace stiction::bench
