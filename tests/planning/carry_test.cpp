// A plan for things that are elsewhere: joints that follow points exactly, and pushes of a UR5 on a table of another height.
#include "stiction/planning/carry.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "planning/systems.hpp"
#include "stiction/planning/refine/shift_plan.hpp"
#include "support/message_of.hpp"

namespace stiction::planning::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using stiction::test::message_of;

/// A UR5 and a block on a table at this height.
std::shared_ptr<const world::Model> make_model(double height) {
  const std::filesystem::path packages[] = {stiction::test::package_dir()};
  world::Scene scene = world::load_scene(stiction::test::source_dir() / "tasks/ur5_mesh_push.yaml", packages);
  scene.fixed.front().X_WB.p.z() = height;
  return world::Model::make(scene);
}

VectorXd start_at(const world::Model& model, double height) {
  VectorXd q = model.neutral();
  q.head<3>() = Vector3d(0.5, 0.1, 0.0483 + height);
  q.tail<6>() << 0, -1.2, 1.6, -1.97, -1.57, 0;
  return q;
}

Goal goal_at(double height) {
  Goal goal;
  goal.X_WG.p = Vector3d(0.45, -0.15, 0.0483 + height);
  goal.X_WG.R = Eigen::AngleAxisd(1, Vector3d::UnitZ()).toRotationMatrix();
  goal.tol_position = 0.02, goal.tol_angle = 0.1;
  return goal;
}

world::Pose last_link(const world::Model& model, const VectorXd& q) {
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  const auto bodies = model.bodies();
  const auto link = std::ranges::find(bodies, std::string("arm/wrist_3_link"), &world::Body::name) - bodies.begin();
  return kinematics.X_WB[static_cast<std::size_t>(link)];
}

/// The block in front of the last link of the arm, far from the others, and pressed by it: a plan of one state, and one after it in which the arm is far away.
Plan touching_plan(const world::Model& model) {
  Plan plan;
  plan.q_start = start_at(model, 0);
  const world::Pose last = last_link(model, plan.q_start);
  plan.q_start.head<3>() = last.p + 0.13 * last.R.col(1);  // along the axis of the flange
  plan.u_start = plan.q_start.tail(6);
  VectorXd far = plan.q_start;
  far[7] += 1;
  const VectorXd pressed = plan.u_start + VectorXd::Constant(6, 0.01);
  plan.segments.push_back({SegmentKind::Contact, {{.u = pressed, .q = plan.q_start, .contacts = {}}}, false});
  plan.segments.push_back({SegmentKind::Regrasp, {{.u = far.tail(6), .q = far, .contacts = {}}}, false});
  return plan;
}

TEST(ShiftPlan, LinksStayWhereTheyAreOnTheObject_AndSpringsAsStrained) {
  const auto model = make_model(0);
  const Plan plan = touching_plan(*model);
  const world::Pose before = last_link(*model, plan.q_start);
  const Vector3d shift(0.003, -0.004, 0.012);
  const Plan moved = refinement::shift_plan(*model, plan, {shift});
  const world::Pose after = last_link(*model, moved.q_start);
  EXPECT_NEAR((moved.q_start.head<3>() - plan.q_start.head<3>() - shift).norm(), 0, 1e-15);
  EXPECT_NEAR((after.p - before.p - shift).norm(), 0, 1e-6) << "six joints follow a pose";
  EXPECT_NEAR((after.R - before.R).norm(), 0, 1e-6);
  const auto strain = [](const dynamics::Knot& knot) { return VectorXd(knot.u - knot.q.tail(6)); };
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR((strain(moved.segments[i].knots[0]) - strain(plan.segments[i].knots[0])).norm(), 0, 1e-15);
  EXPECT_NEAR((moved.segments[1].knots[0].u - plan.segments[1].knots[0].u - (moved.u_start - plan.u_start)).norm(), 0, 1e-12)
      << "away from objects joints move as they did last";
}

TEST(ShiftPlan, NoShift_GivesThePlan) {
  const auto model = make_model(0);
  const Plan plan = touching_plan(*model);
  const Plan same = refinement::shift_plan(*model, plan, {Vector3d::Zero()});
  EXPECT_NEAR((same.q_start - plan.q_start).norm(), 0, 1e-12);
  EXPECT_NEAR((same.segments[0].knots[0].u - plan.segments[0].knots[0].u).norm(), 0, 1e-12);
}

TEST(ShiftPlan, ObjectThatDoesNotMoveFreely_IsNamed) {
  const auto model = load_model("planar_pushing");
  Plan plan;
  plan.q_start = model->neutral(), plan.u_start = plan.q_start.tail(model->n_a());
  const std::string message = message_of([&] { (void)refinement::shift_plan(*model, plan, {Vector3d(0, 0, 0.01)}); });
  EXPECT_NE(message.find("shifts: got a shift of '" + model->objects()[0].name + "'"), std::string::npos) << message;
}

/// A plan that was found on a table of height 0.
class Carry : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const auto model = make_model(0);
    options().threads = 1;
    PlanResult result;
    ASSERT_EQ(planning::plan({model, start_at(*model, 0), goal_at(0), {}}, options(), {}, result), Status::Solved);
    given() = result.plan;
  }
  static PlannerOptions& options() {
    static PlannerOptions out;
    return out;
  }
  static Plan& given() {
    static Plan out;
    return out;
  }

  /// To a table at this height, with the arm aside of where the plan begins.
  Status carry_to(double height, double goal_height) {
    model_ = make_model(height);
    CarriedTo to{start_at(*model_, height), {}, {Vector3d(0, 0, height)}, goal_at(goal_height)};
    to.q.tail<6>()[0] -= 0.2;
    to.u = to.q.tail<6>();
    start_ = to.q;
    return carry(model_, given(), to, options(), keep_plan(given()), {}, out_);
  }

  std::shared_ptr<const world::Model> model_;
  VectorXd start_;
  CarryResult out_;
};

TEST_F(Carry, TableIsElsewhere_PlanReachesTheGoalThere) {
  for (const double height : {-0.01, 0.0, 0.015}) {
    SCOPED_TRACE(height);
    ASSERT_EQ(carry_to(height, height), Status::Solved) << out_.reason;
    const Plan& plan = out_.plan;
    EXPECT_EQ(plan.q_start, start_);
    EXPECT_EQ(plan.segments.back().knots.back().q.size(), model_->n_q());
    EXPECT_TRUE(plan.error.within(goal_at(height)));
    EXPECT_TRUE(goal_error(*model_, plan.segments.back().knots.back().q, goal_at(height)).within(goal_at(height)));
    EXPECT_GE(out_.reconnected, 1) << "the arm began elsewhere than the plan";
    EXPECT_EQ(out_.rest_planned_anew, 0);
    const auto pushes = std::ranges::count(given().segments, SegmentKind::Contact, &Segment::kind);
    EXPECT_LE(std::ranges::count(plan.segments, SegmentKind::Contact, &Segment::kind), pushes);
  }
}

TEST_F(Carry, GoalWhereThePlanDoesNotLead_SaysSo) {
  EXPECT_EQ(carry_to(0, 0.3), Status::NumericalFailure);
  EXPECT_FALSE(out_.reason.empty());
  EXPECT_TRUE(out_.plan.segments.empty());
}

TEST_F(Carry, BadInput_NamesTheField) {
  const auto model = make_model(0);
  CarriedTo to{start_at(*model, 0), VectorXd::Zero(6), {}, goal_at(0)};
  const auto message = [&] { return message_of([&] { (void)carry(model, given(), to, options(), keep_plan(given()), {}, out_); }); };
  EXPECT_NE(message().find("shifts"), std::string::npos) << message();
  to.shifts = {Vector3d::Zero()}, to.u = VectorXd::Zero(5);
  EXPECT_NE(message().find("to.u"), std::string::npos) << message();
}

}  // namespace
}  // namespace stiction::planning::test
