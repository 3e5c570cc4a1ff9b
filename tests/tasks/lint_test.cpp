#include "stiction/tasks/lint.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/core/invalid_input.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/tasks/reach.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;

/// A ball on three crossed slides beside a block on the ground, which it is to push 0.12 m and turn.
constexpr const char* kRobot = R"(<robot name="slides">
  <link name="rail"/><link name="bridge"/><link name="carriage"/>
  <link name="ball"><collision><geometry><sphere radius="0.015"/></geometry></collision></link>
  <joint name="a" type="prismatic"><parent link="rail"/><child link="bridge"/><axis xyz="1 0 0"/><limit lower="-0.4" upper="0.4" effort="30" velocity="1"/></joint>
  <joint name="b" type="prismatic"><parent link="bridge"/><child link="carriage"/><axis xyz="0 1 0"/><limit lower="-0.4" upper="0.4" effort="30" velocity="1"/></joint>
  <joint name="c" type="prismatic"><parent link="carriage"/><child link="ball"/><axis xyz="0 0 1"/><limit lower="0.016" upper="0.4" effort="30" velocity="1"/></joint>
</robot>)";
constexpr const char* kTask = R"(
scene:
  robots: [{name: slides, urdf: slides.urdf, stiffness: 800, friction: 0.5}]
  objects: [{name: block, joint: free, mass: 0.4, shapes: [{box: {size: [0.08, 0.08, 0.08]}, friction: 0.5}]}]
  fixed: [{name: ground, friction: 0.5, shapes: [{half_space: {}}]}]
start: {objects: {block: {position: [0, 0, 0.04]}}, joints: [-0.1, 0, 0.04]}
goal: {objects: {block: {position: [0.12, 0.04, 0.04], rpy: [0, 0, 0.4]}}}
tolerance: {position: 0.01, angle: 0.1}
planner: {sample_box: {block: {lower: [-0.2, -0.2, 0.04, 0, 0, -0.5], upper: [0.2, 0.2, 0.04, 0, 0, 0.5]}}}
)";

class Lint : public testing::Test {
 protected:
  void SetUp() override { std::ofstream(dir_ / "slides.urdf") << kRobot; }

  /// The task with one thing written differently.
  Task task(const std::string& from, const std::string& to) const {
    std::string text = kTask;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return parse_task(text, dir_);
  }

  const stiction::test::TemporaryFolder temporary_;
  const std::filesystem::path& dir_ = temporary_.path();
};

std::string all(const std::vector<Finding>& findings) {
  std::string out;
  for (const auto& f : findings) out += f.kind + ": " + f.message + "\n";
  return out;
}

struct SceneMistake {
  const char *from, *to, *kind, *part;
};

TEST_F(Lint, WorksOnWithoutTheFilesOfTheTask) {
  const stiction::test::TemporaryFolder folder;
  std::ofstream(folder.path() / "slides.urdf") << kRobot;
  std::ofstream(folder.path() / "task.yaml") << kTask;
  const Task loaded = load_task((folder.path() / "task.yaml").string());
  for (const char* name : {"slides.urdf", "task.yaml"}) fs::remove(folder.path() / name);
  EXPECT_TRUE(lint(loaded).empty());
}

TEST_F(Lint, TaskWithoutMistakes_HasNothingToSay) { EXPECT_EQ(all(lint(task("0.4", "0.4"))), ""); }

TEST_F(Lint, Mistakes_AreNamedWithWhatAndHowMuch) {
  const std::vector<SceneMistake> mistakes = {
      {"position: [0, 0, 0.04]", "position: [0, 0, 0.02]", "overlap", "'block/box_0' and 'ground/half_space_0' overlap by 20 mm"},
      {"position: [0, 0, 0.04]", "position: [0, 0, 0.04], rpy: [0, 0.3, 0]", "overlap", "'ground/half_space_0' overlap by"},
      {"joints: [-0.1, 0, 0.04]", "joints: [0, 0, 0.04]", "overlap", "'block/box_0' and 'slides/ball/sphere_0' overlap by 55 mm"},
      {"position: [0.12, 0.04, 0.04]", "position: [0.12, 0.04, 0.01]", "overlap",
       "goal: 'block/box_0' and 'ground/half_space_0' overlap by 30 mm"},
      {"position: [0, 0, 0.04]", "position: [0, 0, 0.34]", "unsupported", "'block' touches nothing"},
      {"fixed: [{name: ground, friction: 0.5, shapes: [{half_space: {}}]}]", "fixed: []", "unsupported", "'block' touches nothing"},
      {"mass: 0.4", "mass: 0.4, max_force: 3", "force",
       "start: 'block/box_0' and 'ground/half_space_0' press on each other with 3.92 N, of which they bear 3 N (max_force)"},
      {"position: [0.12, 0.04, 0.04]", "position: [0.12, 0.04, 0.24]", "hold", "nothing can hold it there"},
      {"position: [0.12, 0.04, 0.04]", "position: [1.2, 0.04, 0.04]", "reach", "goal: no robot reaches 'block'"},
      {"position: [0, 0, 0.04]", "position: [2, 0, 0.04]", "reach", "start: no robot reaches 'block'"},
      {"mass: 0.4", "mass: 400", "weight", "'block' weighs 3.92e+03 N (400 kg)"},
      {"stiffness: 800", "stiffness: 0.8", "weight", "even the stiffest joint gives way by"},
      {"scene:", "scene:\n  gravity: [0, 0, 9.81]", "gravity", "points upwards"},
      {"size: [0.08, 0.08, 0.08]", "size: [80, 80, 80]", "size", "is it in millimetres?"},
      {"rpy: [0, 0, 0.4]", "rpy: [0, 0, 30]", "units", "goal.objects.block.rpy: 30 rad"},
      {"angle: 0.1", "angle: 5", "units", "tolerance.angle: 5 rad"},
      {"position: 0.01,", "position: 10,", "units", "tolerance.position: 10 m"},
      {"rpy: [0, 0, 0.4]", "quaternion_wxyz: [0, 0, 0.198669, 0.980067]", "quaternion", "As x y z w it would be 0.4 rad"},
      {"upper: [0.2, 0.2, 0.04, 0, 0, 0.5]", "upper: [0.05, 0.2, 0.04, 0, 0, 0.5]", "sample_box", "leaves out the goal, by 70 mm"},
      {"upper: [0.2, 0.2, 0.04, 0, 0, 0.5]", "upper: [0.2, 0.2, 0.04, 0, 0, 0.1]", "sample_box", "0.3 rad"},
      {"position: [0.12, 0.04, 0.04], rpy: [0, 0, 0.4]", "position: [0, 0, 0.04]", "goal", "is there at the start already"},
  };
  for (const auto& mistake : mistakes) {
    SCOPED_TRACE(mistake.to);
    const auto findings = lint(task(mistake.from, mistake.to));
    EXPECT_TRUE(std::any_of(findings.begin(), findings.end(),
                            [&](const Finding& f) { return f.kind == mistake.kind && f.message.find(mistake.part) != std::string::npos; }))
        << "no '" << mistake.part << "' in:\n"
        << all(findings);
  }
}

TEST_F(Lint, Places_AreWhereTheMistakesAre) {
  const auto find = [](const std::vector<Finding>& findings, const std::string& kind) {
    const auto found = std::find_if(findings.begin(), findings.end(), [&](const Finding& f) { return f.kind == kind; });
    EXPECT_NE(found, findings.end()) << kind;
    return found == findings.end() ? Finding{} : *found;
  };
  const Finding overlap = find(lint(task("position: [0, 0, 0.04]", "position: [0, 0, 0.02]")), "overlap");
  EXPECT_EQ(overlap.where, "start");
  EXPECT_EQ(overlap.names, (std::vector<std::string>{"block/box_0", "ground/half_space_0"}));
  ASSERT_TRUE(overlap.p_W && overlap.amount);
  EXPECT_NEAR(*overlap.amount, 0.02, 1e-9);
  EXPECT_NEAR(overlap.p_W->z(), -0.01, 1e-9);  // halfway between the ground and the lowest face

  const Finding air = find(lint(task("position: [0, 0, 0.04]", "position: [0, 0, 0.34]")), "unsupported");
  ASSERT_TRUE(air.p_W && air.amount);
  EXPECT_GT(*air.amount, 0.01);

  const Finding reach = find(lint(task("position: [0.12, 0.04, 0.04]", "position: [1.2, 0.04, 0.04]")), "reach");
  EXPECT_EQ(reach.where, "goal");
  EXPECT_EQ(reach.names, std::vector<std::string>{"block"});
  EXPECT_FALSE(reach.p_W);
  ASSERT_TRUE(reach.amount);
  EXPECT_GT(*reach.amount, 0.1);

  const Finding gravity = find(lint(task("scene:", "scene:\n  gravity: [0, 0, 9.81]")), "gravity");
  EXPECT_TRUE(gravity.where.empty() && gravity.names.empty());
}

/// A drawer along a rail that it lies in by a tenth of a millimetre, across its slide: no joint undoes that.
TEST_F(Lint, OverlapThatNoJointUndoes_IsNamedWhereTheStepFails) {
  const Task wedged = parse_task(R"(
scene:
  gravity: [0, 0, 0]
  robots: [{name: slides, urdf: slides.urdf, stiffness: 100}]
  objects: [{name: drawer, joint: slider, axis: [0, 1, 0], mass: 1, friction: 0, shapes: [{box: {size: [0.4, 0.5, 0.2]}}]}]
  fixed: [{name: rail, friction: 0, pose: {position: [0, 0, -0.14]}, shapes: [{box: {size: [0.4, 2, 0.1]}}]}]
start: {objects: {drawer: {coordinates: [0]}}, joints: [0, -0.39, 0.3]}
goal: {objects: {drawer: {coordinates: [0.3]}}}
tolerance: {position: 0.02, angle: 0.1}
planner: {sample_box: {drawer: {lower: [-0.5], upper: [0.5]}}}
)",
                                 dir_);
  const std::string found = all(lint(wedged));
  EXPECT_NE(found.find("overlap: start: 'drawer/box_0' and 'rail/box_0' overlap by 10 mm"), std::string::npos) << found;
  dynamics::StepWorkspace work(wedged.model);
  dynamics::StepResult result;
  dynamics::StepOptions options;
  options.h = wedged.options.step_options(*wedged.model).h;
  const auto& q = wedged.problem.q_start;
  const bool solved = dynamics::step(*wedged.model, {q, q.tail(3)}, options, work, result) == core::Status::Solved;
  EXPECT_EQ(found.find("stuck: start: no step can be made from here") == std::string::npos, solved) << found;
}

TEST_F(Lint, HingeAnglesAndLimitsInDegrees_AreUnits) {
  const auto planar = [&](const std::string& joint, const std::string& angle) {
    std::string text = kTask;
    const auto put = [&text](std::string_view from, const std::string& to) { text.replace(text.find(from), from.size(), to); };
    put("joint: free", joint);
    put("{position: [0, 0, 0.04]}", "{coordinates: [0]}");
    put("{position: [0.12, 0.04, 0.04], rpy: [0, 0, 0.4]}", "{coordinates: [" + angle + "]}");
    text.erase(text.find("planner:"));
    text += "planner: {sample_box: {block: {lower: [-100], upper: [100]}}}\n";
    return all(lint(parse_task(text, dir_)));
  };
  EXPECT_NE(planar("joint: hinge, axis: [0, 0, 1]", "90").find("units: goal: block/angle = 90 rad"), std::string::npos);
  EXPECT_EQ(planar("joint: hinge, axis: [0, 0, 1], limits: [-0.2, 7]", "6.2832").find("units"), std::string::npos)
      << "a hinge may turn once";
  EXPECT_NE(planar("joint: hinge, axis: [0, 0, 1], limits: [-90, 90]", "1").find("units: limits of block/angle: -90 rad"),
            std::string::npos);
}

TEST_F(Lint, RobotThatTouchesNothing_IsRefused) {
  std::string urdf = kRobot;
  urdf.replace(urdf.find("<collision>"), std::string("<collision>").size(), "<visual>");
  urdf.replace(urdf.find("</collision>"), std::string("</collision>").size(), "</visual>");
  std::ofstream(dir_ / "slides.urdf") << urdf;
  try {
    (void)task("0.4", "0.4");
    ADD_FAILURE() << "accepted";
  } catch (const core::InvalidInput& e) {
    EXPECT_NE(std::string(e.what()).find("no robot has a shape that may touch an object"), std::string::npos) << e.what();
  }
}

TEST(LintOfBuiltInTasks, HasNothingToSay) {
  for (const auto& name : list_tasks(default_data_dirs())) {
    SCOPED_TRACE(name);
    EXPECT_EQ(all(lint(load_task(name))), "");
  }
}

/// Of random postures no shape comes nearer than the bound.
TEST_F(Lint, Reach_IsALowerBound) {
  const Task slides = task("0.4", "0.4");
  const Reach reach(*slides.model);
  EXPECT_NEAR(reach.distance({1.0, 0, 0.2}, 0), 1.0 - 0.4 - 0.015, 1e-12) << "slides along the axes: the box is exact";
  EXPECT_NEAR(reach.distance({0, 0, 1.0}, 0.1), 1.0 - 0.4 - 0.015 - 0.1, 1e-12);
  for (const char* name : {"planar_hand", "allegro_ball", "iiwa_bimanual", "ur5_mesh_push"}) {
    SCOPED_TRACE(name);
    const Task own = load_task(name);
    const world::Model& model = *own.model;
    const Reach bound(model);
    world::KinematicsWorkspace work(model);
    world::Kinematics kinematics;
    std::srand(1);
    const Eigen::Vector3d far(0.3, 2.0, 1.5);
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 200; ++k) {
      Eigen::VectorXd q = own.problem.q_start;
      const Eigen::ArrayXd share = 0.5 * (Eigen::ArrayXd::Random(model.n_a()) + 1);
      q.tail(model.n_a()) = (model.lower().array() + share * (model.upper() - model.lower()).array()).matrix();
      world::calc_kinematics(model, q, work, kinematics);
      for (const auto& g : model.geometries()) {
        const auto& body = model.bodies()[static_cast<std::size_t>(g.body)];
        if (body.kind != world::BodyKind::Robot || body.dofs.empty()) continue;
        nearest = std::min(nearest, (kinematics.X_WB[static_cast<std::size_t>(g.body)] * g.p_BCenter - far).norm() - g.bounding_radius);
      }
    }
    EXPECT_LE(bound.distance(far, 0), nearest + 1e-9);
    EXPECT_GT(bound.distance({50, 0, 0}, 0), 0) << "a bound that says nothing";
  }
}

/// A trolley 0.4 mm from a wall: paths keep half of that, and lint says so; with a filter there is nothing to say.
TEST(LintOfLinks, LinksThatNearlyTouch_AreNamedWithTheirGap) {
  const std::string text = R"(
scene:
  gravity: [0, 0, 0]
  robots:
    - name: r
      stiffness: 100
      urdf: |
        <robot name="r"><link name="base"/><link name="cart"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
        <joint name="x" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="10"/></joint></robot>
  objects: [{name: box, joint: slider, axis: [1, 0, 0], mass: 1, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}]
  fixed: [{name: wall, shapes: [{box: {size: [3, 0.1, 0.1]}, pose: {position: [0, 0.1004, 0.2]}}, {box: {size: [3, 0.1, 0.1]}, pose: {position: [0, 0.1004, 0]}}]}]
FILTERS
start: {objects: {box: {coordinates: [0.2]}}, joints: [0]}
goal: {objects: {box: {coordinates: [0.4]}}}
tolerance: {position: 0.01, angle: 0.1}
)";
  const auto findings = [&](const std::string& filters) {
    std::string changed = text;
    changed.replace(changed.find("FILTERS"), 7, filters);
    std::vector<Finding> out;
    for (const Finding& finding : lint(parse_task(changed, "."))) {
      if (finding.kind == "near") out.push_back(finding);
    }
    return out;
  };
  const auto found = findings("");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(
      found[0].message,
      "start: 'r/cart/box_0' and 'wall/box_1' are 0.4 mm apart where the robot rests: its paths keep 0.2 mm between them there, elsewhere "
      "2 mm; exclude the pair in `filters` if these never meet");
  EXPECT_EQ(found[0].names, (std::vector<std::string>{"r/cart/box_0", "wall/box_1"}));
  EXPECT_NEAR(*found[0].amount, 4e-4, 1e-9);
  EXPECT_TRUE(findings("  filters: [{exclude: [r, wall]}]").empty());
}

}  // namespace
}  // namespace stiction::tasks
