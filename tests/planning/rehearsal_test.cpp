#include "stiction/planning/rehearsal.hpp"

#include "planning/push_plan.hpp"
#include "world/test_scenes.hpp"

namespace stiction::planning::test {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kStep = 0.1;  // of a rehearsal [s]

/// A body of 1 kg far above everything, beside a slider that is commanded to move by 0.1 m.
struct Falling {
  Falling() {
    world::Scene scene = load_model("planar_pushing")->scene();
    scene.gravity = Eigen::Vector3d(0, 0, -10);
    scene.objects[0].joint = world::ObjectJoint::Free;
    scene.objects[0].mass = 1;
    scene.objects[0].inertia = 0.1 * Eigen::Matrix3d::Identity();
    model = world::Model::make(scene);
    plan.q_start = (VectorXd(9) << 0, 5, 5, 0, 0, 0, 1, 0, 0).finished();
    plan.u_start = Vector2d::Zero();
    VectorXd q = plan.q_start;
    q[7] = 0.1;
    plan.segments.push_back({SegmentKind::Contact, {{.u = Vector2d(0.1, 0), .q = q, .contacts = {}}}});
    plan.goal.X_WG = world::object_pose(*model, q, 0);
    plan.goal.tol_angle = 1;
  }
  std::shared_ptr<const world::Model> model;
  Plan plan;
};

/// Implicit steps: v_n = n g h, and it has fallen by g h² n (n + 1)/2.
TEST(Rehearsal, NothingHoldsIt_FallsAsGravityHasIt) {
  Falling falling;
  falling.plan.goal.tol_position = 1;  // given up 5 m below its plan
  const RehearsalResult r = Rehearsal(falling.model, kRestTime).run(falling.plan, 0.5);
  EXPECT_FALSE(r.holds);
  EXPECT_EQ(r.lost, 0);
  const double n = static_cast<double>(r.steps), fallen = 10 * kStep * kStep * n * (n + 1) / 2;
  EXPECT_NEAR(5 - r.q[2], fallen, 1e-9);
  EXPECT_GT(fallen, 5);
  EXPECT_LE(10 * kStep * kStep * n * (n - 1) / 2, 5);
}

/// A damper that moves along with the command: M = 0, so that K (u − x) = D (ẋ − u̇) keeps x at u.
TEST(Rehearsal, FreeJoint_StaysAtItsCommand) {
  Falling falling;
  falling.plan.goal.tol_position = 1e4;
  const RehearsalResult r = Rehearsal(falling.model, kRestTime).run(falling.plan, 1);
  EXPECT_TRUE(r.holds);
  EXPECT_NEAR(r.q[7], 0.1, 1e-9);
  EXPECT_NEAR(r.q[8], 0, 1e-9);
}

TEST(Rehearsal, PushThatItsPlanForetells_Holds) {
  const auto model = load_model("planar_pushing");
  Plan plan = push_up(model);
  const RehearsalResult r = Rehearsal(model, kRestTime).run(plan, 0.2);
  EXPECT_TRUE(r.holds);
  EXPECT_EQ(r.lost, -1);
  EXPECT_EQ(r.failed_steps, 0);
  EXPECT_NEAR(r.q[1], plan.segments.back().knots.back().q[1], 0.2 * plan.goal.tol_position);
  const double weighed = r.q[1];
  EXPECT_FALSE(Rehearsal(model, 1e-4).run(plan, 0.2).holds) << "on what stops it at once the box trails, and is not there after the pause";
  Rehearsal again(model, kRestTime);
  again.run(push_plan(model, plan.q_start, {Vector2d(0.05, 0.15)}), 0.2);
  EXPECT_EQ(again.run(plan, 0.2).q[1], weighed) << "nothing is left of the run before";
}

TEST(Rehearsal, PlanThatForetellsWhatDoesNotHappen_IsLostInThatSegment) {
  const auto model = load_model("planar_pushing");
  for (const std::size_t wrong : {0u, 1u}) {
    Plan plan = push_up(model);
    for (std::size_t s = wrong; s < 2; ++s) {
      for (auto& knot : plan.segments[s].knots) knot.q[0] += 0.03;
    }
    const RehearsalResult r = Rehearsal(model, kRestTime).run(plan, 1);  // 20 mm; it trails by 12.5
    EXPECT_FALSE(r.holds);
    EXPECT_EQ(r.lost, static_cast<int>(wrong));
    EXPECT_TRUE(Rehearsal(model, kRestTime).run(plan, 3).holds) << "the share is of the tolerances";
  }
}

/// A piece by itself from where the piece before was left comes to the same as both in one.
TEST(Rehearsal, FromWhereItRested_GoesOnAsIfItHadNotStopped) {
  const auto model = load_model("planar_pushing");
  Plan plan = push_up(model);
  Plan first = plan, second = plan;
  first.segments.pop_back();
  second.segments.erase(second.segments.begin());
  second.q_start = first.segments[0].knots.back().q;
  second.u_start = first.segments[0].knots.back().u;
  Segment regrasp{SegmentKind::Regrasp, {first.segments[0].knots.back()}};
  regrasp.knots[0].contacts.clear();
  plan.segments.insert(plan.segments.begin() + 1, regrasp);  // the robot pauses there
  Rehearsal rehearsal(model, kRestTime);
  const VectorXd rested = rehearsal.run(first, 1).q;
  const VectorXd in_two = rehearsal.run(second, 1, &rested).q, in_one = rehearsal.run(plan, 1).q;
  EXPECT_LT((in_two - in_one).cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_GT((in_one - rested).cwiseAbs().maxCoeff(), 0.05);
}

}  // namespace
}  // namespace stiction::planning::test
