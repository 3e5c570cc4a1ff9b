#include "stiction/execution/closed_loop/object_watch.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "world/gripper.hpp"

namespace stiction::execution {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// 3 mm aside, 8 mm above and rolled by 0.3 rad, with tolerances of 5 mm and 0.1 rad: what is open counts nothing.
TEST(ShareOff, AfterTheLastPush_IsThatOfTheCoordinatesThatTheGoalBounds) {
  const world::test::RobotFolder folder;
  const auto model = world::test::make_gripper(folder, 0.1);
  planning::Goal goal;
  goal.tol_position = 5e-3;
  Eigen::VectorXd planned = world::test::gripper_start(*model), q = planned;
  q.head<3>() += Eigen::Vector3d(3e-3, 0, 8e-3);
  q.segment<4>(3) = Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX())).coeffs();
  const auto share = [&](const std::vector<int>& bounded) {
    goal.region = planning::GoalRegion{Eigen::VectorXd::Constant(6, -kInfinity), Eigen::VectorXd::Constant(6, kInfinity)};
    for (const int i : bounded) goal.region->lower[i] = 1;  // somewhere else: the goal is not what is measured from
    return share_off(*model, planned, q, goal, true);
  };
  EXPECT_NEAR(share({2}), 1.6, 1e-6);
  EXPECT_NEAR(share({0, 1}), 0.6, 1e-6);
  EXPECT_NEAR(share({0, 1, 2}), std::hypot(3, 8) / 5, 1e-6);
  EXPECT_NEAR(share({0, 1, 2, 3, 4, 5}), 3, 1e-6);
  EXPECT_NEAR(share({0, 5}), 0.6, 1e-6) << "the yaw is as planned";
  EXPECT_NEAR(share_between(*model, planned, q, goal), 3, 1e-6);
  goal.region.reset();
  EXPECT_NEAR(share_off(*model, planned, q, goal, true), 3, 1e-6);
}

}  // namespace
}  // namespace stiction::execution
