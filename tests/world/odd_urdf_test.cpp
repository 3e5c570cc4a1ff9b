// Values that exporters write where they have none: shapes of no size, limits that mean no limit.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "stiction/world/robot_tree.hpp"
#include "world/robot_files.hpp"

namespace stiction::world::test {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

TEST(ShapesOfNoSize, AreLeftOutWithANote) {
  const RobotFolder folder;
  folder.write("tip.obj", kTetrahedron);
  for (const char* shape : {"<box size='0 0 0'/>", "<box size='0.1 0.1 0'/>", "<sphere radius='0'/>", "<cylinder radius='0' length='0'/>",
                            "<cylinder radius='0.1' length='0'/>", "<capsule radius='0' length='1'/>",
                            "<mesh filename='tip.obj' scale='0 0 0'/>", "<mesh filename='tip.obj' scale='1 1 0'/>"}) {
    folder.write("r.urdf", one_joint(collision(shape) + collision("<sphere radius='0.1'/>")));
    const auto model = folder.load("urdf: r.urdf");
    ASSERT_EQ(model->geometries().size(), 1u) << shape;
    EXPECT_EQ(model->geometries()[0].name, "r/tip/sphere_1") << "the number of its element";
    EXPECT_TRUE(has_note(*model, "r: shapes without a volume touch nothing and are left out, of links: tip")) << shape;
  }
}

TEST(ShapesOfNoSize, CapsuleWithoutLength_IsASphere) {
  const RobotFolder folder;
  folder.write("r.urdf", one_joint(collision("<capsule radius='0.1' length='0'/>")));
  const auto model = folder.load("urdf: r.urdf");
  ASSERT_EQ(model->geometries().size(), 1u);
  EXPECT_EQ(std::get<Sphere>(model->geometries()[0].shape).radius, 0.1);
}

TEST(ShapesOfNoSize, NegativeSizes_AreRefused) {
  const RobotFolder folder;
  const auto message = [&](const std::string& shape) {
    folder.write("r.urdf", one_joint(collision(shape)));
    return folder.message("urdf: r.urdf");
  };
  EXPECT_EQ(message("<box size='0.1 0.1 -0.1'/>"), "r.urdf:1: box size: got 0.1 0.1 -0.1, expected three numbers > 0, or 0 for no shape");
  EXPECT_EQ(message("<sphere radius='-1'/>"), "r.urdf:1: sphere radius: got -1, expected a number > 0, or 0 for no shape");
  EXPECT_EQ(message("<cylinder radius='0' length='-1'/>"), "r.urdf:1: cylinder length: got -1, expected a number > 0, or 0 for no shape");
}

TEST(PlaceholderLimits, MeanNone) {
  const RobotFolder folder;
  const auto load = [&](const std::string& kind, const std::string& lower, const std::string& upper) {
    folder.write("r.urdf", one_joint(collision("<sphere radius='0.1'/>"), "type='" + kind + "'",
                                     "<limit lower='" + lower + "' upper='" + upper + "' effort='87' velocity='1'/>"));
    return folder.load("urdf: r.urdf");
  };
  const double free_spring = load("prismatic", "-inf", "inf")->stiffness()[0];
  EXPECT_GT(free_spring, 100) << "a spring that pushes";
  for (const char* limit : {"1000", "1e4", "1e6", "1e16", "1.7976931348623157e308", "1e999"}) {
    const auto model = load("prismatic", std::string("-") + limit, limit);
    EXPECT_EQ(model->lower()[0], -kNone) << limit;
    EXPECT_EQ(model->upper()[0], kNone) << limit;
    EXPECT_DOUBLE_EQ(model->stiffness()[0], free_spring) << limit;
    EXPECT_EQ(has_note(*model, "r: limits of 1000 rad or m and more mean none, of joints: j"), std::string(limit) != "1e999") << limit;
  }
  const auto one_sided = load("prismatic", "0.5", "1e6");
  EXPECT_EQ(one_sided->lower()[0], 0.5);
  EXPECT_EQ(one_sided->upper()[0], kNone);
  const auto turning = load("revolute", "-1e6", "1e6"), continuous = load("continuous", "0", "0");
  EXPECT_EQ(turning->upper()[0], kNone);
  EXPECT_DOUBLE_EQ(turning->stiffness()[0], continuous->stiffness()[0]);
  const auto large = load("prismatic", "-999", "999");
  EXPECT_EQ(large->upper()[0], 999);
  EXPECT_FALSE(has_note(*large, "mean none"));
}

TEST(LinksThatAreOnlySeen, AreKnown) {
  const RobotFolder folder;
  const std::string seen = "<visual><geometry><sphere radius='0.1'/></geometry></visual>";
  const auto only_seen = [&](const std::string& tip) {
    folder.write("r.urdf", one_joint(tip));
    return folder.load("urdf: r.urdf")->scene().robots[0].contents->robot.links[1].only_seen;
  };
  EXPECT_TRUE(only_seen(seen));
  EXPECT_FALSE(only_seen(""));
  EXPECT_FALSE(only_seen(seen + collision("<sphere radius='0.1'/>")));
  EXPECT_FALSE(only_seen(seen + collision("<sphere radius='0'/>"))) << "that one is noted already";
}

TEST(WhatIsNotRead, IsSaidOnce) {
  const RobotFolder folder;
  const auto notes = [&](const std::string& tip, const std::string& limit) {
    folder.write("r.urdf", one_joint(tip, "type='revolute'", limit));
    return folder.load("urdf: r.urdf")->scene().robots[0].contents->robot.notes;
  };
  const std::string ball = collision("<sphere radius='0.1'/>"), limit = "<limit lower='-1' upper='1' effort='1' velocity='1'/>";
  EXPECT_TRUE(notes(ball + "<visual><geometry><teapot/></geometry></visual>", limit).empty());
  EXPECT_EQ(
      notes("<colision/>" + ball +
                "<collision><origin xyz='0 0 1' quat='0 0 0 1'/><geometry><sphere radius='0.1'/><box size='1 1 1'/>"
                "</geometry><geometry/></collision>",
            "<limit lower='-1' uper='1' effort='1' velocity='1'/>" + limit),
      std::vector<std::string>{"not read: <colision> of links tip; quat of <origin> of <collision> of links tip; a second <shape> of "
                               "<geometry> of <collision> of links tip; a second <geometry> of <collision> of links tip; uper of <limit> "
                               "of joints j; a second <limit> of joints j"});
}

TEST(LimitsThatMaySayMore, AreNamed) {
  const RobotFolder folder;
  const auto note = [&](const std::string& limits, const std::string& safety, const std::string& part) {
    folder.write("r.urdf", one_joint(collision("<sphere radius='0.1'/>"), "type='revolute'",
                                     "<limit " + limits + " effort='1' velocity='1'/><safety_controller k_velocity='1' " + safety + "/>"));
    return has_note(*folder.load("urdf: r.urdf"), part);
  };
  EXPECT_TRUE(note("lower='-170' upper='170'", "", "may be degrees where the format has radians, of joints: j"));
  EXPECT_FALSE(note("lower='-12.6' upper='12.6'", "", "degrees"));
  EXPECT_TRUE(note("lower='-1' upper='1'", "soft_lower_limit='-0.9' soft_upper_limit='1'", "soft limits of <safety_controller>"));
  EXPECT_FALSE(note("lower='-1' upper='1'", "soft_lower_limit='-1' soft_upper_limit='1'", "soft limits"));
}

TEST(Quaternions, AreReadAsVersion12OfTheFormatHasThem) {
  const RobotFolder folder;
  const auto text = [](const std::string& origin) {
    return one_joint("<collision><origin " + origin + "/><geometry><sphere radius='0.1'/></geometry></collision>");
  };
  folder.write("r.urdf", text("xyz='0 0 1' quat_xyzw='0 0.6 0 0.8'"));
  const auto R = folder.load("urdf: r.urdf")->geometries()[0].X_BG.R;
  EXPECT_TRUE(R.isApprox(Eigen::Quaterniond(0.8, 0, 0.6, 0).toRotationMatrix()));
  folder.write("r.urdf", text("quat_xyzw='0 0 0 2'"));
  EXPECT_EQ(folder.message("urdf: r.urdf"), "r.urdf:1: origin quat_xyzw: got length 2, expected length 1");
  folder.write("r.urdf", text("quat_xyzw='0 0 0 1' rpy='0 0 0'"));
  EXPECT_EQ(folder.message("urdf: r.urdf"), "r.urdf:1: origin: got rpy beside quat_xyzw, expected one of the two");
}

TEST(LinksWithoutAParent, AreNamed) {
  const RobotFolder folder;
  folder.write("r.urdf", "<robot name='r'><link name='a'/><link name='b'/></robot>");
  EXPECT_EQ(folder.message("urdf: r.urdf"), "r.urdf:1: robot: got 2 links without a parent: a, b, expected one");
  folder.write("r.urdf",
               "<robot name='r'><link name='a'/><joint name='j' type='fixed'><parent link='a'/><child link='a'/></joint></robot>");
  EXPECT_EQ(folder.message("urdf: r.urdf"), "r.urdf:1: robot: got links that form a circle, expected a tree");
}

}  // namespace
}  // namespace stiction::world::test
