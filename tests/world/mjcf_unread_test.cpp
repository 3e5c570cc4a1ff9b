// What an MJCF says and what is not read is told once, with what it changes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "world/robot_files.hpp"

namespace stiction::world::test {
namespace {

class MjcfUnread : public testing::Test {
 protected:
  /// The note on a ball on a slide of which parts are written differently; empty where there is none.
  std::string note(const std::string& geom, const std::string& joint = "", const std::string& more = "") const {
    folder_.write("r.xml", "<mujoco>" + more + "<worldbody><body name='cart'><joint name='x' type='slide' range='-1 1' " + joint +
                               "/><geom name='g' type='sphere' size='0.1' " + geom + "/></body></worldbody></mujoco>");
    const auto model = folder_.load("mjcf: r.xml");
    for (const std::string& said : model->notes()) {
      if (const std::string head = "r: not read: "; said.starts_with(head)) return said.substr(head.size());
    }
    return "";
  }

  const RobotFolder folder_{};
};

TEST_F(MjcfUnread, UsualValuesAreNotNamed) {
  EXPECT_EQ(note(""), "");
  EXPECT_EQ(note("margin='0' condim='3' friction='0.5 0.01 0.01'", "damping='1' frictionloss='0.1' ref='0.2'"), "");
  EXPECT_EQ(note("contype='0' conaffinity='0' margin='0.1' condim='6'"), "") << "a geom that does not collide";
}

TEST_F(MjcfUnread, AttributesOfGeoms) {
  EXPECT_EQ(note("margin='0.01'"), "margin of geoms g (contact begins at the surface, so that things rest that much nearer to each other)");
  EXPECT_EQ(note("condim='1'"), "");
  EXPECT_EQ(note("condim='4'"), "");
  EXPECT_EQ(note("condim='6'"), "condim 6 of geoms g (contacts resist rolling in simulation, but plans do without)");
  EXPECT_EQ(note("priority='1'"), "");
  EXPECT_EQ(note("solref='0.01 1'"), "solmix, solref, solimp of geoms g (contacts are rigid)");
  EXPECT_EQ(note("gap='0.01'"), "gap of geoms g (contact_distance of the scene says from where on contacts are looked at)");
  EXPECT_EQ(
      note("margin='0.01' condim='6'"),
      "margin of geoms g (contact begins at the surface, so that things rest that much nearer to each other); condim 6 of geoms g "
      "(contacts resist rolling in simulation, but plans do without)");
}

TEST_F(MjcfUnread, AttributesOfJoints) {
  EXPECT_EQ(note("", "armature='0.1' damping='3'"), "") << "the plant has them";
  EXPECT_EQ(note("", "margin='0.1'"), "margin of joints x (limits begin at the range)");
  EXPECT_EQ(note("", "solreflimit='0.01 1'"),
            "solreflimit, solimplimit, solreffriction, solimpfriction of joints x (limits and friction are rigid)");
}

TEST_F(MjcfUnread, AttributesOfActuators) {
  const auto servo = [&](const std::string& attributes) {
    folder_.write("r.xml",
                  "<mujoco><worldbody><body name='cart'><joint name='x' type='slide' range='-1 1'/><geom type='sphere' size='0.1'/>"
                  "</body></worldbody><actuator><general name='m' joint='x' gainprm='100' biastype='affine' biasprm='0 -100 -5' " +
                      attributes + "/></actuator></mujoco>");
    const auto model = folder_.load("mjcf: r.xml");
    for (const std::string& said : model->notes()) {
      if (said.starts_with("r: not read: ")) return said.substr(13);
    }
    return std::string();
  };
  EXPECT_EQ(servo(""), "");
  EXPECT_EQ(servo("ctrllimited='true' ctrlrange='-1 1'"), "");
  EXPECT_EQ(servo("ctrllimited='true' ctrlrange='-1 0.5'"),
            "ctrlrange of actuators m (commands may be anywhere in the range of the joint)");
  EXPECT_EQ(servo("dyntype='filter' dynprm='0.1'"), "dyntype and delay of actuators m (joints feel commands at once)");
}

TEST_F(MjcfUnread, OptionsAndKeyframes) {
  EXPECT_EQ(note("", "", "<option gravity='0 0 0'/>"),
            "option gravity 0 0 0 (that of the scene counts, which is [0, 0, -9.81] where it says none)");
  EXPECT_EQ(note("", "", "<option density='1.2'/>"), "option wind, density, viscosity (nothing flows)");
  EXPECT_EQ(note("", "", "<option><flag contact='disable' gravity='disable'/></option>"),
            "flags that switch off contact, gravity (these act)");
  EXPECT_EQ(note("", "", "<keyframe><key name='home' qpos='0.1'/></keyframe>"), "") << "a task may start there";
}

TEST_F(MjcfUnread, FreeBodyWithDryFriction) {
  const auto load = [&](const char* attribute) {
    folder_.write("r.xml",
                  fmt::format("<mujoco><worldbody><body name='ball'><joint name='f' type='free' {}/><geom type='sphere' size='0.1'/>"
                              "</body></worldbody></mujoco>",
                              attribute));
    return folder_.load("mjcf: r.xml");
  };
  constexpr const char* kNote = "frictionloss of joints f (free objects move without)";
  EXPECT_TRUE(has_note(*load("frictionloss='1'"), kNote));
  EXPECT_FALSE(has_note(*load("damping='1'"), kNote));
}

}  // namespace
}  // namespace stiction::world::test
