// Springs of hinges and sliders: steps end where the springs of objects, those of robots and the regularisation balance.
#include <gtest/gtest.h>

#include "dynamics/systems.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;
using world::ObjectJoint;

/// A ball of 0.1 m on a slider along x, with a spring.
std::shared_ptr<const Model> slider(double mass, double spring, double rest) {
  world::Scene scene = empty_scene();
  scene.gravity.setZero();
  world::ObjectSpec object = ball(ObjectJoint::Slider, mass, 0.1, 0);
  object.axis = Vector3d::UnitX();
  object.joint_stiffness = spring;
  object.joint_rest = rest;
  scene.objects.push_back(object);
  return Model::make(scene);
}

/// (ε m/h + h k) δ = h k (q₀ − q).
TEST(JointSpring, SliderLeftAlone_GoesWhereItsSpringIsAtRest) {
  const double m = 2, k = 30, rest = 0.4, h = 0.1, epsilon = 0.5;
  const auto model = slider(m, k, rest);
  StepWorkspace work(model);
  StepResult out;
  StepOptions options;
  options.h = h;
  options.regularisation = FixedEpsilon{epsilon};
  options.with_A = true;
  const VectorXd q = VectorXd::Constant(1, 0.1);
  ASSERT_EQ(step(*model, {q, VectorXd(0)}, options, work, out), Status::Solved);
  const double share = h * k / (epsilon * m / h + h * k);
  EXPECT_NEAR(out.q_next[0], 0.1 + share * (rest - 0.1), 1e-12);
  EXPECT_NEAR(out.A(0, 0), 1 - share, 1e-12) << "of q_next by q";
}

/// A latch of stiffness k that a weight m g r turns: k (q₀ − q) + m g r cos q = 0.
TEST(JointSpring, LeverOnASpring_HangsWhereItBalancesItsWeight) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 0, -10};
  world::ObjectSpec object = ball(ObjectJoint::Hinge, 2, 0.1, 0);
  object.axis = -Vector3d::UnitX();
  object.p_BCom = {0, 0.3, 0};
  object.joint_stiffness = 12;
  scene.objects.push_back(object);
  const auto model = Model::make(scene);
  StepWorkspace work(model);
  StepResult out;
  VectorXd q = VectorXd::Zero(1);
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(step(*model, {q, VectorXd(0)}, {}, work, out), Status::Solved);
    q = out.q_next;
  }
  EXPECT_NEAR(12 * q[0], 2 * 10 * 0.3 * std::cos(q[0]), 1e-6);
  EXPECT_GT(q[0], 0.3);
}

}  // namespace
}  // namespace stiction::dynamics::test
