// A lever that rusts is planned for: it turns when it is pushed and stays while the hand goes elsewhere.
#include "planning/systems.hpp"
#include "stiction/planning/refine.hpp"
#include "stiction/planning/sample_boxes.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;

/// The ball on two slides beneath a lever of 0.6 m that its weight pulls down, and that its friction holds.
PlanningProblem lever_problem(double friction) {
  world::Scene scene = load_model("planar_pushing")->scene();
  scene.gravity = {0, 0, -9.81};
  scene.filters.clear();
  scene.fixed.clear();
  world::ObjectSpec lever;
  lever.name = "lever";
  lever.joint = world::ObjectJoint::Hinge;
  lever.axis = Eigen::Vector3d::UnitX();
  lever.mass = 0.5;
  lever.p_BCom = {0, 0.3, 0};
  lever.inertia = Eigen::Vector3d(0.015, 1e-3, 0.015).asDiagonal();
  lever.joint_friction = friction;
  lever.geometries.push_back(
      {.name = "bar", .shape = world::Box{{0.05, 0.3, 0.05}}, .X_BG = {Eigen::Matrix3d::Identity(), {0, 0.3, 0}}, .friction = 0.5});
  scene.objects = {lever};
  PlanningProblem problem;
  problem.model = world::Model::make(scene);
  problem.q_start = Eigen::Vector3d(0, 0.4, -0.3);
  const Eigen::Vector3d q_goal(0.5, 0.4, -0.3);
  problem.goal.X_WG = world::object_pose(*problem.model, q_goal, 0);
  problem.goal.tol_position = 0.02;
  problem.goal.tol_angle = 0.05;
  return problem;
}

TEST(JointFriction, LeverThatRusts_IsTurnedAndStays) {
  const PlanningProblem problem = lever_problem(2.5);  // its weight pulls with 1.47 N·m
  PlannerOptions options;
  options.sample_boxes = default_sample_boxes(problem);
  options.threads = 2;
  options.max_iterations = 20000;
  PlanResult planned;
  ASSERT_EQ(plan(problem, options, {}, planned), Status::Solved) << planned.reason;
  RefineResult refined;
  ASSERT_EQ(refine(problem.model, planned.plan, options, {}, {}, refined), Status::Solved);
  for (const Plan& made : {planned.plan, refined.plan}) {
    dynamics::StepWorkspace work(problem.model);
    dynamics::StepResult result;
    Eigen::VectorXd q = made.segments.back().knots.back().q;
    const double angle = q[0];
    EXPECT_TRUE(goal_error(*problem.model, q, problem.goal).within(problem.goal));
    q.tail(2) << 0.4, -1;  // the hand is gone
    for (int k = 0; k < 100; ++k) {
      ASSERT_EQ(dynamics::step(*problem.model, {q, q.tail(2)}, made.step, work, result), Status::Solved);
      q = result.q_next;
    }
    EXPECT_NEAR(q[0], angle, 1e-4);
  }
}

}  // namespace
}  // namespace stiction::planning::test
