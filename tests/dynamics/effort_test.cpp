// Motors that saturate (S.15): springs whose pull is bounded by the effort of the joint.
#include <algorithm>
#include <limits>

#include "cone_allocations.hpp"
#include "dynamics/optimality.hpp"
#include "dynamics/systems.hpp"
#include "stiction/dynamics/rollout.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::VectorXd;
using world::Model;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The pusher (K = 100 N/m, along y and z) with efforts.
world::RobotSpec weak_pusher(double effort_y, double effort_z) {
  world::RobotSpec robot = pusher(0);
  robot.effort = {{robot.stiffness[0].first, effort_y}, {robot.stiffness[1].first, effort_z}};
  return robot;
}

world::Scene wall_scene(double effort_y, double effort_z) {
  world::Scene scene = empty_scene();
  scene.robots.push_back(weak_pusher(effort_y, effort_z));
  scene.fixed.push_back(half_space(Eigen::Vector3d::UnitZ(), {0, 0, -0.1}, 0));
  return scene;
}

TEST(Effort, CommandFarBehindWall_PushesWithEffortExactly) {
  Stepper system(wall_scene(kInfinity, 3));
  const Eigen::Vector2d q(0, 0.01);
  for (const double u : {-0.02, -0.029, -0.031, -0.05, -5.0}) {
    const StepResult r = system(q, Eigen::Vector2d(0, u), {.effort_limits = true});
    const double force = std::min(3.0, -100 * u);
    EXPECT_NEAR(r.q_next[1], 0, 1e-7) << u;
    EXPECT_NEAR(r.contacts.at(0).lambda[0] / 0.1, force, 1e-4) << u;
    EXPECT_NEAR(r.torque[1], -force, 1e-4) << u;
    EXPECT_EQ(r.saturated[1], u < -0.03) << u;
    EXPECT_EQ(r.saturated[0], 0);
  }
}

TEST(Effort, OptionOff_SpringHasNoLimit) {
  Stepper system(wall_scene(1, 3));
  const StepResult r = system(Eigen::Vector2d(0, 0.01), Eigen::Vector2d(0, -0.5), {});
  EXPECT_NEAR(r.torque[1], -50, 1e-3);
  EXPECT_EQ(r.saturated, std::vector<char>(2, 0));
}

TEST(Effort, NothingInTheWay_JointGoesWhereCommandedWhateverItsEffort) {
  Stepper system(wall_scene(0.1, 0.1));
  const Eigen::Vector2d u(2, 3);  // K · 2 m is 2000 times the effort
  const StepResult r = system(Eigen::Vector2d(0, 0.5), u, {.effort_limits = true});
  EXPECT_NEAR((r.q_next - u).norm(), 0, 1e-6);
  EXPECT_NEAR(r.torque.norm(), 0, 1e-4);
  EXPECT_EQ(r.saturated, std::vector<char>(2, 0));
}

/// Down onto the wall and farther, and up again: the knots ask for no more than the effort, and the joint leaves the wall as the command does.
TEST(Effort, RolloutIntoWallAndBack_CommandsStayWithinTheEffort) {
  Stepper system(wall_scene(kInfinity, 3));
  const SubstepLimits limits{.joint_travel = 0.01, .slide = 1};
  const Eigen::Vector2d start(0, 0.02), down(0, -0.5), up(0, 0.02);
  RolloutResult in, out;
  ASSERT_EQ(rollout(*system.model, start, start, down, {.effort_limits = true}, limits, system.work, in), Status::Solved);
  EXPECT_EQ(count_substeps(*system.model, start, down, limits), 52);
  ASSERT_EQ(in.knots.size(), 52u);
  for (const Knot& knot : in.knots) EXPECT_LE(100 * std::abs(knot.u[1] - knot.q[1]), 3 * (1 + 1e-3));
  EXPECT_NEAR(in.knots.back().u[1], -0.03, 1e-4);  // 3 N of 100 N/m
  ASSERT_EQ(rollout(*system.model, in.knots.back().q, in.knots.back().u, up, {.effort_limits = true}, limits, system.work, out),
            Status::Solved);
  EXPECT_EQ(out.knots.size(), 5u);  // 0.05 m
  EXPECT_NEAR(out.knots.back().q[1], 0.02, 1e-6);
}

TEST(Effort, RolloutThatNothingHoldsBack_IsTheSameWithAndWithoutLimits) {
  Stepper system(wall_scene(1, 1));
  const SubstepLimits limits{.joint_travel = 0.01, .slide = 1};
  RolloutResult limited, free;
  const Eigen::Vector2d start(0, 0.3), end(0.2, 0.05);
  ASSERT_EQ(rollout(*system.model, start, start, end, {.effort_limits = true}, limits, system.work, limited), Status::Solved);
  system.work.forget();
  ASSERT_EQ(rollout(*system.model, start, start, end, {}, limits, system.work, free), Status::Solved);
  ASSERT_EQ(limited.knots.size(), free.knots.size());
  for (std::size_t k = 0; k < free.knots.size(); ++k) {
    EXPECT_EQ(limited.knots[k].q, free.knots[k].q);
    EXPECT_EQ(limited.knots[k].u, free.knots[k].u);
  }
  EXPECT_EQ(limited.steps, free.steps);
}

TEST(Effort, StepWithinEfforts_FollowsFromTheCommandThatIsKept) {
  Stepper system(wall_scene(kInfinity, 3));
  const Eigen::Vector2d q(0, 0.01);
  Eigen::VectorXd u = Eigen::Vector2d(0.1, -0.4);
  StepResult cut;
  int steps = 0;
  ASSERT_EQ(step_within_efforts(*system.model, q, u, {.effort_limits = true}, system.work, cut, steps), Status::Solved);
  EXPECT_GE(steps, 2);
  EXPECT_EQ(u[0], 0.1);
  EXPECT_NEAR(u[1], -0.03, 1e-4);
  system.work.forget();
  const StepResult again = system(q, u, {.effort_limits = true});
  EXPECT_NEAR((again.q_next - cut.q_next).norm(), 0, 1e-9);
}

/// … and the step is that of the command that is kept, bit by bit.
TEST(Effort, StepWithinEfforts_CommandALittleBeyondTheMotor_IsTakenBack) {
  Stepper system(wall_scene(kInfinity, 3));
  const StepOptions options{.effort_limits = true, .warm_start = false};
  const Eigen::Vector2d q(0, 0);
  for (const double beyond : {1e-5, 1e-4, 4e-4, 1e-3}) {
    Eigen::VectorXd u = Eigen::Vector2d(0.1, -0.03 * (1 + beyond));
    StepResult out;
    int steps = 0;
    ASSERT_EQ(step_within_efforts(*system.model, q, u, options, system.work, out, steps), Status::Solved);
    EXPECT_EQ(system(q, u, options).q_next, out.q_next) << beyond;
    const double share = system.model->stiffness()[1] * std::abs(u[1] - out.q_next[1]) / system.model->effort()[1];
    EXPECT_LE(share, 1 + 1e-9) << beyond;
    EXPECT_GE(share, 1 - 1e-3) << beyond;
  }
}

/// The pusher's ball beneath a block of 2 kg that stands on its lower limit.
TEST(Effort, BlockHeavierThanTheMotorBears_IsNotLifted) {
  for (const double effort : {15.0, 25.0}) {
    world::Scene scene = empty_scene();
    scene.gravity = {0, 0, -10};
    world::ObjectSpec block = ball(world::ObjectJoint::Slider, 2, 0.1, 0);
    block.axis = Eigen::Vector3d::UnitZ();
    block.X_WP.p = {0, 0, 0.2};
    block.limits = {0, 1};
    scene.objects.push_back(block);
    scene.robots.push_back(weak_pusher(kInfinity, effort));
    Stepper system(scene);
    const Eigen::Vector3d q(0, 0, 0);
    const Eigen::Vector2d u(0, 0.5);
    for (const bool smoothed : {false, true}) {
      StepOptions options{.effort_limits = true};
      if (smoothed) options.smoothing = Analytic{.kappa = 1e6};
      const StepResult r = system(q, u, options);
      const double lift = effort < 20 ? 0 : (100 * 0.5 - 20) / (100 + 10);  // K(u − x) = mg + εm/h² x, and (S.3) makes that 0.1 K x
      EXPECT_NEAR(r.q_next[0], lift, smoothed ? 1e-4 : 1e-5) << effort << smoothed;
      EXPECT_NEAR(r.torque[1], effort < 20 ? effort : 20 + 10 * lift, smoothed ? 0.02 : 1e-3) << effort << smoothed;
      EXPECT_EQ(r.saturated[1], effort < 20);
    }
  }
}

/// The arm of two links of 0.3 m and 0.2 m in the y-z plane; its tip presses across the second link on a post with f = min(τ₁/l₁, τ₂/l₂), l the levers, and the motor
/// that would bear more stands where that force has it.
TEST(Effort, ArmOfTwoJoints_WeakerMotorDecidesTheForce) {
  for (const auto& [first, second] : {std::pair{1.0, kInfinity}, {kInfinity, 1.0}, {1.0, 1.0}, {1.0, 0.1}}) {
    world::Scene scene = empty_scene();
    world::RobotSpec arm;
    arm.name = "arm";
    arm.urdf = source_dir() / "models" / "planar_arm_left.urdf";
    arm.friction = 0;
    arm.stiffness = {{"joint_1", 50}, {"joint_2", 50}};
    arm.effort = {{"joint_1", first}, {"joint_2", second}};
    scene.robots.push_back(arm);
    const Eigen::Vector2d q(-0.5, -0.5), u(-0.6, -0.6);
    const double a = q[0], b = q[0] + q[1];
    const Eigen::Vector2d tip(-0.3 * std::cos(a) - 0.2 * std::cos(b), -0.3 * std::sin(a) - 0.2 * std::sin(b));
    const Eigen::Vector2d ahead(-std::sin(b), std::cos(b));  // where joints that turn back move it
    const double lever_1 = std::abs(tip.x() * ahead.y() - tip.y() * ahead.x()), lever_2 = 0.2;
    world::FixedSpec post;
    post.name = "post";
    post.X_WB.p << 0, tip + 0.1 * ahead;
    post.geometries.push_back({.name = "ball", .shape = world::Sphere{0.05}, .X_BG = {}, .friction = 0});
    scene.fixed.push_back(post);
    scene.contact_distance = 0.02;  // the other balls of the arm have no row with it
    Stepper system(scene);
    const StepResult r = system(q, u, {.effort_limits = true});
    const double force = std::min(first / lever_1, second / lever_2);
    double normal = 0;
    for (const auto& c : r.contacts) normal += c.lambda[0] / 0.1;
    EXPECT_NEAR(normal, force, 1e-3 * force);
    EXPECT_NEAR(r.torque[0], -lever_1 * force, 1e-3);
    EXPECT_NEAR(r.torque[1], -lever_2 * force, 1e-3);
    EXPECT_NEAR(lever_1 * r.delta[0] + lever_2 * r.delta[1], 0, 1e-6);  // the gap stays closed
    const int within = first / lever_1 < second / lever_2 ? 1 : 0;
    EXPECT_NEAR(r.q_next[within], u[within] - r.torque[within] / 50, 1e-5);
  }
}

TEST(Effort, SmoothedCorner_IsSharpToAThousandthOfTheEffort) {
  Stepper system(wall_scene(kInfinity, 3));
  const StepOptions options{.smoothing = Analytic{}, .effort_limits = true};
  double last = 0;
  for (double u = 0.3; u > -0.6; u -= 0.003) {
    const StepResult r = system(Eigen::Vector2d(0, 0.01), Eigen::Vector2d(0, u), options);
    const double pull = std::min(3.0, 100 * (r.q_next[1] - u));
    EXPECT_NEAR(-r.torque[1], pull, 2e-3 * 3) << u;
    EXPECT_NEAR(r.contacts.at(0).lambda[0] / 0.1, -r.torque[1], 1e-6) << u;
    EXPECT_GE(-r.torque[1], last - 2e-3 * 3) << u;  // no jump where the row of the motor comes in
    last = -r.torque[1];
  }
  EXPECT_NEAR(last, 3, 1e-4);
}

/// Tasks with efforts of a random part of what their springs would pull with.
class EveryTask : public testing::TestWithParam<const char*> {
 protected:
  world::Scene scene() const {
    const std::filesystem::path packages[] = {stiction::test::package_dir()};
    world::Scene out = world::load_scene(source_dir() / "tasks" / (std::string(GetParam()) + ".yaml"), packages);
    const auto plain = Model::make(out);
    core::Random random(7, 0);
    for (auto& robot : out.robots) robot.effort.clear();
    for (int j = 0; j < plain->n_a(); ++j) {
      const world::Dof& dof = plain->dofs()[static_cast<std::size_t>(plain->n_vu() + j)];
      world::RobotSpec& robot = out.robots[static_cast<std::size_t>(dof.owner)];
      const double share = random.chance(0.1) ? kInfinity : std::exp(random.uniform(-8, -2.5));
      robot.effort.emplace_back(dof.name.substr(dof.name.find('/') + 1), share * dof.stiffness);
    }
    return out;
  }
};

TEST_P(EveryTask, RandomStates_OptimalityOfSaturatingSprings) {
  Stepper system(scene());
  const Model& model = *system.model;
  core::Random random(8, 0);
  const double most = (model.effort().array().isFinite()).select(model.effort().array() / model.stiffness().array(), 0).maxCoeff();
  int saturated = 0, solved = 0;
  for (int attempt = 0; attempt < 200; ++attempt) {
    const VectorXd q = sample_task(GetParam(), model, random);
    VectorXd u = q.tail(model.n_a());
    for (double& x : u) x += 0.3 * random.normal();
    StepOptions options{.joint_limits = false, .effort_limits = true};  // limits carry forces that are not in the contact list
    if (attempt % 4 == 1) options.smoothing = Analytic{};
    if (attempt % 4 == 2 && !model.planar_axis()) options.friction_law = FrictionLaw::Coulomb;
    if (attempt % 4 == 3) options.with_A = options.with_B = true;
    StepResult r;
    system.work.forget();
    if (step(model, {q, u}, options, system.work, r) != Status::Solved) continue;
    ++solved;
    const bool smoothed = attempt % 4 == 1;
    const Optimality o = recompute(model, q, u, options, r);
    EXPECT_LE(o.stationarity, 1e-7) << attempt;
    EXPECT_LE(o.motors, attempt % 4 == 3 ? 5e-5 : smoothed ? 1e-3 * most : 5e-6) << attempt;  // roots of the complementarities
    if (attempt % 4 != 2) {
      EXPECT_LE(o.primal, 1e-7) << attempt;
    }  // Coulomb's contacts slide closed
    EXPECT_LE(o.dual, 1e-6) << attempt;
    for (int j = 0; j < model.n_a(); ++j) {
      EXPECT_LE(std::abs(r.torque[j]), model.effort()[j]);
      saturated += r.saturated[static_cast<std::size_t>(j)];
    }
  }
  EXPECT_GT(solved, 190);
  EXPECT_GT(saturated, 50);
}

TEST_P(EveryTask, EffortsThatAreNotReached_SameBitsAsWithoutLimits) {
  world::Scene strong = scene();
  for (auto& robot : strong.robots) {
    for (auto& [joint, effort] : robot.effort) effort = 1e6;
  }
  Stepper system(strong);
  const Model& model = *system.model;
  core::Random random(9, 0);
  for (int attempt = 0; attempt < 50; ++attempt) {
    const VectorXd q = sample_task(GetParam(), model, random);
    VectorXd u = q.tail(model.n_a());
    for (double& x : u) x += 0.03 * random.normal();
    StepOptions options{.with_B = true, .with_A = true};
    if (attempt % 2 == 1) options.smoothing = Analytic{};
    StepResult r[2];
    for (const bool limited : {false, true}) {
      system.work.forget();
      options.effort_limits = limited;
      ASSERT_EQ(step(model, {q, u}, options, system.work, r[limited]), Status::Solved);
    }
    EXPECT_EQ(r[0].q_next, r[1].q_next);
    EXPECT_EQ(r[0].A, r[1].A);
    EXPECT_EQ(r[0].B, r[1].B);
    EXPECT_EQ(r[0].torque, r[1].torque);
  }
}

TEST_P(EveryTask, AfterFirstCalls_AllocatesNothing) {
  Stepper system(scene());
  const Model& model = *system.model;
  StepOptions options{.with_B = true, .with_A = true, .effort_limits = true};
  StepResult r;
  long counted = 0, saturated = 0;
  for (int round = 0; round < 2; ++round) {
    core::Random random(10, 0);
    for (int attempt = 0; attempt < 20; ++attempt) {
      const VectorXd q = sample_task(GetParam(), model, random);
      VectorXd u = q.tail(model.n_a());
      for (double& x : u) x += 0.3 * random.normal();
      const long before = bench::allocations();
      (void)step(model, {q, u}, options, system.work, r);
      if (round == 1) counted += bench::allocations() - before;
      saturated += std::ranges::count(r.saturated, 1);
    }
  }
  EXPECT_EQ(counted, 0);
  EXPECT_GT(saturated, 0);
}

INSTANTIATE_TEST_SUITE_P(Tasks, EveryTask, testing::Values("planar_hand", "allegro_ball"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace stiction::dynamics::test
