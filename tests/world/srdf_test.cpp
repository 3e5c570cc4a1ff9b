#include "stiction/world/srdf.hpp"

#include <gtest/gtest.h>

#include <set>

#include "stiction/world/read.hpp"
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

/// Of a scene in one file, objects and links fixed to them are links of the SRDF as well.
TEST_F(SrdfFile, DisabledPairsWithObjects_NeverTouch) {
  folder_.write("s.urdf", R"(<robot name="s"><link name="world"/>
<link name="arm"><collision><geometry><sphere radius=".1"/></geometry></collision></link>
<link name="hand"><collision><geometry><sphere radius=".1"/></geometry></collision></link>
<link name="door"><collision><geometry><box size=".1 .1 .1"/></geometry></collision></link>
<link name="knob"><collision><geometry><sphere radius=".05"/></geometry></collision></link>
<joint name="j1" type="prismatic"><parent link="world"/><child link="arm"/><limit lower="-3" upper="3" effort="10"/></joint>
<joint name="j2" type="prismatic"><parent link="arm"/><child link="hand"/><origin xyz=".4 0 0"/><limit lower="-3" upper="3" effort="10"/></joint>
<joint name="d" type="prismatic"><parent link="world"/><child link="door"/><origin xyz="0 .3 0"/><limit lower="-3" upper="3"/></joint>
<joint name="glue" type="fixed"><parent link="door"/><child link="knob"/></joint><transmission name="t"><joint name="j1"/></transmission></robot>)");
  folder_.write("m.xml", R"(<mujoco model="m"><worldbody><geom name="floor" type="plane" size="1 1 1"/>
<body name="arm"><joint name="j1" type="slide"/><geom size=".1"/><body name="hand" pos=".4 0 0"><joint type="slide"/><geom size=".1"/></body></body>
<body name="door" pos="0 .3 0"><joint type="slide"/><geom type="box" size=".1 .1 .1"/><body name="knob"><geom size=".05"/></body></body></worldbody>
<actuator><position joint="j1"/></actuator></mujoco>)");
  const auto touching_in = [&](const std::string& file, const std::string& elements) {
    folder_.write("s.srdf", "<robot name='s'>" + elements + "</robot>");
    const auto model = Model::make(parse_scene("file: " + file + "\nrobot: {srdf: s.srdf}", folder_.path()));
    std::set<std::string> out;
    for (const Pair& pair : model->pairs()) {
      const auto name = [&](int geometry) { return model->geometries()[static_cast<std::size_t>(geometry)].name; };
      if (!name(pair.geometry_b).starts_with("robot_world")) out.insert(name(pair.geometry_a) + " " + name(pair.geometry_b));
    }
    return out;
  };
  for (const std::string file : {"s.urdf", "m.xml"}) {
    const std::set<std::string> all = touching_in(file, "");
    EXPECT_EQ(all.size(), 4u) << file << ": two links and two shapes of the door";
    std::set<std::string> but_door = all, but_hand = all;
    std::erase_if(but_door, [](const std::string& pair) { return pair == "door/box_0 robot/hand/sphere_0"; });
    EXPECT_EQ(but_door.size(), 3u) << file;
    EXPECT_EQ(touching_in(file, "<disable_collisions link1='hand' link2='door'/><disable_collisions link1='gone' link2='knob'/>"), but_door)
        << file;
    std::erase_if(but_hand, [](const std::string& pair) { return pair.find("hand") != std::string::npos; });
    EXPECT_EQ(touching_in(file, "<disable_default_collisions link='hand'/>"), but_hand) << file;
  }
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
