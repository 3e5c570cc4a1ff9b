// A = D_qnext_q, B and the derivatives of the impulses against central differences through retract: tasks, and scenes made in code.
#include <Eigen/Geometry>
#include <algorithm>
#include <set>

#include "dynamics/linearisation.hpp"
#include "dynamics/wrist.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::dynamics::test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

class EveryTask : public testing::TestWithParam<const char*> {
 protected:
  void run(const StepOptions& options) {
    const std::string task = GetParam();
    System s(load_task(task), options);
    core::Random random(42, 0);
    int states = 0, attempts = 0;
    double most = 0;
    for (; attempts < 400 * kStates && states < kStates; ++attempts) {
      const VectorXd q = sample_task(task, *s.model, random);
      VectorXd u = q.tail(s.model->n_a());
      for (Eigen::Index j = 0; j < u.size(); ++j) u[j] += 0.03 * random.normal();
      const Outcome here = s.outcome(q, u);
      if (!here.solved || (s.exact() && !here.clear) || !s.smooth(q, u)) continue;
      const auto e = compare(s, q, u, kStep);
      if (!e) continue;
      ++states;
      most = std::max(most, largest(s.result.A.topRightCorner(s.model->n_vu(), s.model->n_a())));
      expect_small(*e, attempts);
    }
    EXPECT_EQ(states, kStates) << "of " << attempts;
    EXPECT_GT(most, 0.01) << "the fingers never moved the object: the test would say nothing";
  }
};

TEST_P(EveryTask, Smoothed_MatchesCentralDifferences) {
  run({.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

TEST_P(EveryTask, Exact_MatchesCentralDifferences) { run({.with_B = true, .with_A = true, .with_force_derivatives = true}); }

INSTANTIATE_TEST_SUITE_P(Tasks, EveryTask, testing::Values("planar_pushing", "planar_hand", "allegro_ball"),
                         [](const auto& test) { return std::string(test.param); });

/// States near the neutral one of a scene made in code. @returns in how many a motor gave all it had
int run_scene(const world::Scene& scene, const StepOptions& options, double damping, int least, int* sliding = nullptr) {
  System s(Model::make(scene), options);
  s.damping = VectorXd::Constant(s.model->n_v(), damping);
  core::Random random(43, 0);
  int states = 0, attempts = 0, saturated = 0;
  for (; attempts < 50 * least && states < least; ++attempts) {
    VectorXd q = s.model->neutral(), delta(s.model->n_v());
    for (Eigen::Index i = 0; i < delta.size(); ++i) {
      delta[i] = (s.model->dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute ? 0.3 : 0.01) * random.normal();
    }
    world::retract(*s.model, q, delta, q);
    VectorXd u = q.tail(s.model->n_a());
    for (double& x : u) x += 0.02 * random.normal();
    if (!s.smooth(q, u)) continue;
    const auto e = compare(s, q, u, kStep);
    if (!e) continue;
    ++states;
    saturated += std::ranges::count(s.result.saturated, 1) > 0;
    expect_small(*e, attempts);
    for (Eigen::Index v = 0; sliding != nullptr && v < s.result.joint_friction.size(); ++v) {
      const double friction = s.model->dofs()[static_cast<std::size_t>(v)].friction;
      *sliding += friction > 0 && std::abs(s.result.joint_friction[v]) > (1 - 1e-4) * friction;
    }
  }
  EXPECT_EQ(states, least) << "of " << attempts;
  return saturated;
}

TEST(Linearisation, MotorsThatGiveAllTheyHave_MatchCentralDifferences) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.2;
  scene.gravity = {0, 0, -9};
  scene.objects = {free_object(world::Cylinder{0.04, 0.06})};
  scene.robots = {wrist("hand_motors", world::Capsule{0.03, 0.05})};
  for (const auto& [joint, stiffness] : scene.robots[0].stiffness) scene.robots[0].effort.emplace_back(joint, stiffness > 100 ? 1.0 : 0.03);
  scene.robots[0].X_WBase.p = {0.02, 0.07, 0.03};
  scene.fixed = {half_space({0, 0, 1}, {0, 0, -0.1}, 0.6)};
  StepOptions options{.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true, .effort_limits = true};
  EXPECT_GT(run_scene(scene, options, 0.0, 40), 20);
  EXPECT_GT(run_scene(scene, options, 0.5, 20), 5);
  options.smoothing = Exact{};
  options.regularisation = FixedEpsilon{3};
  EXPECT_GT(run_scene(scene, options, 0.0, 20), 5);
}

TEST(Linearisation, ContactsThatResistTurning_MatchCentralDifferences) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.2;
  scene.gravity = {0, 0, -9};
  scene.objects = {free_object(world::Cylinder{0.04, 0.06})};
  scene.objects[0].geometries[0].rule = {.dimension = 4, .torsional = 0.02};
  scene.robots = {wrist("hand_turning", world::Capsule{0.03, 0.05})};
  scene.robots[0].X_WBase.p = {0.02, 0.07, 0.03};
  scene.fixed = {half_space({0, 0, 1}, {0, 0, -0.1}, 0.6)};
  (void)run_scene(scene, {.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 40);
  (void)run_scene(scene, {.regularisation = FixedEpsilon{3}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 10);
}

TEST(Linearisation, ObjectsWithOffsetCentres_MatchCentralDifferences) {
  for (const auto joint : {world::ObjectJoint::Hinge, world::ObjectJoint::Slider, world::ObjectJoint::PlanarYZ, world::ObjectJoint::Free}) {
    SCOPED_TRACE(static_cast<int>(joint));
    world::Scene scene = empty_scene();
    scene.gravity = {0, 1, -9};
    scene.contact_distance = 0.3;
    world::ObjectSpec object = free_object(world::Capsule{0.05, 0.1});
    object.joint = joint;
    object.p_BCom = {0.01, 0.06, 0.02};
    object.axis = joint == world::ObjectJoint::Hinge ? Vector3d(1, 0, 0) : Vector3d(0, 0.6, 0.8);
    if (joint == world::ObjectJoint::Hinge || joint == world::ObjectJoint::Slider) object.limits = {-0.9, 1.0};
    scene.objects = {object};
    scene.robots = {wrist("hand_" + std::to_string(static_cast<int>(joint)), world::Box{{0.03, 0.04, 0.05}})};
    scene.robots[0].X_WBase.p = {0, 0.12, 0.03};
    (void)run_scene(scene, {.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 40);
    (void)run_scene(scene, {.regularisation = FixedEpsilon{3}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 10);
  }
}

/// A flap on a hinge, which carries a handle on a hinge, which carries a bolt that slides; `base` carries the flap, if it is not the world.
world::Scene make_chain(const std::string& base) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 1, -9};
  scene.contact_distance = 0.3;
  const auto add = [&](const std::string& name, const std::string& parent, world::ObjectJoint joint, const Vector3d& axis,
                       const Vector3d& at, const world::Shape& shape) {
    world::ObjectSpec o = free_object(shape);
    o.name = name;
    o.parent = parent;
    o.joint = joint;
    o.axis = axis;
    o.X_WP.p = at;
    o.p_BCom = {0.01, 0.03, 0.02};
    scene.objects.push_back(o);
  };
  if (!base.empty()) add(base, "", world::ObjectJoint::Free, Vector3d::UnitX(), Vector3d::Zero(), world::Sphere{0.02});
  add("flap", base, world::ObjectJoint::Hinge, {1, 0, 0}, {0, -0.06, 0.0}, world::Capsule{0.02, 0.04});
  add("handle", "flap", world::ObjectJoint::Hinge, {0, 0.6, 0.8}, {0, 0.05, 0.09}, world::Box{{0.02, 0.03, 0.02}});
  add("bolt", "handle", world::ObjectJoint::Slider, {0.8, 0, 0.6}, {0.02, 0.04, 0}, world::Sphere{0.015});
  return scene;
}

TEST(Linearisation, ObjectsThatHangOnOthers_MatchCentralDifferences) {
  for (const std::string base : {"", "base"}) {
    SCOPED_TRACE(base);
    world::Scene scene = make_chain(base);
    scene.robots = {wrist("hand_chain" + base, world::Box{{0.03, 0.04, 0.05}})};
    scene.robots[0].X_WBase.p = {0, 0.12, 0.13};
    (void)run_scene(scene, {.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 30);
    (void)run_scene(scene, {.regularisation = FixedEpsilon{3}, .with_B = true, .with_A = true, .with_force_derivatives = true}, 0.0, 5);
  }
}

TEST(Linearisation, JointsThatStickAndSlide_MatchCentralDifferences) {
  world::Scene scene = make_chain("");
  for (world::ObjectSpec& object : scene.objects) object.joint_friction = object.name == "flap" ? 0.6 : 0.3;
  scene.robots = {wrist("hand_rust", world::Box{{0.03, 0.04, 0.05}})};
  scene.robots[0].X_WBase.p = {0, 0.12, 0.13};
  for (const bool smoothed : {true, false}) {
    StepOptions options{.regularisation = FixedEpsilon{3}, .with_B = true, .with_A = true, .with_force_derivatives = true};
    if (smoothed) options.smoothing = Analytic{.kappa = 1e4};
    const int states = smoothed ? 30 : 10;
    int sliding = 0;
    (void)run_scene(scene, options, 0.0, states, &sliding);
    EXPECT_GT(sliding, states / 2);
    EXPECT_LT(sliding, 3 * states - states / 2);
  }
}

TEST(Linearisation, PyramidsDampingAndNoFriction_MatchCentralDifferences) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.2;
  scene.gravity = {0, 0, -9};
  scene.objects = {free_object(world::Cylinder{0.04, 0.06})};
  scene.robots = {wrist("hand_pyramid", world::Capsule{0.03, 0.05})};
  scene.robots[0].X_WBase.p = {0.02, 0.1, 0.03};
  scene.fixed = {half_space({0, 0, 1}, {0, 0, -0.1}, 0.6)};
  StepOptions options{.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true};
  (void)run_scene(scene, options, 0.5, 20);
  options.friction_scale = 0;
  (void)run_scene(scene, options, 0.0, 20);
  options.friction_scale = 0.7;
  options.friction_cone = PolyhedralCone{5};
  (void)run_scene(scene, options, 0.5, 20);
}

TEST(Linearisation, NothingNear_ObjectStaysAndRobotForgets) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.01;
  scene.objects = {ball(world::ObjectJoint::Free, 1, 0.1, 1)};
  scene.robots = {wrist("hand_far", world::Sphere{0.03})};
  scene.robots[0].X_WBase.p = {1, 0, 0};
  System s(Model::make(scene), {.with_A = true});
  ASSERT_TRUE(s.outcome(s.model->neutral(), VectorXd::Constant(6, 0.01)).solved);
  MatrixXd want = MatrixXd::Zero(12, 12);
  want.topLeftCorner<6, 6>().setIdentity();  // u, not q, decides where the springs end
  EXPECT_LE(largest(s.result.A - want), 1e-9);
  EXPECT_EQ(s.result.B.size(), 0);
}

TEST(Linearisation, ForceDerivativesAlone_AreRefused) {
  const StepOptions options{.with_force_derivatives = true};
  EXPECT_THROW(options.validate(), core::InvalidInput);
}

}  // namespace
}  // namespace stiction::dynamics::test
