// An arm that feels its way: paths, the map of touches, and whole runs in the simulation.
#include "stiction/execution/touch/touch_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "execution/touch_options.hpp"
#include "stiction/contact/contact.hpp"
#include "stiction/execution/touch/joint_path.hpp"
#include "stiction/tasks/touch_scenario_file.hpp"
#include "stiction/world/robot_chains.hpp"
#include "stiction/world/scales.hpp"
#include "support/message_of.hpp"
#include "support/paths.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::execution::test {
namespace {

using contact::PathOutcome;
using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using stiction::test::message_of;
using stiction::test::source_dir;
using tasks::load_touch_scenario;

TouchScenario pillar() { return load_touch_scenario(source_dir() / "scenarios" / "reach_past_pillar.yaml"); }

/// Centre of the hand at a posture.
Vector3d hand(const world::Model& model, const VectorXd& q_a) {
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  VectorXd q = model.neutral();
  q.tail(model.n_a()) = q_a;
  world::calc_kinematics(model, q, work, kinematics);
  Vector3d out = Vector3d::Zero();
  for (const auto& geometry : model.geometries())
    if (model.bodies()[static_cast<std::size_t>(geometry.body)].name == "arm/link_7")
      out = kinematics.X_WB[static_cast<std::size_t>(geometry.body)] * geometry.p_BCenter;
  return out;
}

TEST(JointPath, NoPointOfTheArmIsFasterThanItsSpeed) {
  const TouchScenario scenario = pillar();
  const world::Model& model = *scenario.arm.model;
  VectorXd corner = scenario.goal;
  corner[1] -= 0.4, corner[3] += 0.5;
  const JointPath path(model, {scenario.arm.start, corner, corner, scenario.goal}, 0.2);
  EXPECT_EQ(path.at(-1), scenario.arm.start);
  EXPECT_EQ(path.at(path.duration() + 1), scenario.goal);
  double fastest = 0, nearest = 1;
  const double dt = path.duration() / 2000;
  for (int k = 0; k < 2000; ++k) {
    const VectorXd q = path.at(k * dt);
    fastest = std::max(fastest, (hand(model, path.at((k + 1) * dt)) - hand(model, q)).norm() / dt);
    nearest = std::min(nearest, (q - corner).norm());
  }
  EXPECT_LE(fastest, 0.2);
  EXPECT_GT(fastest, 0.05) << "it could go twice as fast";
  EXPECT_LT(nearest, 1e-2) << "the corner is cut";
}

/// Of everything that the arm may meet along a polyline of postures, looked at every tenth of a millimetre.
double smallest_gap(const world::Model& model, const std::vector<VectorXd>& postures) {
  const world::RobotChains chains(model);
  contact::GeometryWorkspace work(model);
  chains.pairs_of(chains.all(), work.pairs);
  VectorXd q = model.neutral();
  double out = 1;
  for (std::size_t i = 1; i < postures.size(); ++i) {
    const int n = static_cast<int>(std::ceil(calc_travel(model, postures[i - 1], postures[i]) / 1e-4));
    for (int k = 0; k <= n; ++k) {
      q.tail(model.n_a()) = postures[i - 1] + static_cast<double>(k) / n * (postures[i] - postures[i - 1]);
      world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
      out = std::min(out, contact::calc_min_distance(model, work.kinematics, work.pairs, 0, work.contact_work));
    }
  }
  return out;
}

class Map : public testing::Test {
 protected:
  TouchScenario scenario = pillar();
  std::shared_ptr<const world::Model> model = scenario.arm.model;
  VectorXd middle = VectorXd(0.5 * (scenario.arm.start + scenario.goal));
  double length = model->scales().robots().length;
  core::Random random{0, 0};

  /// Touched by the hand from the side it comes from.
  TouchedPlace place() const {
    const double radius = 0.031;  // of the hand's ball
    return {.p_W = hand(*model, middle) + Vector3d(0, radius, 0), .n_W = -Vector3d::UnitY(), .spread = 2e-3};
  }
};

TEST_F(Map, BallOfATouchEndsWhereItWasTouchedAndIsAsLargeAsWhereTheArmHasNotBeen) {
  TouchMap map(model);
  const double free = map.find_radius(place(), std::vector{middle});
  EXPECT_EQ(free, length);
  VectorXd behind = middle;
  behind[0] += 0.25;  // the hand beyond the place, where the arm cannot have been
  const double small = map.find_radius(place(), std::vector{middle, behind});
  EXPECT_LT(small, length);
  map.add(place(), free);
  const auto with_ball = map.make_model(0.5);
  const auto& ball = with_ball->geometries().back();
  EXPECT_EQ(with_ball->bodies()[static_cast<std::size_t>(ball.body)].name, "touch_1");
  const double radius = std::get<world::Sphere>(ball.shape).radius;
  EXPECT_DOUBLE_EQ(radius, 0.5 * length + place().spread);
  world::KinematicsWorkspace work(*with_ball);
  world::Kinematics kinematics;
  world::calc_kinematics(*with_ball, with_ball->neutral(), work, kinematics);
  EXPECT_NEAR((kinematics.X_WB[static_cast<std::size_t>(ball.body)].p - place().p_W).norm(), 0.5 * length, 1e-12);
}

TEST_F(Map, RouteGoesStraightWithoutATouchAndAroundItAfterwards) {
  TouchMap map(model);
  const std::vector<VectorXd> way{scenario.arm.start, middle};
  const Route straight = find_route(map, way, scenario.goal, random, {});
  ASSERT_EQ(straight.outcome, PathOutcome::Found);
  EXPECT_EQ(straight.postures.size(), 2u);
  map.add(place(), length);
  const Route around = find_route(map, way, scenario.goal, random, {});
  ASSERT_EQ(around.outcome, PathOutcome::Found);
  EXPECT_EQ(around.share, 1);
  ASSERT_EQ(around.retreat.size(), 2u) << "there is no room where the arm touches";
  EXPECT_EQ(around.retreat.back(), scenario.arm.start);
  EXPECT_GT(around.postures.size(), 2u);
  EXPECT_EQ(around.postures.front(), scenario.arm.start);
  EXPECT_EQ(around.postures.back(), scenario.goal);
  EXPECT_GT(around.travel, straight.travel);
  const double clearance = world::share::kClearance * length;
  EXPECT_GE(smallest_gap(*straight.model, straight.postures), 0.5 * clearance);
  EXPECT_GE(smallest_gap(*around.model, around.postures), 0.5 * clearance);
}

TEST_F(Map, GoalInsideOfWhatWasTouched_IsBlocked) {
  TouchMap map(model);
  map.add({.p_W = hand(*model, scenario.goal), .n_W = -Vector3d::UnitY(), .spread = 0}, length);
  EXPECT_EQ(find_route(map, std::vector{scenario.arm.start}, scenario.goal, random, {}).outcome, PathOutcome::GoalBlocked);
}

/// A thin rod of 1 m that turns about z, and a plate in its way that is thinner than the tip moves between two coarse looks. The cube is the smallest thing in the
/// scene, so that the clearance is a millimetre.
std::shared_ptr<const world::Model> rod_and_plate() {
  world::Scene scene;
  scene.name = "rod";
  world::RobotSpec robot;
  robot.name = "arm";
  robot.text = R"(<robot name="rod"><link name="base"/><link name="rod">
    <inertial><origin xyz="0.5 0 0"/><mass value="1"/><inertia ixx="1e-4" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.002 0.002"/></geometry></collision></link>
    <joint name="turn" type="revolute"><parent link="base"/><child link="rod"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/></joint></robot>)";
  scene.robots.push_back(robot);
  world::FixedSpec plate;
  plate.name = "plate";
  plate.X_WB.p = {0.9, 0, 0};
  plate.geometries = {{.name = "box", .shape = world::Box{Vector3d(0.05, 0.001, 0.05)}, .X_BG = {}}};
  scene.fixed.push_back(plate);
  world::ObjectSpec cube;
  cube.name = "cube";
  cube.X_WP.p = {5, 0, 0};
  cube.joint = world::ObjectJoint::Slider;
  cube.mass = 0.1, cube.inertia = 1e-4 * Eigen::Matrix3d::Identity();
  cube.geometries = {{.name = "box", .shape = world::Box{Vector3d(0.025, 0.025, 0.025)}, .X_BG = {}}};
  scene.objects.push_back(cube);
  return world::Model::make(scene);
}

TEST(Route, NeverLeadsThroughAThinPlate) {
  const auto rod = rod_and_plate();
  const TouchMap map(rod);
  core::Random random(0, 0);
  for (int k = 0; k < 10; ++k) {  // looks that are 0.02 rad apart meet the plate for some of these and miss it for others
    const VectorXd from = VectorXd::Constant(1, -0.5 + 0.002 * k), to = VectorXd::Constant(1, 0.5);
    EXPECT_EQ(find_route(map, std::vector{from}, to, random, {}).outcome, PathOutcome::NotFound) << k;
    const VectorXd before = VectorXd::Constant(1, -0.01 - 1e-4 * k);
    const Route beside = find_route(map, std::vector{from}, before, random, {});
    EXPECT_EQ(beside.outcome, PathOutcome::Found) << "up to the plate there is a way";
    EXPECT_EQ(beside.postures.size(), 2u);
  }
}

class Touching : public testing::TestWithParam<std::uint64_t> {};

TEST_P(Touching, ReachesItsGoalPastWhatItFeelsWithBoundedForces) {
  const TouchScenario scenario = pillar();
  TouchRunResult out;
  ASSERT_EQ(run_touch(scenario, with_seed(GetParam()), out), Status::Solved) << out.reason;
  EXPECT_EQ(out.outcome, TouchOutcome::Reached) << out.reason;
  EXPECT_LE(out.goal_error, scenario.tolerance);
  ASSERT_GE(out.touches.size(), 1u) << "nothing was in the way: the test would say nothing";
  EXPECT_EQ(out.routes.size(), out.touches.size() + 1);
  EXPECT_LE(out.run.settled_peak, 18.0);
  EXPECT_EQ(out.run.unsolved_ticks, 0);
  for (const Touch& touch : out.touches) EXPECT_LT(touch.error, 0.5 * scenario.arm.model->scales().robots().length);
}
INSTANTIATE_TEST_SUITE_P(Seeds, Touching, testing::Values(0, 1, 3, 8));

TEST(TouchRun, GoalWithinAnUnknownBlock_IsGivenUpWithAReasonAndHeldWithBoundedForces) {
  TouchScenario scenario = pillar();
  UnknownBody& block = scenario.unknown.front();
  block.body.X_WB.p = hand(*scenario.arm.model, scenario.goal);
  block.body.geometries.front().shape = world::Box{Vector3d(0.15, 0.15, 0.2)};
  TouchRunResult out;
  ASSERT_EQ(run_touch(scenario, {}, out), Status::Solved) << out.reason;
  EXPECT_EQ(out.outcome, TouchOutcome::NoRoute) << to_string(out.outcome);
  EXPECT_FALSE(out.reason.empty());
  EXPECT_GE(out.touches.size(), 1u);
  EXPECT_LE(out.run.settled_peak, 18.0);
  EXPECT_LT(out.run.samples.back().speed, 1e-2) << "it holds";
}

/// (G.3): the impact is over before a tick, and no command changes it; what touches does.
TEST(TouchRun, SoftSkin_BoundsTheImpactAndTellsThePlaceAsWell) {
  TouchScenario scenario = pillar();
  scenario.max_touches = 1;
  TouchRunResult stiff, soft;
  ASSERT_EQ(run_touch(scenario, with_seed(2), stiff), Status::Solved);
  scenario.arm.plant.contact.time_constant = 0.04;
  ASSERT_EQ(run_touch(scenario, with_seed(2), soft), Status::Solved);
  EXPECT_GT(stiff.run.peak_force, 100) << "the stiff arm hits as softly: the test says nothing";
  EXPECT_LE(soft.run.peak_force, 18.0);
  ASSERT_EQ(soft.touches.size(), 1u);
  EXPECT_LT(soft.touches[0].error, 0.02);
}

TEST(TouchRun, SameSeed_GivesTheSameBitsAndAnotherDoesNot) {
  TouchScenario scenario = pillar();
  scenario.max_touches = 1;
  TouchRunResult a, b, c;
  ASSERT_EQ(run_touch(scenario, with_seed(3), a), Status::Solved);
  ASSERT_EQ(run_touch(scenario, with_seed(3), b), Status::Solved);
  ASSERT_EQ(run_touch(scenario, with_seed(4), c), Status::Solved);
  ASSERT_EQ(a.outcome, TouchOutcome::TooManyTouches);
  EXPECT_EQ(a.run.samples.back().q, b.run.samples.back().q);
  EXPECT_NE(a.run.samples.back().q, c.run.samples.back().q);
}

TEST(TouchScenarioFile, BadInput_NamesFileAndField) {
  std::ifstream in(source_dir() / "scenarios" / "reach_past_pillar.yaml");
  std::string good((std::istreambuf_iterator<char>(in)), {});
  const std::string relative = "../models";
  good.replace(good.find(relative), relative.size(), (source_dir() / "models").string());
  const std::filesystem::path file = stiction::test::folder_of_the_process() / "touch_test_bad.yaml";
  const auto message = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    std::ofstream(file) << text;
    const std::string out = message_of([&] { (void)make_world(load_touch_scenario(file), 0); });
    std::filesystem::remove(file);
    return out;
  };
  EXPECT_NE(message("goal: [0.8,", "goal: [9,").find("limits"), std::string::npos);
  EXPECT_NE(message("speed: 0.15", "speed: 0").find("speed: got 0"), std::string::npos);
  EXPECT_NE(message("name: pillar", "name: table").find("'table', which is taken"), std::string::npos);
  EXPECT_NE(message("yaw: 0.8", "yaw: -1").find("unknown[0].spread.yaw: got -1"), std::string::npos);
  EXPECT_NE(message("position: [0.05, 0.15, 0]", "position: [0.05, -1, 0]").find("unknown[0].spread.position"), std::string::npos);
  EXPECT_NE(message("estimator: {", "estimator: {contacts: true, ").find("joint torques alone"), std::string::npos);
  EXPECT_NE(message("speed: 0.15", "reference: 0").find("reference"), std::string::npos);
  const std::string blocked = message("position: [0.58, 0, 0.23]", "position: [0.45, -0.4, 0.3]");
  EXPECT_NE(blocked.find("start: got a posture that touches 'pillar/box' (seed 0)"), std::string::npos) << blocked;
  EXPECT_NE(blocked.find("touch_test_bad.yaml"), std::string::npos) << blocked;
}

}  // namespace
}  // namespace stiction::execution::test
