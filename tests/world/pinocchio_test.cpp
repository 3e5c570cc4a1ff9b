// Poses of robots against Pinocchio's own URDF reader and forward kinematics: nothing is shared but the file.
#include <pinocchio/fwd.hpp>

#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include <gtest/gtest.h>

#include "world/test_scenes.hpp"

namespace stiction::world {
namespace {

using Eigen::VectorXd;

class AgainstPinocchio : public testing::TestWithParam<const char*> {};

TEST_P(AgainstPinocchio, EveryLinkHasTheSamePose) {
  const auto file = test::source_dir() / GetParam();
  pinocchio::Model reference;
  pinocchio::urdf::buildModel(file.string(), reference);
  pinocchio::Data data(reference);

  core::Random random(11, 0);
  Scene scene;
  RobotSpec robot;
  robot.name = "robot";
  robot.urdf = file;
  robot.X_WBase = test::random_pose(random);
  for (pinocchio::JointIndex j = 1; j < static_cast<pinocchio::JointIndex>(reference.njoints); ++j) robot.stiffness.emplace_back(reference.names[j], 1.0);
  scene.robots.push_back(robot);
  const auto model = Model::make(scene);
  ASSERT_EQ(model->n_a(), reference.nv);

  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  for (int sample = 0; sample < 20; ++sample) {
    const VectorXd q = test::random_vector(random, model->n_q(), 1);
    VectorXd q_reference(reference.nq);
    for (pinocchio::JointIndex j = 1; j < static_cast<pinocchio::JointIndex>(reference.njoints); ++j) {
      const double value = q[model->joint_index(reference.names[j])];
      const auto& joint = reference.joints[j];
      if (joint.nq() == 2) {   // continuous: (cos, sin)
        q_reference[joint.idx_q()] = std::cos(value);
        q_reference[joint.idx_q() + 1] = std::sin(value);
      } else {
        q_reference[joint.idx_q()] = value;
      }
    }
    pinocchio::framesForwardKinematics(reference, data, q_reference);
    calc_kinematics(*model, q, work, kinematics);
    for (std::size_t b = 0; b < model->bodies().size(); ++b) {
      const std::string link = model->bodies()[b].name.substr(6);
      const auto& X = data.oMf[reference.getFrameId(link, pinocchio::BODY)];
      const Pose expected = robot.X_WBase * Pose{X.rotation(), X.translation()};
      EXPECT_LT((kinematics.X_WB[b].R - expected.R).norm(), 1e-13) << link;
      EXPECT_LT((kinematics.X_WB[b].p - expected.p).norm(), 1e-13) << link;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, AgainstPinocchio,
                         testing::Values("models/allegro_hand.urdf", "models/planar_arm_left.urdf", "models/planar_arm_right.urdf",
                                         "tests/world/data/odd_robot.urdf"),
                         [](const auto& robot) { return std::filesystem::path(robot.param).stem().string(); });

}  // namespace
}  // namespace stiction::world
