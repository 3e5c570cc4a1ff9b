#include "stiction/world/srdf.hpp"

#include <gtest/gtest.h>

#include <set>

#include "world/robot_files.hpp"

namespace stiction::world::test {
namespace {

/// Three links in a row, each of which is far from the others, and a hull at the end.
constexpr const char* kThreeJoints = R"(<robot name="r">
<link name="base"><collision><geometry><box size=".2 .2 .2"/></geometry></collision></link>
<link name="a"><collision><origin xyz="0 0 .4"/><geometry><box size=".1 .1 .4"/></geometry></collision></link>
<link name="b"><collision><origin xyz="0 0 .3"/><geometry><box size=".1 .1 .4"/></geometry></collision></link>
<link name="hull"><collision><origin xyz=".6 0 0"/><geometry><sphere radius=".05"/></geometry></collision></link>
<joint name="j1" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 .15"/><limit lower="-3" upper="3" effort="10"/></joint>
<joint name="j2" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 .75"/><limit lower="-3" upper="3" effort="10"/></joint>
<joint name="j3" type="revolute"><parent link="b"/><child link="hull"/><origin xyz="0 0 .6"/><limit lower="-3" upper="3" effort="10"/></joint>
</robot>)";

class SrdfFile : public testing::Test {
 protected:
  void SetUp() override { folder_.write("r.urdf", kThreeJoints); }

  /// Pairs of links that may touch, as "a b", with the elements of an SRDF.
  std::set<std::string> touching(const std::string& elements) const {
    folder_.write("r.srdf", "<robot name='r'>" + elements + "</robot>");
    const auto model = folder_.load("urdf: r.urdf, srdf: r.srdf");
    std::set<std::string> out;
    for (const Pair& pair : model->pairs()) {
      const auto link = [&](int geometry) {
        return model->bodies()[static_cast<std::size_t>(model->geometries()[static_cast<std::size_t>(geometry)].body)].name.substr(2);
      };
      out.insert(link(pair.geometry_a) + " " + link(pair.geometry_b));
    }
    return out;
  }

  const RobotFolder folder_{};
};

TEST_F(SrdfFile, DisabledPairs_NeverTouch) {
  EXPECT_EQ(touching(""), (std::set<std::string>{"base b", "base hull", "a hull"}));
  EXPECT_EQ(touching("<disable_collisions link1='b' link2='base' reason='Never'/><disable_collisions link1='gone' link2='a'/>"),
            (std::set<std::string>{"base hull", "a hull"}));
}

TEST_F(SrdfFile, LinkThatIsDisabledByDefault_TouchesOnlyWhatIsEnabled) {
  EXPECT_EQ(touching("<disable_default_collisions link='hull'/>"), (std::set<std::string>{"base b"}));
  EXPECT_EQ(touching("<disable_default_collisions link='hull'/><enable_collisions link1='hull' link2='base'/>"),
            (std::set<std::string>{"base b", "base hull"}));
  EXPECT_EQ(touching("<enable_collisions link1='hull' link2='base'/><disable_default_collisions link='hull'/>"
                     "<disable_default_collisions link='gone'/><disable_collisions link1='base' link2='hull'/>"),
            (std::set<std::string>{"base b"}))
      << "a pair that is disabled by name stays so";
}

TEST_F(SrdfFile, Stub_DisablesNothingAndIsNoted) {
  for (const char* stub : {"", "<?xml version='1.0'?>\n", "<?xml version='1.0'?>\n<!-- to be filled -->\n", "  \n"}) {
    folder_.write("stub.srdf", stub);
    const auto model = folder_.load("urdf: r.urdf, srdf: stub.srdf");
    EXPECT_EQ(model->pairs().size(), 3u) << stub;
    EXPECT_TRUE(has_note(*model, "r: stub.srdf has no element, so that it disables no pair of links")) << stub;
  }
}

TEST_F(SrdfFile, WhatIsNoSrdf_IsRefusedByName) {
  const auto message = [&](const std::string& text) {
    folder_.write("bad.srdf", text);
    return folder_.message("urdf: r.urdf, srdf: bad.srdf");
  };
  EXPECT_EQ(message("<html><body>404</body></html>"),
            "bad.srdf:1: root element: got 'html', so a web page, expected 'robot', the root of an SRDF; download the file itself");
  EXPECT_EQ(message("<!DOCTYPE html>\n<html><br>404</html>"),
            "bad.srdf:1: srdf: got a web page, expected an SRDF; download the file itself");
  EXPECT_EQ(message("<mujoco/>"),
            "bad.srdf:1: root element: got 'mujoco', so an MJCF, expected 'robot', the root of an SRDF; an MJCF stands under the key mjcf");
  EXPECT_EQ(message("<moveit/>"), "bad.srdf:1: root element: got 'moveit', expected 'robot'");
  EXPECT_EQ(message(kThreeJoints),
            "bad.srdf:2: srdf: got an element 'link', so a URDF, expected an SRDF; a URDF stands under the key urdf");
  EXPECT_EQ(message("<robot>\n<disable_collisions"), "bad.srdf:2: srdf: got malformed XML (XML_ERROR_PARSING_ELEMENT), expected an SRDF");
  EXPECT_EQ(message("<robot><disable_default_collisions/></robot>"),
            "bad.srdf:1: disable_default_collisions: got no attribute link, expected one");
}

TEST_F(SrdfFile, JointsThatMoveOtherwiseThanTheFileHasThem_AreNoted) {
  folder_.write("r.srdf",
                "<robot name='r'><passive_joint name='j2'/><virtual_joint name='on_floor' type='planar' parent_frame='w' "
                "child_link='base'/><virtual_joint name='bolted' type='fixed' parent_frame='w' child_link='base'/></robot>");
  const auto model = folder_.load("urdf: r.urdf, srdf: r.srdf");
  EXPECT_TRUE(has_note(*model, "passive joints of the SRDF have motors here: j2"));
  EXPECT_TRUE(has_note(*model, "virtual joints of the SRDF that would move the base, which stands still here: on_floor (planar)"));
}

}  // namespace
}  // namespace stiction::world::test
