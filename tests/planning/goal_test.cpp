#include <numbers>

#include <Eigen/SVD>
#include "planning/systems.hpp"
#include "stiction/core/random.hpp"
#include "stiction/world/object_space.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning::test {
namespace {

Eigen::Quaterniond rotation(double roll, double pitch, double yaw) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) * AngleAxisd(roll, Vector3d::UnitX());
}

TEST(GoalError, IsDistanceAndGeodesicAngle) {
  const auto model = load_model("allegro_ball");
  Goal goal;
  goal.X_WG.R = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  goal.X_WG.p = {0.3, 0, 0.4};
  const GoalError error = goal_error(*model, model->neutral(), goal);
  EXPECT_NEAR(error.position, 0.5, 1e-12);
  EXPECT_NEAR(error.angle, 0.4, 1e-9);
}

TEST(PathTolerances, WhereRotationIsFree_AnAngleCountsForTheWayOfTheSurface) {
  const auto model = load_model("allegro_cube");
  const double length = model->scales().object(0).length;
  Goal goal;
  goal.tol_position = 0.2 * length;
  goal.tol_angle = 0.1;
  EXPECT_EQ(path_tolerances(*model, goal).angle, 0.1);
  const Eigen::VectorXd any = Eigen::VectorXd::Constant(6, kAny);
  goal.region = GoalRegion{-any, any};
  goal.region->lower.head<3>() = goal.region->upper.head<3>() = Eigen::Vector3d(0.1, 0, 0);
  EXPECT_DOUBLE_EQ(path_tolerances(*model, goal).angle, 0.2);
  EXPECT_EQ(path_tolerances(*model, goal).position, goal.tol_position);
  EXPECT_DOUBLE_EQ(inverse_tolerances(*model, goal)[4], 5);
  goal.tol_position = 10 * length;
  EXPECT_DOUBLE_EQ(path_tolerances(*model, goal).angle, 0.3);
  goal.tol_position = 1e-3 * length;
  EXPECT_EQ(path_tolerances(*model, goal).angle, 0.1);
  goal.region->upper[3] = 0.5;  // one of its rotations is bounded
  goal.tol_position = 0.2 * length;
  EXPECT_EQ(path_tolerances(*model, goal).angle, 0.1);
}

TEST(PathTolerances, ABallTurnsAsItLikes) {
  const auto model = load_model("allegro_ball");
  Goal goal;
  const Eigen::VectorXd any = Eigen::VectorXd::Constant(6, kAny);
  goal.region = GoalRegion{-any, any};
  goal.region->lower[2] = 0.05;
  EXPECT_DOUBLE_EQ(path_tolerances(*model, goal).angle, std::numbers::pi);
}

TEST(GoalRegion, PlanarObject_EachCoordinateOnItsOwn) {
  const auto model = load_model("planar_hand");
  const GoalRegion region{Eigen::Vector3d(-0.1, -kAny, 3.0), Eigen::Vector3d(0.1, kAny, 3.2)};
  Eigen::VectorXd q = Eigen::Vector3d(0.3, 7, -3.13);  // the angle is 3.153 on the other side of the seam, inside
  project(*model, region, q);
  EXPECT_EQ(q, Eigen::VectorXd(Eigen::Vector3d(0.1, 7, -3.13)));
  q[2] = -2.9;  // 3.383: the upper end is nearer
  project(*model, region, q);
  EXPECT_NEAR(q[2], 3.2, 1e-15);
  q[2] = 0.1;  // the lower end is 2.9 away, the upper 3.18
  project(*model, region, q);
  EXPECT_NEAR(q[2], 3.0, 1e-15);
}

TEST(GoalRegion, YawOnly_ErrorIsTheYawThatIsMissing) {
  const auto model = load_model("allegro_ball");
  Goal goal;
  goal.region = GoalRegion{Eigen::VectorXd::Constant(6, -kAny), Eigen::VectorXd::Constant(6, kAny)};
  goal.region->lower[5] = goal.region->upper[5] = 1.0;
  Eigen::VectorXd q = allegro_start();
  q.segment<4>(3) = rotation(0.3, 0.2, 0.4).coeffs();
  const GoalError error = goal_error(*model, q, goal);
  EXPECT_EQ(error.position, 0);
  EXPECT_NEAR(error.angle, 0.6, 1e-12);  // Rz(1.0)Ry(0.2)Rx(0.3) = Rz(0.6) R
  q.segment<4>(3) = rotation(-1.2, 0.5, 1.0).coeffs();
  EXPECT_NEAR(goal_error(*model, q, goal).angle, 0, 1e-7);
}

TEST(GoalRegion, BothTriplesOfARotationCount) {
  const auto model = load_model("allegro_ball");
  GoalRegion region{Eigen::VectorXd::Constant(6, -kAny), Eigen::VectorXd::Constant(6, kAny)};
  const double pi = std::numbers::pi;
  region.lower.tail<3>() = region.upper.tail<3>() = Eigen::Vector3d(pi + 0.1, pi - 0.2, pi + 0.3);  // the rotation (0.1, 0.2, 0.3)
  Eigen::VectorXd q = allegro_start().head(7);
  q.tail<4>() = rotation(0.1, 0.2, 0.35).coeffs();
  project(*model, region, q);
  const Eigen::Vector4d c = q.tail<4>();
  EXPECT_LT(Eigen::Quaterniond(c[3], c[0], c[1], c[2]).angularDistance(rotation(0.1, 0.2, 0.3)), 1e-12);
}

TEST(GoalRegion, ProjectedTwice_StaysAndHasNoError) {
  core::Random random(5, 0);
  for (const char* task : {"planar_hand", "allegro_ball", "planar_hand_fixed_y"}) {
    const auto model = load_model(task);
    for (int sample = 0; sample < 200; ++sample) {
      Goal goal;
      goal.object = static_cast<int>(model->objects().size()) - 1;
      goal.region.emplace();
      goal.region->lower.resize(model->n_vu());
      goal.region->upper.resize(model->n_vu());
      for (int i = 0; i < model->n_vu(); ++i) {
        const double x = random.normal();
        goal.region->lower[i] = random.chance(0.3) ? -kAny : x;
        goal.region->upper[i] = random.chance(0.3) ? kAny : x + random.uniform();
      }
      Eigen::VectorXd q(model->n_q());
      world::retract(*model, model->neutral(), Eigen::VectorXd::NullaryExpr(model->n_v(), [&] { return random.normal(); }), q);
      project(*model, *goal.region, q.head(model->n_qu()));
      const Eigen::VectorXd once = q;
      const GoalError error = goal_error(*model, q, goal);
      EXPECT_LT(error.position, 1e-12);
      EXPECT_LT(error.angle, 1e-7);
      project(*model, *goal.region, q.head(model->n_qu()));
      EXPECT_TRUE(world::objects_agree(*model, world::ObjectSpace(*model), once, q, 1e-9, 1e-7)) << task;
    }
  }
}

TEST(PathCost, IsTimeAtJointSpeedsAndAPricePerRegrasp) {
  const auto model = load_model("planar_hand");
  Plan plan;
  plan.u_start = Eigen::Vector4d::Zero();
  const auto knot = [](double a, double b) {
    dynamics::Knot out;
    out.u = Eigen::Vector4d(a, b, 0, 0);
    return out;
  };
  plan.segments.push_back({SegmentKind::Contact, {knot(0.1, -0.3), knot(0.1, -0.2)}});
  plan.segments.push_back({SegmentKind::Regrasp, {knot(0.3, -0.2)}});
  EXPECT_NEAR(path_cost(*model, plan, {.joint_speed = 0.5, .regrasp = 3}), (0.3 + 0.1 + 0.2) / 0.5 + 3, 1e-12);
  const auto pusher = load_model("planar_pushing");
  plan.u_start = Eigen::Vector2d::Zero();
  plan.segments.resize(1);
  plan.segments[0].knots.resize(1);
  plan.segments[0].knots[0].u = Eigen::Vector2d(0.02, -0.05);
  EXPECT_NEAR(path_cost(*pusher, plan, {.travel_speed = 0.1}), 0.5, 1e-12);
}

std::shared_ptr<const world::Model> two_boxes() {
  return world::Model::make(world::load_scene(stiction::test::source_dir() / "tests/tasks/data/two_boxes.yaml"));
}

TEST(GoalError, OfSeveralObjects_IsThatOfTheFarthest) {
  const auto model = two_boxes();
  Goal goal;
  goal.region = GoalRegion{(Eigen::VectorXd(6) << 1, 0, 0, 2, -kAny, 0).finished(), (Eigen::VectorXd(6) << 1, 0, 0, 2, kAny, 0).finished()};
  EXPECT_EQ(goal_objects(*model, goal), (std::vector<int>{0, 1}));
  Eigen::VectorXd q = model->neutral();
  q.head(6) << 1.03, 0, 0.5, 2.2, 7, 0.1;
  const GoalError error = goal_error(*model, q, goal);
  EXPECT_NEAR(error.position, 0.2, 1e-12);
  EXPECT_NEAR(error.angle, 0.5, 1e-9);
  goal.region->lower.tail(3).setConstant(-kAny);
  goal.region->upper.tail(3).setConstant(kAny);
  EXPECT_EQ(goal_objects(*model, goal), std::vector<int>{0});
  EXPECT_NEAR(goal_error(*model, q, goal).position, 0.03, 1e-12);
}

TEST(GoalObjects, AreThoseThatNoOtherHangsOn) {
  const auto door = load_model("allegro_door");
  Goal goal;
  goal.object = 1;  // the handle
  goal.region = GoalRegion{Eigen::Vector2d(0.1, 0.2), Eigen::Vector2d(0.1, 0.2)};
  EXPECT_EQ(goal_objects(*door, goal), std::vector<int>{1});
  EXPECT_EQ(chain_of(*door, 1), (std::vector<int>{0, 1}));
}

/// A ball that is carried, turned about the vertical and tipped.
TEST(Bystanders, MotionIsThatOfTheOriginAndOfTheVertical) {
  const auto model = load_model("allegro_ball");
  Eigen::VectorXd q = model->neutral();
  const Eigen::Quaterniond stood = rotation(0.7, -0.2, 1.1), moved = rotation(0, 0.3, 0) * rotation(0, 0, 2) * stood;
  q.segment<4>(3) = stood.coeffs();
  Goal goal;
  goal.bystanders = Bystanders{{0}, q.head(7), 0.25, kAny};
  q.head<3>() += Eigen::Vector3d(0.03, 0, 0.04);
  q.segment<4>(3) = moved.coeffs();
  const BystanderMotion motion = calc_motion(*model, *goal.bystanders, 0, q);
  EXPECT_NEAR(motion.move, 0.05, 1e-12);
  EXPECT_NEAR(motion.tip, 0.3, 1e-12);
  EXPECT_NEAR(bystander_share(*model, goal, q), 0.2, 1e-12);
  goal.bystanders->may_tip = 0.2;
  EXPECT_NEAR(bystander_share(*model, goal, q), 1.5, 1e-12);
  goal.bystanders.reset();
  EXPECT_EQ(bystander_share(*model, goal, q), 0);
}

}  // namespace
}  // namespace stiction::planning::test
