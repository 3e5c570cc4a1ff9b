// Values that exporters write where they have none: shapes of no size, limits that mean no limit.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace stiction::world::test
