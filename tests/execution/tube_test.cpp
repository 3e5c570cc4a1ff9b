#include "stiction/execution/open_loop/tube.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include "planning/push_plan.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/open_loop/run_timing.hpp"
#include "stiction/execution/open_loop/transfer.hpp"
#include "stiction/world/scales.hpp"
#include "support/message_of.hpp"

namespace stiction::execution::test {
namespace {

using core::Status;
using Eigen::Vector2d;
using Eigen::VectorXd;
using planning::test::load_model;
using planning::test::push_plan;
using planning::test::push_up;
using stiction::test::message_of;

constexpr ErrorSets kNone{.position = 0, .angle = 0, .friction = 0, .mass = 0, .contact = 0};
constexpr double kTaught = 1e-9;  ///< of steps that are solved from other warm starts

TubeResult tube_of(const std::shared_ptr<const world::Model>& model, const planning::Plan& plan, const TubeOptions& options) {
  TubeResult out;
  EXPECT_EQ(calc_tube(model, plan, options, {}, out), Status::Solved);
  return out;
}

/// Pose of the box of planar_pushing, in its plane.
Vector2d place(const world::Pose& X) { return X.p.tail<2>(); }

// ---- worlds

TEST(DrawWorld, Worlds_AreWithinTheirSetsAndReachTheirEnds) {
  for (const char* task : {"planar_pushing", "allegro_cube", "allegro_door"}) {
    const auto model = load_model(task);
    const VectorXd q = model->neutral();
    const ErrorSets sets;
    double position = 0, angle = 0, friction = 0, mass = 0;
    for (std::uint64_t i = 0; i < 500; ++i) {
      const WorldError world = draw_world(*model, q, sets, 3, i);
      VectorXd delta = VectorXd::Zero(model->n_v()), moved(model->n_q());
      delta.head(model->n_vu()) = world.start;
      world::retract(*model, q, delta, moved);
      for (int k = 0; k < static_cast<int>(model->objects().size()); ++k) {
        const world::Pose X_0 = world::object_pose(*model, q, k), X_1 = world::object_pose(*model, moved, k);
        position = std::max(position, (X_1.p - X_0.p).norm());
        angle = std::max(angle, Eigen::AngleAxisd(X_0.R.transpose() * X_1.R).angle());
      }
      friction = std::max(friction, std::abs(world.friction - 1));
      mass = std::max(mass, std::abs(world.mass - 1));
    }
    EXPECT_LE(position, sets.position * (1 + kTaught)) << task;
    EXPECT_GT(position, 0.95 * sets.position) << task;
    EXPECT_LE(angle, sets.angle * (1 + kTaught)) << task;
    EXPECT_LE(friction, 0.3 + kTaught) << task;
    EXPECT_GT(friction, 0.29) << task;
    EXPECT_LE(mass, 0.3 + kTaught) << task;
    EXPECT_GT(mass, 0.29) << task;
  }
}

/// Uniform in a disc of radius R: the mean of r² is R²/2. 4000 draws have it to 3 σ = 3 R²/√(12 · 4000).
TEST(DrawWorld, PlacesOfAPlanarObject_AreUniformInTheirDisc) {
  const auto model = load_model("planar_pushing");
  const ErrorSets sets{.position = 1, .angle = 1};
  double sum = 0;
  constexpr int n = 4000;
  for (std::uint64_t i = 0; i < n; ++i) sum += draw_world(*model, model->neutral(), sets, 0, i).start.head<2>().squaredNorm();
  EXPECT_NEAR(sum / n, 0.5, 3 / std::sqrt(12.0 * n));
}

TEST(DrawWorld, FreeObjectUnderGravity_StaysOnWhatItRestsOn) {
  const auto model = load_model("allegro_cube");
  const VectorXd e = draw_world(*model, model->neutral(), {}, 0, 1).start;
  EXPECT_EQ(e[2], 0);
  EXPECT_NEAR(e.segment<2>(3).norm(), 0, 1e-15) << "it turns about the vertical";
  EXPECT_NE(e[0], 0);
  EXPECT_NE(e[5], 0);
}

TEST(DrawWorld, SameSeedAndIndex_AreTheSameWorld) {
  const auto model = load_model("planar_pushing");
  const auto draw = [&](std::uint64_t seed, std::uint64_t index) { return draw_world(*model, model->neutral(), {}, seed, index); };
  EXPECT_EQ(draw(1, 2).start, draw(1, 2).start);
  EXPECT_EQ(draw(1, 2).friction, draw(1, 2).friction);
  EXPECT_NE(draw(1, 2).start, draw(1, 3).start);
  EXPECT_NE(draw(1, 2).start, draw(2, 2).start);
}

// ---- the tube

/// Worlds without errors are the model: the tube is the plan, as wide as a contact is wrong, and off by what is left of the lag of the damped box.
TEST(Tube, WithoutErrors_IsThePlan) {
  const auto model = load_model("planar_pushing");
  const planning::Plan plan = push_up(model);
  TubeOptions options{.errors = kNone, .scenarios = 3};
  TubeResult r = tube_of(model, plan, options);
  ASSERT_EQ(r.rests.size(), 1u) << "pushes that follow each other are one";
  EXPECT_LT(r.rests[0].offset.position, 1e-3);
  EXPECT_LT(r.rests[0].position, 1e-7);
  EXPECT_LT(r.rests[0].angle, 1e-7);
  EXPECT_TRUE(r.inside);
  options.errors.contact = 0.004;
  options.factors = {.position = 3, .angle = 5};
  r = tube_of(model, plan, options);
  EXPECT_NEAR(r.rests[0].position, 3 * 0.004 * model->scales().object(0).length, 1e-7);
  EXPECT_NEAR(r.rests[0].angle, 5 * 2 * 0.004, 1e-7);
}

/// A hand that goes elsewhere leaves the object where each world has it: the centre is the mean of their errors, the radius that of the farthest from it.
TEST(Tube, UntouchedObject_StaysWhereTheWorldsHaveIt) {
  const auto model = load_model("planar_pushing");
  const VectorXd q = (VectorXd(5) << 0, 0.6, 0.2, 0, -0.5).finished();
  const planning::Plan plan = push_plan(model, q, {Vector2d(0.1, -0.5)});
  const TubeOptions options{.errors = {.contact = 0}, .factors = {2, 2}, .scenarios = 7, .seed = 5};
  const TubeResult r = tube_of(model, plan, options);
  std::vector<VectorXd> errors{VectorXd::Zero(3)};
  for (std::uint64_t i = 1; i <= 7; ++i) errors.push_back(draw_world(*model, start_of(*model, plan), options.errors, 5, i).start);
  VectorXd mean = VectorXd::Zero(3);
  for (const VectorXd& e : errors) mean += e / 8;
  double position = 0, angle = 0;
  for (const VectorXd& e : errors) {
    position = std::max(position, (e - mean).head<2>().norm());
    angle = std::max(angle, std::abs(e[2] - mean[2]));
  }
  ASSERT_GT(position, 1e-3);
  EXPECT_NEAR(r.rests[0].position, 2 * position, 1e-8);
  EXPECT_NEAR(r.rests[0].angle, 2 * angle, 1e-8);
  EXPECT_NEAR(r.rests[0].offset.position, mean.head<2>().norm(), 1e-8);
  EXPECT_NEAR(r.rests[0].offset.angle, std::abs(mean[2]), 1e-8);
  EXPECT_NEAR(r.goal.position, mean.head<2>().norm() + 2 * position, 1e-8) << "the goal is where the plan ends";
}

/// Along a push the hand says where the box is, whatever the start was: a map that contracts, which no reach of the start's error tells.
TEST(Tube, Push_TakesAwayTheErrorAlongIt) {
  const auto model = load_model("planar_pushing");
  const planning::Plan plan = push_up(model);
  const TubeResult r = tube_of(model, plan, {.errors = {.angle = 0, .friction = 0, .mass = 0}, .scenarios = 20});
  double along_before = 0, along = 0;
  for (std::uint64_t i = 1; i <= 20; ++i)
    along_before =
        std::max(along_before, std::abs(draw_world(*model, start_of(*model, plan), {.angle = 0, .friction = 0, .mass = 0}, 0, i).start[1]));
  for (const world::Pose& X : r.rests[0].scenarios) along = std::max(along, std::abs(place(X)[1] - place(r.rests[0].scenarios[0])[1]));
  ASSERT_GT(along_before, 1.5e-3);
  EXPECT_LT(along, 0.1 * along_before);
}

/// What an independent simulation with inertia does in other worlds than those of the tube.
TEST(Tube, RunsInMujoco_StayInside) {
  const auto model = load_model("planar_pushing");
  const planning::Plan plan = push_up(model);
  const TubeRest rest = tube_of(model, plan, {}).rests.back();
  TransferOptions options;
  options.alone = false;
  double farthest = 0;
  for (std::uint64_t i = 0; i < 4; ++i) {
    const WorldError world = draw_world(*model, start_of(*model, plan), {}, 77, i);
    options.start_error = world.start;
    simulation::PlantOptions plant;
    plant.velocity_reference = plant.effort_limits = true;
    plant.rest_time = kRestTime;
    plant.mass_scale = world.mass;
    plant.contact.friction_scale = world.friction;
    TransferResult run;
    ASSERT_EQ(transfer(simulation::Plant::make(model, plant), plan, options, {}, run), Status::Solved);
    const world::Pose X = world::object_pose(*model, run.q.col(run.q.cols() - 1), 0);
    EXPECT_LE((X.p - rest.centre.p).norm(), rest.position);
    EXPECT_LE(Eigen::AngleAxisd(rest.centre.R.transpose() * X.R).angle(), rest.angle);
    farthest = std::max(farthest, (X.p - world::object_pose(*model, plan.segments.back().knots.back().q, 0).p).norm());
  }
  EXPECT_GT(farthest, 1e-3) << "every run was as planned: the test would say nothing";
}

TEST(Tube, Bits_DoNotDependOnThreads) {
  const auto model = load_model("planar_pushing");
  const planning::Plan plan = push_up(model);
  const TubeResult one = tube_of(model, plan, {.threads = 1}), three = tube_of(model, plan, {.threads = 3});
  EXPECT_EQ(one.rests[0].position, three.rests[0].position);
  EXPECT_EQ(one.rests[0].angle, three.rests[0].angle);
  EXPECT_EQ(one.steps, three.steps);
}

/// A goal region is reached by more than one pose: the bound is that of the nearest one, and no scenario is farther away than it.
TEST(Tube, GoalRegion_IsBoundedFromItsNearestPose) {
  const auto model = load_model("planar_pushing");
  planning::Plan plan = push_up(model);
  plan.goal.tol_angle = 0.05;
  const double infinite = std::numeric_limits<double>::infinity();
  const VectorXd q = plan.segments.back().knots.back().q;
  const TubeOptions options{.errors = {.contact = 0}, .factors = {1, 1}};
  const TubeResult pose = tube_of(model, plan, options);
  plan.goal.region = planning::GoalRegion{Eigen::Vector3d(-infinite, -infinite, q[2]), Eigen::Vector3d(infinite, infinite, q[2])};
  const TubeResult region = tube_of(model, plan, options);
  EXPECT_EQ(region.rests.back().angle, pose.rests.back().angle);
  EXPECT_GE(region.goal.angle, region.rests.back().angle);
  EXPECT_LE(region.goal.angle, 3 * region.rests.back().angle);
}

/// A hand that moves no joint leaves the cube on its palm: the bound is within the tolerances, and no promise.
TEST(Tube, SceneThatIsNotPlanar_IsNeverInside) {
  const auto model = load_model("planar_pushing"), spatial = load_model("allegro_cube");
  EXPECT_TRUE(tube_of(model, push_up(model), {}).calibrated);
  planning::Plan still;
  still.q_start = spatial->neutral();
  still.q_start.head<3>() = Eigen::Vector3d(0.5, 0.5, 0.5);
  still.u_start = still.q_start.tail(spatial->n_a());
  still.goal.X_WG = world::object_pose(*spatial, still.q_start, 0);
  still.goal.tol_position = 10;
  still.goal.tol_angle = 3;
  still.segments = {{planning::SegmentKind::Contact, {{still.u_start, still.q_start, {}}}}};
  const TubeResult r = tube_of(spatial, still, {.scenarios = 2});
  EXPECT_TRUE(r.goal.within(still.goal));
  EXPECT_FALSE(r.calibrated);
  EXPECT_FALSE(r.inside);
}

TEST(Tube, BudgetThatIsUsedUp_IsNoVerdict) {
  const auto model = load_model("planar_pushing");
  core::RunControl control;
  control.deadline = core::RunControl::Clock::now();
  TubeResult out;
  EXPECT_EQ(calc_tube(model, push_up(model), {}, control, out), Status::MaxIterations);
  EXPECT_FALSE(out.inside);
  EXPECT_TRUE(out.rests.empty());
}

TEST(Tube, BadInput_IsNamed) {
  const auto model = load_model("planar_pushing");
  const planning::Plan plan = push_up(model);
  const auto message = [&](
                           const TubeOptions& options, const std::function<void(planning::Plan&)>& change = [](planning::Plan&) {}) {
    planning::Plan changed = plan;
    change(changed);
    TubeResult out;
    return message_of([&] { (void)calc_tube(model, changed, options, {}, out); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message({.errors = {.position = -1}}), "errors.position: got -1, expected a finite number ≥ 0");
  EXPECT_EQ(message({.errors = {.angle = nan}}), "errors.angle: got nan, expected a finite number ≥ 0");
  EXPECT_EQ(message({.errors = {.friction = 1}}), "errors.friction: got 1, expected a number in [0, 1)");
  EXPECT_EQ(message({.errors = {.mass = nan}}), "errors.mass: got nan, expected a number in [0, 1)");
  EXPECT_EQ(message({.errors = {.contact = -0.1}}), "errors.contact: got -0.1, expected a finite number ≥ 0");
  EXPECT_EQ(message({.factors = {.position = 0}}), "factors.position: got 0, expected a finite number > 0");
  EXPECT_EQ(message({.scenarios = 0}), "scenarios: got 0, expected a number ≥ 1");
  EXPECT_EQ(message({}, [](planning::Plan& p) { p.goal.object = 1; }), "plan.goal.object: got 1, expected the index of an object");
  EXPECT_NE(message({}, [](planning::Plan& p) { p.segments.clear(); }).find("plan.segments"), std::string::npos);
  EXPECT_NE(message({}, [](planning::Plan& p) { p.segments[0].knots[0].u.resize(3); }).find("knots[0].u"), std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
