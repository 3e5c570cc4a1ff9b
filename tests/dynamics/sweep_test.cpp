// Steps that go farther than contacts are looked for (S.16).
#include <fstream>
#include <random>
#include <sstream>

#include "dynamics/systems.hpp"
#include "stiction/world/scales.hpp"
#include "stiction/world/shapes.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

struct FingerShape {
  const char* name;
  const char* urdf;  // its front is 0.02 m ahead of the link along x
};
const FingerShape kFingers[] = {{"Ball", "<sphere radius='0.02'/>"},
                                {"Box", "<box size='0.04 0.04 0.04'/>"},
                                {"Capsule", "<capsule radius='0.02' length='0.1'/>"},
                                {"Cylinder", "<cylinder radius='0.02' length='0.1'/>"}};

/// A link `at` from the origin on one joint along or about `axis`.
world::RobotSpec one_joint(const std::string& geometry, const std::string& type, const char* axis, const char* at, double stiffness) {
  world::RobotSpec robot;
  robot.name = "finger";
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string file = std::string(test->test_suite_name()) + "_" + test->name();
  std::ranges::replace(file, '/', '_');
  robot.urdf = stiction::test::folder_of_the_process() / (file + ".urdf");
  std::ofstream(robot.urdf) << "<robot name='finger'><link name='base'/><link name='tip'><collision><origin xyz='" << at << "'/><geometry>"
                            << geometry << "</geometry></collision></link><joint name='j' type='" << type
                            << "'><parent link='base'/><child link='tip'/><axis xyz='" << axis
                            << "'/><limit lower='-9' upper='9' effort='1' velocity='1'/></joint></robot>";
  robot.stiffness = {{"j", stiffness}};
  return robot;
}

/// Links of 0.3 m that turn in their plane, one after the other.
world::RobotSpec planar_arm(int joints) {
  world::RobotSpec robot = one_joint("<sphere radius='0.02'/>", "revolute", "0 0 1", "0 0 0", 100);
  std::ostringstream urdf;
  urdf << "<robot name='finger'><link name='l0'/>";
  for (int i = 1; i <= joints; ++i)
    urdf << "<link name='l" << i
         << "'><collision><origin xyz='0.15 0 0' rpy='0 1.5707963 0'/><geometry><capsule radius='0.02' length='0.22'/></geometry>"
         << "</collision></link><joint name='j" << i << "' type='revolute'><parent link='l" << i - 1 << "'/><child link='l" << i
         << "'/><origin xyz='" << (i > 1 ? 0.3 : 0)
         << " 0 0'/><axis xyz='0 0 1'/><limit lower='-9' upper='9' effort='9' velocity='1'/></joint>";
  std::ofstream(robot.urdf) << urdf.str() << "</robot>";
  robot.stiffness.clear();
  for (int i = 1; i <= joints; ++i) robot.stiffness.emplace_back("j" + std::to_string(i), 100);
  return robot;
}

/// A box as a mesh.
world::Shape hull() {
  Eigen::Matrix3Xd points(3, 8);
  for (int i = 0; i < 8; ++i) points.col(i) << (i & 1 ? 0.01 : -0.01), (i & 2 ? 0.1 : -0.1), (i & 4 ? 0.1 : -0.1);
  return world::Mesh{std::make_shared<world::ConvexMesh>(world::make_convex_hull(points))};
}

world::ObjectSpec thing(const std::string& name, const world::Shape& shape, world::ObjectJoint joint = world::ObjectJoint::PlanarXY) {
  world::ObjectSpec object;
  object.name = name;
  object.joint = joint;
  object.mass = 1;
  object.inertia = Vector3d(4e-3, 4e-3, 4e-3).asDiagonal();
  object.geometries.push_back({.name = "shape", .shape = shape, .X_BG = {}, .friction = 0.5});
  return object;
}

world::Scene scene_of(double distance) {
  world::Scene scene = empty_scene();
  scene.contact_distance = distance;
  return scene;
}

StepResult solve(const std::shared_ptr<const Model>& model, const VectorXd& q, const VectorXd& u, const StepOptions& options = {}) {
  StepWorkspace work(model);
  StepResult r;
  EXPECT_EQ(step(*model, {q, u}, options, work, r), Status::Solved);
  return r;
}

VectorXd numbers(std::initializer_list<double> x) { return Eigen::Map<const VectorXd>(x.begin(), static_cast<Eigen::Index>(x.size())); }

class Fingers : public testing::TestWithParam<FingerShape> {
 protected:
  std::shared_ptr<const Model> make(double distance, const world::Shape& shape) {
    world::Scene scene = scene_of(distance);
    scene.robots.push_back(one_joint(GetParam().urdf, "prismatic", "1 0 0", "0 0 0", 100));
    scene.objects.push_back(thing("o", shape));
    return Model::make(scene);
  }
};

/// The finger goes 1 m, the thing stands 0.3 m ahead: the step is that of a model that looks for contacts as far as the command goes.
TEST_P(Fingers, CommandFartherThanContactDistance_PushesWhatItWouldHaveSeenFromAfar) {
  const world::Shape shapes[] = {world::Box{{0.01, 0.1, 0.1}}, world::Sphere{0.03}, world::Cylinder{0.03, 0.1}, world::Capsule{0.03, 0.05},
                                 hull()};
  for (const auto& shape : shapes) {
    for (const Smoothing& smoothing : {Smoothing(Exact{}), Smoothing(Analytic{})}) {
      const VectorXd q = numbers({0.3, 0, 0, 0}), u = numbers({1});
      const StepResult near = solve(make(0.1, shape), q, u, {.smoothing = smoothing});
      const StepResult far = solve(make(2, shape), q, u, {.smoothing = smoothing});
      EXPECT_LT((near.delta - far.delta).lpNorm<Eigen::Infinity>(), 1e-6) << world::shape_name(shape);
      EXPECT_GT(near.q_next[0], near.q_next[3] + 0.01) << world::shape_name(shape);
      EXPECT_GT(near.q_next[0], 0.9) << world::shape_name(shape);
    }
  }
}

/// What the finger passes by has no row: Anitescu's cone would open by μ times a slip of a metre, and push it from afar.
TEST_P(Fingers, ThingBesideTheWay_StaysWhereItIs) {
  const auto model = make(0.1, world::Box{{0.01, 0.1, 0.1}});
  const StepResult r = solve(model, numbers({0.3, 0.13, 0, 0}), numbers({1}));
  EXPECT_LT(r.delta.head(3).norm(), 1e-9);
  EXPECT_NEAR(r.q_next[3], 1, 1e-9);
  EXPECT_GT(solve(make(2, world::Box{{0.01, 0.1, 0.1}}), numbers({0.3, 0.13, 0, 0}), numbers({1})).delta.head(3).norm(), 0.01);
}

INSTANTIATE_TEST_SUITE_P(Sweep, Fingers, testing::ValuesIn(kFingers), [](const auto& test) { return test.param.name; });

std::shared_ptr<const Model> make_row_of_blocks() {
  world::Scene scene = scene_of(0.1);
  scene.robots.push_back(one_joint("<sphere radius='0.02'/>", "prismatic", "1 0 0", "0 0 0", 100));
  for (const char* name : {"a", "b", "c"}) scene.objects.push_back(thing(name, world::Box{{0.01, 0.1, 0.1}}));
  return Model::make(scene);
}

/// The first is seen, it is pushed into the second, and that into the third.
TEST(Sweep, RowOfBlocks_EachIsPushedByTheOneBefore) {
  const StepResult r = solve(make_row_of_blocks(), numbers({0.05, 0, 0, 0.3, 0, 0, 0.6, 0, 0, 0}), numbers({1}));
  EXPECT_GT(r.q_next[0], r.q_next[9] + 0.03 - 1e-6);
  EXPECT_GT(r.q_next[3], r.q_next[0] + 0.02 - 1e-6);
  EXPECT_GT(r.q_next[6], r.q_next[3] + 0.02 - 1e-6);
}

TEST(Sweep, CommandThroughWall_StopsAtTheWallWithTheForceOfTheSpring) {
  world::Scene scene = scene_of(0.05);
  scene.robots.push_back(one_joint("<sphere radius='0.02'/>", "prismatic", "1 0 0", "0 0 0", 100));
  world::FixedSpec wall = half_space(-Vector3d::UnitX(), {0.5, 0, 0}, 0.5);
  scene.fixed.push_back(wall);
  const StepResult r = solve(Model::make(scene), numbers({0}), numbers({1}));
  EXPECT_NEAR(r.q_next[0], 0.48, 1e-6);
  ASSERT_EQ(r.contacts.size(), 1u);
  EXPECT_NEAR(r.contacts[0].lambda[0] / 0.1, 100 * 0.52, 1e-2);
}

/// An arm of 1 m turns by 1 rad; the row is linear, so that the tip stops on the tangent at its start and not on its arc.
TEST(Sweep, ArmThatTurnsThroughBlock_StopsBeforeIt) {
  world::Scene scene = scene_of(0.05);
  scene.robots.push_back(one_joint("<sphere radius='0.02'/>", "revolute", "0 0 1", "1 0 0", 100));
  world::FixedSpec block;
  block.name = "block";
  block.X_WB.p = {std::cos(0.5), std::sin(0.5), 0};
  block.geometries.push_back({.name = "ball", .shape = world::Sphere{0.05}, .X_BG = {}, .friction = 0.5});
  scene.fixed.push_back(block);
  const StepResult r = solve(Model::make(scene), numbers({0}), numbers({1}));
  EXPECT_LT(r.q_next[0], 0.5 - 0.07 + 0.05);
  EXPECT_GT(r.q_next[0], 0.3);
}

/// Two of the objects of one scene pass each other only if both move.
TEST(Sweep, HeavyObjectPulledThroughAnother_PushesIt) {
  world::Scene scene = scene_of(0.05);
  scene.objects.push_back(thing("heavy", world::Box{{0.02, 0.02, 0.02}}, world::ObjectJoint::Free));
  scene.objects.back().mass = 100;
  scene.objects.push_back(thing("light", world::Sphere{0.02}, world::ObjectJoint::Free));
  const auto model = Model::make(scene);
  VectorXd q = model->neutral();
  q[7] = 0.5;
  VectorXd pull = VectorXd::Zero(model->n_v());
  pull[0] = 1e4;  // h² F/m = 1 m
  StepWorkspace work(model);
  StepResult r;
  ASSERT_EQ(step(*model, {q, VectorXd(0), &pull}, {.regularisation = FixedEpsilon{1}}, work, r), Status::Solved);
  EXPECT_GT(r.q_next[0], 0.9);
  EXPECT_GT(r.q_next[7], r.q_next[0] + 0.04 - 1e-6);
}

/// Two fingers of one gripper, of which one follows the other: the joint that moves both moves them towards each other.
TEST(Sweep, FingerThatFollows_MeetsTheOneItFollows) {
  world::Scene scene = scene_of(0.05);
  world::RobotSpec gripper = one_joint("<sphere radius='0.02'/>", "prismatic", "1 0 0", "0 0 0", 100);
  std::stringstream read;
  read << std::ifstream(gripper.urdf).rdbuf();
  std::string text = read.str();
  const std::string end = "</robot>";
  text.insert(text.find(end),
              "<link name='other'><collision><origin xyz='0.5 0 0'/><geometry><sphere radius='0.02'/></geometry></collision></link>"
              "<joint name='k' type='prismatic'><parent link='base'/><child link='other'/><axis xyz='-1 0 0'/><mimic joint='j'/>"
              "<limit lower='-9' upper='9' effort='1' velocity='1'/></joint>");
  std::ofstream(gripper.urdf) << text;
  scene.robots.push_back(gripper);
  EXPECT_NEAR(solve(Model::make(scene), numbers({0}), numbers({1})).q_next[0], 0.23, 1e-6);
}

/// What a step passes through has a row, against the distances at 200 points of its way: arms of four joints among boxes and balls, free and fixed.
TEST(Sweep, WhatIsPassedThrough_HasARow) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1, 1);
  world::Scene scene = scene_of(0.03);
  scene.robots.push_back(planar_arm(4));
  for (const char* name : {"a", "b"}) scene.objects.push_back(thing(name, world::Box{{0.03, 0.05, 0.04}}, world::ObjectJoint::Free));
  scene.objects.push_back(thing("c", world::Sphere{0.05}, world::ObjectJoint::Free));
  const auto model = Model::make(scene);
  world::KinematicsWorkspace kinematics_work(*model);
  world::Kinematics kinematics;
  contact::Workspace contact_work(*model);
  const auto distance = [&](const VectorXd& q, int pair) {
    world::calc_kinematics(*model, q, kinematics_work, kinematics);
    return contact::pair_distance(*model, kinematics, pair, contact_work).phi;
  };
  int passed = 0;
  for (int trial = 0; trial < 240; ++trial) {
    VectorXd q = model->neutral();
    for (const auto& o : model->objects()) q.segment<3>(o.q_begin) = Vector3d(place(random), place(random), 0.03 * place(random));
    for (int j = 0; j < 4; ++j) q[model->n_q() - 4 + j] = 1.5 * place(random);
    VectorXd u = q.tail(4);
    for (int j = 0; j < 4; ++j) u[j] += place(random);
    StepWorkspace work(model);
    StepResult r;
    if (step(*model, {q, u}, {}, work, r) != Status::Solved) continue;
    for (int pair = 0; pair < static_cast<int>(model->pairs().size()); ++pair) {
      if (distance(q, pair) < 0.03) continue;
      VectorXd between(model->n_q());
      double least = 1;
      for (int k = 1; k <= 200 && least > 0; ++k) {
        world::retract(*model, q, VectorXd(k / 200.0 * r.delta), between);
        least = distance(between, pair);
      }
      const bool has_row = std::ranges::any_of(r.contacts, [&](const auto& c) { return c.contact.pair == pair; });
      passed += least <= 0;
      EXPECT_TRUE(least > 0 || has_row) << "trial " << trial << ", pair " << pair;
    }
  }
  EXPECT_GT(passed, 20) << "the test would say nothing";
}

/// A and B are those of the program with the rows that were found on the way.
TEST(Sweep, DerivativesMatchCentralDifferences) {
  const auto model = make_row_of_blocks();
  const VectorXd q = numbers({0.05, 0.01, 0.02, 0.3, -0.01, 0.01, 0.6, 0.02, 0.03, 0}), u = numbers({1});
  StepOptions options{.smoothing = Analytic{}, .with_B = true, .with_A = true};
  const StepResult r = solve(model, q, u, options);
  options.with_A = options.with_B = false;
  constexpr double kStep = 1e-5;
  const auto slope = [&](const VectorXd& q_plus, const VectorXd& u_plus, const VectorXd& q_minus, const VectorXd& u_minus) {
    return VectorXd((solve(model, q_plus, u_plus, options).q_next - solve(model, q_minus, u_minus, options).q_next) / (2 * kStep));
  };
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const VectorXd e = kStep * VectorXd::Unit(q.size(), i);
    EXPECT_LT((slope(q + e, u, q - e, u) - r.A.col(i)).lpNorm<Eigen::Infinity>(), 1e-5 * r.A.lpNorm<Eigen::Infinity>()) << i;
  }
  const VectorXd e = numbers({kStep});
  EXPECT_LT((slope(q, u + e, q, u - e) - r.B).lpNorm<Eigen::Infinity>(), 1e-5);
  EXPECT_GT(r.B(6, 0), 0.1) << "the last block does not move with the command: the test would say nothing";
}

/// What one step met is not there for the next one from the same place.
TEST(Sweep, StepAfterOneThatWentFar_IsThatOfAFreshWorkspace) {
  const auto model = make_row_of_blocks();
  const VectorXd q = numbers({0.05, 0, 0, 0.3, 0, 0, 0.6, 0, 0, 0});
  StepWorkspace work(model);
  StepResult far, near;
  ASSERT_EQ(step(*model, {q, numbers({1})}, {.warm_start = false}, work, far), Status::Solved);
  ASSERT_EQ(step(*model, {q, numbers({0.04})}, {.warm_start = false}, work, near), Status::Solved);
  const StepResult fresh = solve(model, q, numbers({0.04}), {.warm_start = false});
  EXPECT_GT(far.contacts.size(), near.contacts.size());
  EXPECT_EQ(near.contacts.size(), fresh.contacts.size());
  EXPECT_EQ(near.delta, fresh.delta);
}

}  // namespace
}  // namespace stiction::dynamics::test
