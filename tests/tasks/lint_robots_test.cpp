// What lint says about the robots of a task: links that are only seen, and shapes in millimetres.
#include "stiction/tasks/lint_robots.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "support/temporary_folder.hpp"

namespace stiction::tasks {
namespace {

constexpr const char* kTaskOfRobots = R"(
scene:
  robots: [{name: slides, urdf: slides.urdf, stiffness: 800}]
  objects: [{name: block, joint: free, mass: 0.4, shapes: [{box: {size: [0.08, 0.08, 0.08]}}]}]
  fixed: [{name: ground, shapes: [{half_space: {}}]}]
start: {objects: {block: {position: [0, 0, 0.04]}}, joints: [-0.1, 0.1]}
goal: {objects: {block: {position: [0.12, 0.04, 0.04]}}}
tolerance: {position: 0.01, angle: 0.1}
)";

class LintRobots : public testing::Test {
 protected:
  /// What is said about a robot of two slides whose links have the given elements, and of which a fixed joint holds "tool" to "ball".
  std::vector<Finding> lint(const std::string& carriage, const std::string& ball, const std::string& tool = "",
                            const std::string& limit = "0.4") const {
    const std::string range = "<limit lower='-" + limit + "' upper='" + limit + "' effort='30' velocity='1'/>";
    std::ofstream(folder_.path() / "slides.urdf")
        << "<robot name='slides'><link name='rail'>" << kSeen << "</link><link name='carriage'>" << carriage << "</link><link name='ball'>"
        << ball << "</link><link name='tool'>" << tool
        << "</link><joint name='a' type='prismatic'><parent link='rail'/><child link='carriage'/><axis xyz='1 0 0'/>" << range
        << "</joint><joint name='b' type='prismatic'><parent link='carriage'/><child link='ball'/><axis xyz='0 1 0'/>" << range
        << "</joint><joint name='c' type='fixed'><parent link='ball'/><child link='tool'/></joint></robot>";
    std::vector<Finding> out;
    lint_robots(parse_task(kTaskOfRobots, folder_.path()), out);
    return out;
  }

  static std::string collision(const std::string& shape) { return "<collision><geometry>" + shape + "</geometry></collision>"; }
  static inline const std::string kSeen = "<visual><geometry><sphere radius='0.02'/></geometry></visual>";
  static inline const std::string kBall = collision("<sphere radius='0.015'/>");

  const stiction::test::TemporaryFolder folder_{};
};

TEST_F(LintRobots, RobotWithoutMistakes_HasNothingToSay) { EXPECT_TRUE(lint("", kSeen + kBall).empty()); }

TEST_F(LintRobots, LinksThatAreOnlySeen_AreNamed) {
  const auto findings = lint(kSeen, kBall);
  ASSERT_EQ(findings.size(), 1u) << "not the rail, which never moves";
  EXPECT_EQ(findings[0].kind, "visual");
  EXPECT_EQ(
      findings[0].message,
      "'slides': links that are seen and that nothing can touch, because they have no collision geometry: carriage; give them some, if "
      "they are to touch anything");
  EXPECT_EQ(findings[0].names, std::vector<std::string>{"slides/carriage"});
}

TEST_F(LintRobots, LinkThatIsWeldedToOneWithCollisions_IsNoMistake) { EXPECT_TRUE(lint("", kBall, kSeen).empty()); }

TEST_F(LintRobots, MeshInMillimetres_IsNamedWithItsSize) {
  std::ofstream(folder_.path() / "tip.obj") << "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  const auto findings = lint("", collision("<mesh filename='tip.obj'/>"));
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].kind, "size");
  EXPECT_EQ(findings[0].names, std::vector<std::string>{"slides/ball/mesh_0"});
  EXPECT_GT(findings[0].amount.value(), 100);
  EXPECT_NE(findings[0].message.find("'slides/ball/mesh_0' (tip.obj) is "), std::string::npos) << findings[0].message;
  EXPECT_NE(findings[0].message.find("the joints of the robot reach 0.8 m; lengths are in metres: is the file in millimetres? Then write "
                                     "scale=\"0.001 0.001 0.001\" at the mesh"),
            std::string::npos)
      << findings[0].message;
  EXPECT_TRUE(lint("", collision("<mesh filename='tip.obj' scale='0.001 0.001 0.001'/>")).empty());
}

TEST_F(LintRobots, MeshInMillimetres_IsNamedWithoutAnyLengthOfTheJoints) {
  std::ofstream(folder_.path() / "tip.obj") << "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
  const auto findings = lint("", collision("<mesh filename='tip.obj'/>"), "", "1e6");
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NE(findings[0].message.find("the largest object is "), std::string::npos) << findings[0].message;
}

}  // namespace
}  // namespace stiction::tasks
