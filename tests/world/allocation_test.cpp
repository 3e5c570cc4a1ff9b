// No heap use after the first call. Every malloc of this program is counted (glibc; not under sanitizers, which bring their own).
#include <gtest/gtest.h>

#include "cone_allocations.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world {
namespace {

using Eigen::VectorXd;

TEST(Kinematics, AfterTheFirstCall_NothingIsAllocated) {
  const auto model = Model::make(test::make_zoo());
  core::Random random(1, 0);
  const VectorXd q = test::random_configuration(*model, random), delta = test::random_vector(random, model->n_v(), 0.1);
  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  VectorXd q_next(model->n_q()), back(model->n_v()), tau(model->n_vu());
  Eigen::MatrixXd mass(6, 6);
  double sum = 0;
  const auto everything = [&] {
    calc_kinematics(*model, q, work, kinematics);
    calc_object_mass(*model, kinematics, 1, mass);
    calc_gravity(*model, kinematics, tau);
    retract(*model, q, delta, q_next);
    local(*model, q, q_next, back);
    require_configuration(*model, "q", q);
    sum += object_pose(*model, q, 1).p[0] + robot_part(*model, q)[0];
  };
  everything();
  const long before = bench::allocations();
  for (int i = 0; i < 10; ++i) everything();
  EXPECT_EQ(bench::allocations(), before);
  EXPECT_TRUE(std::isfinite(sum));
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  const auto counted = std::make_unique<std::vector<int>>(100);
  EXPECT_GT(bench::allocations(), before) << "the counter does not count";
}

}  // namespace
}  // namespace stiction::world
