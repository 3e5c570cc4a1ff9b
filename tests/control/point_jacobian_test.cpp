#include "stiction/world/point_jacobian.hpp"

#include <gtest/gtest.h>

#include "control/arm_scene.hpp"
#include "stiction/control/small_cholesky.hpp"
#include "stiction/core/random.hpp"

namespace stiction::control::test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

TEST(PointJacobian, RandomPostures_AgreeWithDifferences) {
  const auto model = make_arm();
  core::Random random(1, 0);
  world::KinematicsWorkspace work(*model);
  world::Kinematics at, ahead, behind;
  RowMatrix J(6, 7);
  for (int trial = 0; trial < 20; ++trial) {
    VectorXd q(7);
    for (double& x : q) x = random.uniform(-2, 2);
    const int body = find_body(*model, "arm/link_" + std::to_string(1 + random.index(7)));
    const Vector3d p_BP(random.normal(), random.normal(), random.normal());
    calc_kinematics(*model, q, work, at);
    const auto b = static_cast<std::size_t>(body);
    world::calc_point_jacobian(*model, at, body, at.X_WB[b] * p_BP, J);
    for (int j = 0; j < 7; ++j) {
      const double h = 1e-5;  // central: error h² of third derivatives of lengths ~ 3 m, rounding 1e-16 / h
      VectorXd q_h = q;
      q_h[j] += h;
      calc_kinematics(*model, q_h, work, ahead);
      q_h[j] -= 2 * h;
      calc_kinematics(*model, q_h, work, behind);
      const Vector3d v = (ahead.X_WB[b] * p_BP - behind.X_WB[b] * p_BP) / (2 * h);
      const Eigen::Matrix3d W = (ahead.X_WB[b].R - behind.X_WB[b].R) / (2 * h) * at.X_WB[b].R.transpose();
      EXPECT_LE((J.col(j).head<3>() - v).norm(), 1e-8);
      EXPECT_LE((J.col(j).tail<3>() - Vector3d(W(2, 1), W(0, 2), W(1, 0))).norm(), 1e-8);
    }
  }
}

}  // namespace
}  // namespace stiction::control::test
