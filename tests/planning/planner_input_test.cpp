// Starts and goals that cannot be planned from or to, and options out of range: refused, or reported with the reason.
#include "planning/systems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/world/object_space.hpp"
#include "support/message_of.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

PlanningProblem slide_problem(bool gravity, double reach) {
  world::Scene scene = load_model("planar_pushing")->scene();
  scene.objects[0].joint = world::ObjectJoint::Slider;
  scene.objects[0].axis = Eigen::Vector3d::UnitZ();
  scene.objects[0].limits = {{-reach, reach}};
  scene.gravity = Eigen::Vector3d(0, 0, gravity ? -10 : 0);
  PlanningProblem problem;
  problem.model = world::Model::make(scene);
  problem.q_start = Eigen::Vector3d(0.5, 0, -0.2);
  problem.goal.X_WG.p = Eigen::Vector3d(0, 0, 0.8);
  return problem;
}

PlannerOptions slide_options() {
  PlannerOptions options;
  options.threads = 1;
  options.sample_boxes.push_back({0, Eigen::VectorXd::Constant(1, -1), Eigen::VectorXd::Constant(1, 1)});
  return options;
}

TEST(Planner, GoalOutsideTheRange_IsRefused) {
  PlanResult result;
  const auto problem = slide_problem(false, 0.7);
  EXPECT_EQ(stiction::test::message_of([&] { (void)plan(problem, slide_options(), {}, result); }),
            "goal: got box/position = 0.8, expected a value in its range [-0.7, 0.7]");
  auto region = problem;
  region.goal.region = GoalRegion{Eigen::VectorXd::Constant(1, 0.8), Eigen::VectorXd::Constant(1, 0.9)};
  EXPECT_EQ(stiction::test::message_of([&] { (void)plan(region, slide_options(), {}, result); }),
            "goal: got box/position in [0.8, 0.9], expected a value in its range [-0.7, 0.7]");
}

TEST(Planner, GoalInsideAFixedBody_IsRefused) {
  PlanningProblem problem = slide_problem(false, 2);
  world::Scene scene = problem.model->scene();
  scene.fixed.push_back({.name = "wall", .X_WB = {}, .geometries = {{.name = "ball", .shape = world::Sphere{0.1}, .X_BG = {}}}});
  scene.fixed[0].X_WB.p.z() = 1.2;
  problem.model = world::Model::make(scene);
  PlanResult result;
  EXPECT_EQ(stiction::test::message_of([&] { (void)plan(problem, slide_options(), {}, result); }),
            "goal: got a pose in which 'box/box' is 0.2 m inside 'wall/ball', expected one outside everything that cannot move");
}

TEST(Planner, ObjectThatFalls_IsReported) {
  PlanningProblem problem = slide_problem(true, 1e3);
  problem.q_start[1] = 5;  // the pusher is not below
  PlannerOptions options = slide_options();
  options.max_iterations = 100;
  PlanResult result;
  EXPECT_EQ(planning::plan(problem, options, {}, result), core::Status::NumericalFailure);
  EXPECT_NE(result.reason.find("do not come to rest"), std::string::npos) << result.reason;
  EXPECT_GT(result.start_moved, 1);
}

TEST(Planner, RobotThatCannotReach_EndsWithTheReason) {
  PlanningProblem problem = slide_problem(false, 2);
  world::Scene scene = problem.model->scene();
  scene.filters.push_back({"hand", "box", std::nullopt});
  problem.model = world::Model::make(scene);
  PlanResult result;
  EXPECT_EQ(plan(problem, slide_options(), {}, result), core::Status::MaxIterations);
  EXPECT_NE(result.reason.find("cannot touch an object"), std::string::npos) << result.reason;

  problem = hand_problem();  // the ball is farther away than the arms are long
  problem.q_start[1] = 3;
  problem.goal.X_WG.p.z() = 3;
  EXPECT_EQ(plan(problem, hand_options(), {}, result), core::Status::MaxIterations);
  EXPECT_NE(result.reason.find("cannot touch an object"), std::string::npos) << result.reason;
  EXPECT_LT(result.iterations, 20000);
}

TEST(Planner, StartAtTheGoal_IsSolvedWithoutMoving) {
  PlanningProblem problem = hand_problem();
  problem.goal.X_WG = world::object_pose(*problem.model, problem.q_start, 0);
  PlanResult result;
  EXPECT_EQ(plan(problem, hand_options(), {}, result), Status::Solved);
  EXPECT_EQ(result.iterations, 0);
}

TEST(Planner, StartInPenetration_IsProjectedAndReported) {
  PlanningProblem problem = hand_problem();
  problem.q_start[1] = 0.28;  // the ball deep in the arms
  PlannerOptions options = hand_options();
  options.max_iterations = 1;
  PlanResult result;
  (void)plan(problem, options, {}, result);
  EXPECT_GT(result.start_penetration, 0.01);
  EXPECT_TRUE(result.start_projected);
  ASSERT_FALSE(result.plan.segments.empty());
  EXPECT_EQ(result.plan.segments.front().kind, SegmentKind::Settle);
}

TEST(Planner, BadOptions_NameTheField) {
  const PlanningProblem problem = hand_problem();
  const auto message = [&](auto&& change) -> std::string {
    PlannerOptions options = hand_options();
    change(options);
    PlanResult result;
    try {
      (void)plan(problem, options, {}, result);
    } catch (const core::InvalidInput& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_EQ(message([](auto& o) { o.goal_bias = 1.5; }), "planner.goal_bias: got 1.5, expected a probability in [0, 1]");
  EXPECT_EQ(message([](auto& o) { o.sample_boxes[0].lower.resize(2); }), "planner.sample_box.lower: got 2 numbers, expected 3");
  EXPECT_EQ(message([](auto& o) { o.tolerance_fraction = 0; }), "planner.tolerance_fraction: got 0, expected a number in (0, 1]");
  EXPECT_EQ(message([](auto& o) { o.max_iterations = 0; }), "planner.max_iterations: got 0, expected at least 1");
  EXPECT_EQ(message([](auto& o) { o.thesis.emplace().gamma = 0; }), "planner.thesis.gamma: got 0, expected a finite number > 0");
  EXPECT_EQ(message([](auto& o) { o.friction_law = dynamics::FrictionLaw::Coulomb; }),
            "planner.friction_law: got coulomb, expected anitescu for a planar model");
  EXPECT_EQ(message([](auto& o) { o.friction = 0; }), "planner.friction: got 0, expected a number in (0, 1]");
}

}  // namespace
}  // namespace stiction::planning::test
