// Dry friction of hinges and sliders (S.19): they stay where they are left, and move under what exceeds their friction.
#include <algorithm>

#include "cone_allocations.hpp"
#include "dynamics/optimality.hpp"
#include "dynamics/systems.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;
using world::ObjectJoint;

/// A ball of 0.1 m and 2 kg on a joint.
world::ObjectSpec on_joint(ObjectJoint joint, const Vector3d& axis, double friction) {
  world::ObjectSpec object = ball(joint, 2, 0.1, 0);
  object.axis = axis;
  object.joint_friction = friction;
  return object;
}

/// A lever of 0.3 m along y that turns about x, with a ball at its end.
world::ObjectSpec lever(double friction) {
  world::ObjectSpec object = on_joint(ObjectJoint::Hinge, Vector3d::UnitX(), friction);
  object.geometries[0].X_BG.p = {0, 0.3, 0};
  object.p_BCom = {0, 0.3, 0};
  return object;
}

const VectorXd kNoRobot(0);

/// A valve that its weight would turn stays where it is left as long as its friction bears m g r, and keeps the force that holds it.
TEST(JointFriction, ValveLeftAlone_StaysUnlessItsWeightTurnsIt) {
  for (const double share : {0.5, 0.99, 1.01, 3.0}) {
    world::Scene scene = empty_scene();
    scene.gravity = {0, 0, -10};
    scene.objects.push_back(lever(6 / share));  // m g r = 6 N·m
    Stepper system(scene);
    VectorXd q = VectorXd::Zero(1);
    StepResult r;
    for (int k = 0; k < 1000; ++k) {
      r = system(q, kNoRobot);
      q = r.q_next;
      if (share > 1) break;
    }
    if (share < 1) {
      EXPECT_LT(std::abs(q[0]), world::share::kMotionless) << share << ": a thousand steps";
      EXPECT_NEAR(r.joint_friction[0], 6 * std::cos(q[0]), 5e-6) << share << ": less what the creep takes of the regularisation";
    } else {
      EXPECT_LT(q[0], -1e-3) << share;
      EXPECT_NEAR(r.joint_friction[0], 6 / share, 1e-6) << share;
    }
  }
}

/// m δ/h = h (m g sin α − τ_f) of a drawer of its true mass.
TEST(JointFriction, DrawerOnSlope_SlidesByWhatItsWeightExceedsItsFriction) {
  const double alpha = 0.4, h = 0.1;
  for (const double friction : {0.0, 4.0, 7.7, 7.8, 9.0}) {  // m g sin α = 7.788 N
    for (const double sense : {-1.0, 1.0}) {
      world::Scene scene = empty_scene();
      scene.gravity = {0, 0, -10};
      scene.objects.push_back(on_joint(ObjectJoint::Slider, sense * Vector3d(0, std::cos(alpha), -std::sin(alpha)), friction));
      Stepper system(scene);
      const StepResult r = system(VectorXd::Zero(1), kNoRobot, {.h = h, .regularisation = FixedEpsilon{1}});
      const double down = 2 * 10 * std::sin(alpha);
      EXPECT_NEAR(sense * r.q_next[0], h * h / 2 * std::max(0.0, down - friction), 1e-6) << friction;
      if (friction > 0) {
        const double inertia = 2 / (h * h) * sense * r.q_next[0];  // of the creep as well
        EXPECT_NEAR(sense * r.joint_friction[0], -std::min(down - inertia, friction), 1e-6) << friction;
      } else {
        EXPECT_EQ(r.joint_friction.size(), 0);
      }
    }
  }
}

/// The pusher (K = 100 N/m) beneath the end of the lever.
TEST(JointFriction, LeverThatIsPushed_TurnsBeyondItsFrictionOverItsArm) {
  world::Scene scene = empty_scene();
  scene.objects.push_back(lever(1.2));  // 4 N at 0.3 m
  scene.robots.push_back(pusher(0));
  Stepper system(scene);
  VectorXd q(3);
  q << 0, 0.3, -0.2;  // it touches
  for (const double force : {0.5, 3.96, 4.04, 6.0, 20.0}) {
    const StepResult r = system(q, Vector2d(0.3, -0.2 + force / 100));
    double normal = 0;
    for (const auto& c : r.contacts) normal += c.lambda[0] / 0.1;
    // A turn by δ eases the spring by 0.3 δ, and ε I δ/h² is what (S.3) adds.
    const double I = 0.4 * 2 * 0.01 + 2 * 0.09;
    const double turn = std::max(0.0, 0.3 * force - 1.2) / (100 * 0.09 + r.epsilon[0] * I / 0.01);
    EXPECT_NEAR(r.q_next[0], turn, 1e-5) << force;
    EXPECT_NEAR(normal, force - 100 * 0.3 * turn, 1e-3) << force;
    EXPECT_NEAR(r.joint_friction[0], -std::min(1.2, 0.3 * force), 1e-4) << force;
  }
}

/// Pushed there and let go, it stays; pushed on, it goes on.
TEST(JointFriction, RolloutToAndFro_LeverStaysWhereItWasPushed) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 0, -1};
  scene.objects.push_back(lever(0.7));  // its weight pulls with 0.6 N·m
  scene.robots.push_back(pusher(0));
  Stepper system(scene);
  const SubstepLimits limits{.joint_travel = 0.01, .slide = 1};
  VectorXd q(3);
  q << 0, 0.3, -0.2;
  RolloutResult up, down;
  ASSERT_EQ(rollout(*system.model, q, Vector2d(0.3, -0.2), Vector2d(0.3, 0), {}, limits, system.work, up), Status::Solved);
  const VectorXd pushed = up.knots.back().q;
  EXPECT_GT(pushed[0], 0.1);
  ASSERT_EQ(rollout(*system.model, pushed, up.knots.back().u, Vector2d(0.3, -0.4), {}, limits, system.work, down), Status::Solved);
  EXPECT_NEAR(down.knots.back().q[0], pushed[0], 1e-4);
  EXPECT_NEAR(down.knots.back().q[2], -0.4, 1e-6);
}

/// An overlap and a limit that is overrun are undone against any friction: they bound motion, friction is a force.
TEST(JointFriction, OverlapOrLimit_MovesTheJointAgainstItsFriction) {
  world::Scene scene = empty_scene();
  world::ObjectSpec drawer = on_joint(ObjectJoint::Slider, Vector3d::UnitZ(), 1e4);
  drawer.limits = {-0.01, 1};
  scene.objects.push_back(drawer);
  scene.fixed.push_back(half_space(Vector3d::UnitZ(), {0, 0, -0.08}, 0));
  Stepper system(scene);
  EXPECT_NEAR(system(VectorXd::Constant(1, -0.03), kNoRobot).q_next[0], 0.02, 1e-6);
  Stepper free([&] {
    scene.fixed.clear();
    return scene;
  }());
  EXPECT_NEAR(free(VectorXd::Constant(1, -0.03), kNoRobot).q_next[0], -0.01, 1e-6);
}

/// κ smooths it as it does contacts: load/(κτ²/2) where it is small, nothing as κ grows.
TEST(JointFriction, Smoothed_GivesAsABarrierDoes) {
  world::Scene scene = empty_scene();
  scene.objects.push_back(on_joint(ObjectJoint::Slider, Vector3d::UnitZ(), 3));
  Stepper system(scene);
  for (const double kappa : {10.0, 100.0, 1e4}) {
    const VectorXd load = VectorXd::Constant(1, 0.5);
    const StepOptions options{.smoothing = Analytic{.kappa = kappa}, .regularisation = FixedEpsilon{1e-6}};
    const StepResult r = system(VectorXd::Zero(1), kNoRobot, options, &load);
    EXPECT_NEAR(r.q_next[0], 0.5 / (kappa * 9 / 2 + 2e-6 / 0.01), 1e-6);
    EXPECT_NEAR(r.joint_friction[0], -0.5, 1e-3);
  }
  const VectorXd load = VectorXd::Constant(1, 5);
  for (const bool smoothed : {false, true}) {
    StepOptions options{.regularisation = FixedEpsilon{1}};
    if (smoothed) options.smoothing = Analytic{.kappa = 1e6};
    EXPECT_NEAR(system(VectorXd::Zero(1), kNoRobot, options, &load).q_next[0], 0.01 * (5 - 3) / 2, 1e-5);
  }
}

/// The same in other units, but for the last bits: L of a body takes a root.
TEST(JointFriction, OtherUnits_SameStepUpToScale) {
  const auto drawer = [](double s, double m, double friction, double load) {
    world::Scene scene = empty_scene();
    scene.gravity = {0, 0, -8 * s};
    world::ObjectSpec object = on_joint(ObjectJoint::Slider, Vector3d::UnitZ(), friction * m * s);
    object.mass *= m;
    object.inertia *= m * s * s;
    object.geometries[0].shape = world::Sphere{0.1 * s};
    scene.objects.push_back(object);
    Stepper system(scene);
    const VectorXd tau = VectorXd::Constant(1, load * m * s);
    const StepResult r = system(VectorXd::Zero(1), kNoRobot, {.regularisation = FixedEpsilon{1}}, &tau);
    return Vector2d(r.delta[0] / s, r.joint_friction[0] / (m * s));
  };
  for (const double load : {-40.0, 3.0, 12.0, 40.0}) {
    const Vector2d here = drawer(1, 1, 6, load);
    for (const auto& [s, m] : {std::pair{std::ldexp(1, -10), std::ldexp(1, -30)}, std::pair{16.0, std::ldexp(1, 12)}}) {
      const Vector2d there = drawer(s, m, 6, load);
      EXPECT_DOUBLE_EQ(there[0], here[0]) << load << ", " << s;
      EXPECT_DOUBLE_EQ(there[1], here[1]) << load << ", " << s;
    }
  }
}

/// A hinge that carries a slider that carries a hinge, and the pusher among them.
world::Scene chain_scene(double friction) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.3;
  scene.gravity = {0, 1, -9};
  const auto add = [&](const std::string& name, const std::string& parent, ObjectJoint joint, const Vector3d& axis, const Vector3d& at) {
    world::ObjectSpec o = on_joint(joint, axis, friction);
    o.name = name;
    o.parent = parent;
    o.mass = 0.3;
    o.inertia = 1e-3 * Eigen::Matrix3d::Identity();
    o.p_BCom = {0, 0.02, 0.01};
    o.X_WP.p = at;
    o.geometries[0].shape = world::Sphere{0.05};
    o.geometries[0].friction = 0.5;
    scene.objects.push_back(o);
  };
  add("flap", "", ObjectJoint::Hinge, {1, 0, 0}, {0, 0, 0.2});
  add("bolt", "flap", ObjectJoint::Slider, {0, 1, 0}, {0, 0.12, 0});
  add("knob", "bolt", ObjectJoint::Hinge, {1, 0, 0}, {0, 0.05, 0.12});
  scene.robots.push_back(pusher(0.5));
  return scene;
}

TEST(JointFriction, RandomStates_ForceIsTheFrictionOfWhatSlidesAndLessOfWhatSticks) {
  Stepper system(chain_scene(0.2));
  const Model& model = *system.model;
  core::Random random(11, 0);
  int sliding = 0, sticking = 0, solved = 0;
  for (int attempt = 0; attempt < 300; ++attempt) {
    VectorXd q(5);
    q << 0.3 * random.normal(), 0.02 * random.normal(), 0.5 * random.normal(), 0.1 + 0.05 * random.normal(), 0.05 * random.normal();
    VectorXd u = q.tail(2);
    for (double& x : u) x += 0.05 * random.normal();
    StepOptions options{.joint_limits = false};
    options.with_A = options.with_B = attempt % 2 == 1;
    StepResult r;
    system.work.forget();
    if (step(model, {q, u}, options, system.work, r) != Status::Solved) continue;
    ++solved;
    EXPECT_LE(recompute(model, q, u, options, r).stationarity, 1e-7) << attempt;
    for (int v = 0; v < 3; ++v) {
      const double force = r.joint_friction[v];
      EXPECT_LE(std::abs(force), 0.2);
      EXPECT_LE(force * r.delta[v], 1e-12) << attempt;
      if (std::abs(r.delta[v]) > 1e-4) {
        EXPECT_NEAR(std::abs(force), 0.2, options.with_A ? 1e-3 : 1e-5) << attempt;
        ++sliding;
      } else if (std::abs(force) < 0.19) {
        EXPECT_LE(std::abs(r.delta[v]), 1e-6) << attempt;
        ++sticking;
      }
    }
  }
  EXPECT_GT(solved, 290);
  EXPECT_GT(sliding, 50);
  EXPECT_GT(sticking, 50);
}

TEST(JointFriction, AfterFirstCalls_AllocatesNothing) {
  Stepper system(chain_scene(0.2));
  StepResult r;
  long counted = 0;
  for (int round = 0; round < 2; ++round) {
    core::Random random(12, 0);
    for (int attempt = 0; attempt < 30; ++attempt) {
      VectorXd q(5);
      q << 0.2 * random.normal(), 0, 0.3 * random.normal(), 0.1 + 0.03 * random.normal(), 0.03 * random.normal();
      VectorXd u = q.tail(2);
      for (double& x : u) x += 0.05 * random.normal();
      const StepOptions options{.with_B = true, .with_A = true};
      const long before = bench::allocations();
      (void)step(*system.model, {q, u}, options, system.work, r);
      if (round == 1) counted += bench::allocations() - before;
    }
  }
  EXPECT_EQ(counted, 0);
}

}  // namespace
}  // namespace stiction::dynamics::test
