// Poses of robots against Pinocchio's own URDF reader and forward kinematics: nothing is shared but the file.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "stiction/world/urdf.hpp"
#include "support/temporary_folder.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world {
namespace {

using Eigen::VectorXd;

class AgainstPinocchio : public testing::TestWithParam<const char*> {};

std::string run(const std::string& command) {
  std::string out;
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return out;
  char buffer[4096];
  while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) out.append(buffer, n);
  EXPECT_EQ(::pclose(pipe), 0) << command;
  return out;
}

TEST_P(AgainstPinocchio, EveryLinkHasTheSamePose) {
  const auto file = test::source_dir() / GetParam();
  core::Random random(11, 0);
  Scene scene;
  RobotSpec robot;
  robot.name = "robot";
  robot.urdf = file;
  robot.X_WBase = test::random_pose(random);
  const auto joints = read_urdf(file, {}).robot.movable_joints();
  for (const auto& joint : joints) robot.stiffness.emplace_back(joint, 1.0);
  scene.robots.push_back(robot);
  const auto model = Model::make(scene);

  constexpr int kSamples = 20;
  std::vector<VectorXd> samples;
  std::ostringstream questions;
  questions.precision(17);
  for (int sample = 0; sample < kSamples; ++sample) {
    samples.push_back(test::random_vector(random, model->n_q(), 1));
    for (const auto& joint : joints) questions << joint << ' ' << samples.back()[model->joint_index(joint)] << '\n';
    questions << "end\n";
  }
  const auto input = stiction::test::folder_of_the_process() / "configurations.txt";
  std::ofstream(input) << questions.str();
  std::istringstream answers(run(std::string(STICTION_PINOCCHIO_ORACLE) + " '" + file.string() + "' < '" + input.string() + "'"));
  std::filesystem::remove(input);

  KinematicsWorkspace work(*model);
  Kinematics kinematics;
  for (const VectorXd& q : samples) {
    calc_kinematics(*model, q, work, kinematics);
    for (std::size_t line = 0; line < model->bodies().size(); ++line) {
      std::string link;
      ASSERT_TRUE(answers >> link);
      Pose X_BaseL;
      for (int i = 0; i < 9; ++i) answers >> X_BaseL.R(i / 3, i % 3);
      for (int i = 0; i < 3; ++i) answers >> X_BaseL.p[i];
      ASSERT_TRUE(answers.good());
      const auto body =
          std::find_if(model->bodies().begin(), model->bodies().end(), [&](const Body& b) { return b.name == "robot/" + link; });
      ASSERT_NE(body, model->bodies().end()) << link;
      const Pose expected = robot.X_WBase * X_BaseL;
      const Pose& got = kinematics.X_WB[static_cast<std::size_t>(body - model->bodies().begin())];
      EXPECT_LT((got.R - expected.R).norm(), 1e-13) << link;
      EXPECT_LT((got.p - expected.p).norm(), 1e-13) << link;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, AgainstPinocchio,
                         testing::Values("models/allegro_hand.urdf", "models/planar_arm_left.urdf", "models/planar_arm_right.urdf",
                                         "tests/world/data/odd_robot.urdf"),
                         [](const auto& robot) { return std::filesystem::path(robot.param).stem().string(); });

}  // namespace
}  // namespace stiction::world
