// Commands that move damped objects as planned.
#include "stiction/dynamics/against_damping.hpp"

#include "stiction/world/read.hpp"
#include "systems.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::VectorXd;

constexpr double kDamping = 60;  // of the drawer [N·s/m]

/// A finger on two sliders, the second one soft, in front of a drawer that moves along y.
std::shared_ptr<const world::Model> make_model(double soft) {
  const std::string k = std::to_string(soft);
  return world::Model::make(world::parse_scene(
      "robots: [{name: r, mjcf: \"<mujoco><worldbody><body><joint name='x' type='slide' axis='1 0 0' range='-1 1'/><inertial mass='1' "
      "pos='0 0 0' "
      "diaginertia='1 1 1'/><body><joint name='y' type='slide' axis='0 1 0' range='-1 1'/><inertial mass='1' pos='0 0 0' diaginertia='1 1 "
      "1'/><body><joint "
      "name='s' type='slide' axis='0 1 0' range='-1 1'/><geom size='.05' mass='1'/></body></body></body></worldbody><actuator><position "
      "joint='x' kp='100'/>"
      "<position joint='y' kp='100'/><position joint='s' kp='" +
          k +
          "'/></actuator></mujoco>\"}]\n"
          "objects: [{name: drawer, joint: slider, axis: [0, 1, 0], mass: 5, shapes: [{box: {size: [0.2, 0.2, 0.2]}}]}]\n",
      "."));
}

struct Push {
  VectorXd q, u, planned;
};

/// The finger touches the drawer and goes on by 1 cm.
Push push(const world::Model& model, StepWorkspace& work, StepResult& result) {
  Push out{.q = (VectorXd(4) << 0.15, 0, 0, 0).finished(), .u = VectorXd::Zero(3), .planned = {}};
  out.u[1] = 0.01;
  EXPECT_EQ(step(model, {out.q, out.u}, {}, work, result), Status::Solved);
  out.planned = result.delta;
  EXPECT_GT(out.planned[0], 0.008);
  return out;
}

TEST(AgainstDamping, StraightPush_SpringsBearTheDampingAndTheRobotStaysOnItsPath) {
  const auto model = make_model(20);
  StepWorkspace work(model);
  StepResult result;
  const Push given = push(*model, work, result);
  const VectorXd damping = VectorXd::Unit(4, 0) * kDamping;
  VectorXd command;
  ASSERT_TRUE(find_command(*model, {given.q, given.u, given.planned, damping}, {}, work, result, command));
  ASSERT_EQ(step(*model, {given.q, command, nullptr, &damping}, {}, work, result), Status::Solved);
  EXPECT_NEAR(result.delta[0], given.planned[0], 0.05 * given.planned[0]);
  const double force = kDamping * result.delta[0] / StepOptions{}.h;
  EXPECT_NEAR(command[1] - given.u[1], force / 100, 0.1 * force / 100) << "the stiff slider";
  EXPECT_NEAR(command[2] - given.u[2], force / 20, 0.1 * force / 20) << "the soft slider holds against the same force";
  for (int j = 1; j < 4; ++j) EXPECT_NEAR(result.delta[j], given.planned[j], 0.1 * given.planned[2]) << j;
}

TEST(AgainstDamping, ObjectThatDoesNotMove_LeavesTheCommand) {
  const auto model = make_model(20);
  StepWorkspace work(model);
  StepResult result;
  const VectorXd q = (VectorXd(4) << 0.15, 0, -0.3, 0).finished(), u = VectorXd::Constant(3, 0.1), planned = VectorXd::Unit(4, 2) * 0.1;
  const VectorXd damping = VectorXd::Unit(4, 0) * kDamping;
  VectorXd command;
  EXPECT_TRUE(find_command(*model, {q, u, planned, damping}, {}, work, result, command));
  EXPECT_EQ(command, u);
}

TEST(AgainstDamping, ObjectThatNothingTouches_CannotFollow) {
  const auto model = make_model(20);
  StepWorkspace work(model);
  StepResult result;
  const VectorXd q = (VectorXd(4) << 0.15, 0, -0.9, 0).finished(), u = VectorXd(q.tail(3)), planned = VectorXd::Unit(4, 0) * 0.1;
  const VectorXd damping = VectorXd::Unit(4, 0) * kDamping;
  VectorXd command;
  EXPECT_FALSE(find_command(*model, {q, u, planned, damping}, {}, work, result, command));
}

}  // namespace
}  // namespace stiction::dynamics::test
