#include "stiction/world/joint_speeds.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "support/message_of.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::world {
namespace {

/// A cart whose joint has the given limits.
std::shared_ptr<const Model> cart(const std::string& limit) {
  const std::filesystem::path file = stiction::test::folder_of_the_process() / "cart_with_speed.urdf";
  std::ofstream(file)
      << "<robot name='cart'><link name='rail'/><link name='body'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>"
         "<joint name='x' type='prismatic'><parent link='rail'/><child link='body'/><axis xyz='1 0 0'/>"
      << limit << "</joint></robot>";
  Scene scene;
  RobotSpec& robot = scene.robots.emplace_back();
  robot.name = "cart";
  robot.urdf = file;
  robot.stiffness = {{"x", 100}};
  return Model::make(scene);
}

TEST(JointSpeeds, AreThoseOfTheFileAndInfiniteWhereItSaysNothing) {
  EXPECT_EQ(read_joint_speeds(*cart("<limit lower='-1' upper='1' effort='5' velocity='0.25'/>"))[0], 0.25);
  const double none = std::numeric_limits<double>::infinity();
  EXPECT_EQ(read_joint_speeds(*cart("<limit lower='-1' upper='1' effort='5'/>"))[0], none);
  EXPECT_EQ(read_joint_speeds(*cart("<limit lower='-1' upper='1' effort='5' velocity='0'/>"))[0], none);
}

TEST(JointSpeeds, WrongNumber_IsNamedWithItsLine) {
  const auto model = cart("<limit lower='-1' upper='1' effort='5' velocity='fast'/>");
  const std::string message = test::message_of([&] { (void)read_joint_speeds(*model); });
  EXPECT_NE(message.find("cart_with_speed.urdf:1: joint 'x' velocity: got 'fast', expected a number > 0"), std::string::npos) << message;
}

}  // namespace
}  // namespace stiction::world
