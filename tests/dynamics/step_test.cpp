#include "stiction/dynamics/step.hpp"

#include <limits>

#include "cone_allocations.hpp"
#include "dynamics/optimality.hpp"
#include "dynamics/systems.hpp"
#include "stiction/core/invalid_input.hpp"
#include "support/message_of.hpp"

namespace stiction::dynamics::test {
namespace {

using stiction::test::message_of;

using core::Status;
using world::Model;

/// The pusher (K = 100 N/m) before a wall: its ball touches at z = 0.
world::Scene wall_scene(double friction = 0) {
  world::Scene scene = empty_scene();
  scene.robots.push_back(pusher(friction));
  scene.fixed.push_back(half_space(Eigen::Vector3d::UnitZ(), {0, 0, -0.1}, friction));
  return scene;
}

TEST(Step, NoContact_RobotGoesWhereCommandedAndObjectStays) {
  Stepper system(world::load_scene(source_dir() / "tasks" / "planar_pushing.yaml"));
  Eigen::VectorXd q(5), u(2);
  q << 0, 2, 0, 0.3, -0.4;
  u << 0.35, -0.45;
  const auto r = system(q, u, {.with_B = true});
  EXPECT_NEAR((r.q_next.tail(2) - u).norm(), 0, 1e-9);
  EXPECT_LT((r.q_next.head(3) - q.head(3)).norm(), 1e-8);  // the box is 1.3 m away on the central path at σ ≈ 1e-10
  EXPECT_NEAR((r.B.bottomRows(2) - Eigen::Matrix2d::Identity()).norm(), 0, 1e-9);
  EXPECT_NEAR(r.B.topRows(3).norm(), 0, 1e-6);
}

TEST(Step, SpringAgainstWall_StopsAtWallWithSpringForce) {
  Stepper system(wall_scene());
  const auto r = system(Eigen::Vector2d(0, 0.01), Eigen::Vector2d(0, -0.05), {.h = 0.1});
  EXPECT_NEAR(r.q_next[1], 0, 1e-7);
  ASSERT_EQ(r.contacts.size(), 1u);
  EXPECT_NEAR(r.contacts[0].lambda[0] / 0.1, 100 * 0.05, 1e-4);  // force = K · 50 mm
}

/// (2.34) corrected: stationarity k(q⁺ − u) = 2/(κ q⁺) of a contact whose barrier has degree 2 in total; the published
/// q⁺ = (u + √(u² + a))/2 then has a = 4·2/(κk) in the weights used here.
TEST(Step, SpringAgainstWallSmoothed_MatchesClosedForm) {
  Stepper system(wall_scene());
  const double k = 100;
  for (const double kappa : {1.0, 100.0, 1e4}) {
    for (const double u : {-0.05, 0.0, 0.02, 0.3}) {
      for (const double h : {0.01, 0.1, 1.0}) {
        const auto r = system(Eigen::Vector2d(0, 0.01), Eigen::Vector2d(0, u), {.h = h, .smoothing = Analytic{kappa, 1.0}});
        const double expected = 0.5 * (u + std::sqrt(u * u + 8 / (kappa * k)));
        EXPECT_NEAR(r.q_next[1], expected, 1e-9 * (1 + expected)) << "kappa " << kappa << " u " << u << " h " << h;
      }
    }
  }
}

TEST(Step, SmoothedContact_WorkOfForceOverGapIsTwoOverKappa) {
  Stepper system(wall_scene(0.7));
  const auto r = system(Eigen::Vector2d(0, 0.01), Eigen::Vector2d(0.01, -0.05), {.h = 0.1, .smoothing = Analytic{100, 1}});
  const auto& c = r.contacts.at(0);
  const Eigen::Vector3d v = c.displacement + Eigen::Vector3d(c.contact.phi, 0, 0);
  EXPECT_NEAR(v.dot(c.lambda) / 0.1, 2.0 / 100, 1e-9);  // vᵀλ/h = θ/κ with θ = 2, not the printed 1/κ
}

TEST(Step, KappaGrows_SmoothedGoesToExactAtRateOneOverKappa) {
  Stepper system(wall_scene());
  const Eigen::Vector2d q(0, 0.01), u(0, -0.05);
  const double exact = system(q, u, {}).q_next[1];
  double last = 0;
  for (const double kappa : {1e3, 1e4, 1e5}) {
    const double error = system(q, u, {.smoothing = Analytic{kappa, 1}}).q_next[1] - exact;
    if (last > 0) {
      EXPECT_NEAR(last / error, 10, 0.2);
    }
    last = error;
  }
}

TEST(Step, BallOnGround_GroundCarriesItsWeight) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 0, -9.81};
  scene.robots.push_back(pusher());
  scene.robots[0].X_WBase.p = {0, 3, 3};
  scene.objects.push_back(ball(world::ObjectJoint::Free, 2.0, 0.05, 0.8));
  scene.fixed.push_back(half_space(Eigen::Vector3d::UnitZ(), {0, 0, 0}, 0.8));
  Stepper system(scene);
  Eigen::VectorXd q = system.model->neutral();
  q[2] = 0.05;
  Eigen::VectorXd moved = q;
  for (int i = 0; i < 1000; ++i) {
    const auto r = system(moved, Eigen::Vector2d(0, 0), {.h = 0.1});
    double weight = 0;
    for (const auto& c : r.contacts) weight += c.lambda[0] / 0.1;
    ASSERT_NEAR(weight, 2.0 * 9.81, 1e-5);
    moved = r.q_next;
  }
  EXPECT_LT((moved - q).cwiseAbs().maxCoeff(), 1e-6);  // it neither sinks nor creeps: < 1e-9 m per step
}

/// Anitescu's relaxation (2.3.4): a ball dragged along a wall lifts off by μ times its slip, so the gap vanishes with the step.
TEST(Step, SlidingContact_OpensGapOfFrictionTimesSlip) {
  for (const double mu : {0.2, 0.5, 1.0}) {
    Stepper system(wall_scene(mu));
    double u_y = 0.02;
    for (int halving = 0; halving < 4; ++halving, u_y *= 0.5) {
      const auto r = system(Eigen::Vector2d(0, 0), Eigen::Vector2d(u_y, -1e-4 * u_y), {.h = 0.1});
      const auto& c = r.contacts.at(0);
      ASSERT_TRUE(c.active) << "not in contact: the test would say nothing";
      EXPECT_NEAR(r.q_next[1], mu * c.slide(), 1e-7);
      EXPECT_GT(c.slide(), 0.3 * u_y);
    }
  }
}

/// Coulomb: the tangential spring force sticks below μ times the normal one and slides above.
TEST(Step, TangentialLoad_SticksBelowConeAndSlidesAbove) {
  const double mu = 0.5, push = 0.01;
  Stepper system(wall_scene(mu));
  for (const double ratio : {0.2, 0.9, 0.999}) {
    const auto r = system(Eigen::Vector2d(0, 0), Eigen::Vector2d(ratio * mu * push, -push), {});
    // complementarity to 1e-9 J·s: the slip times what the friction force could still grow by [N·s] is at most that
    const double reserve = (1 - ratio) * mu * push * 100 * 0.1;
    EXPECT_LT(r.contacts.at(0).slide(), 1e-9 / reserve) << ratio;
  }
  for (const double ratio : {1.1, 3.0}) {
    const auto r = system(Eigen::Vector2d(0, 0), Eigen::Vector2d(ratio * mu * push, -push), {});
    const auto& c = r.contacts.at(0);
    EXPECT_GT(c.slide(), 1e-5) << ratio;
    EXPECT_NEAR(std::abs(c.lambda[1]), mu * c.lambda[0], 1e-5);
  }
}

TEST(Step, FrictionScaleZero_NoTangentialForce) {
  Stepper system(wall_scene(0.9));
  const auto r = system(Eigen::Vector2d(0, 0), Eigen::Vector2d(0.02, -0.02), {.friction_scale = 0});
  EXPECT_EQ(r.contacts.at(0).lambda[1], 0);
  EXPECT_NEAR(r.q_next[0], 0.02, 1e-7);
}

TEST(Step, ObjectRegularisation_FollowsRuleAndIsReported) {
  Stepper system(world::load_scene(source_dir() / "tasks" / "planar_pushing.yaml"));
  Eigen::VectorXd q(5), u(2);
  q << 0, 0.5, 0, 0, -0.1;
  u << 0, 0;
  // ε m/h = 0.1 h K with m = 5 kg and K = 100 N/m
  EXPECT_NEAR(system(q, u, {.h = 0.1}).epsilon[0], 0.1 * 0.1 * 0.1 * 100 / 5, 1e-15);
  EXPECT_EQ(system(q, u, {.regularisation = FixedEpsilon{1.0}}).epsilon[0], 1.0);
  // with the rule the increment does not depend on h
  u[1] = 0.05;
  const Eigen::VectorXd a = system(q, u, {.h = 0.1}).delta, b = system(q, u, {.h = 0.01}).delta;
  EXPECT_LT((a - b).norm(), 1e-6);
  EXPECT_GT(a.norm(), 0.01);
}

TEST(Step, JointLimits_HoldAndPushBack) {
  Stepper system(world::load_scene(source_dir() / "tasks" / "allegro_ball.yaml"));
  const Model& model = *system.model;
  Eigen::VectorXd q = model.neutral();
  q.head<3>() << 1, 1, 1;
  StepOptions options{.regularisation = FixedEpsilon{100}};
  const Eigen::VectorXd beyond = model.upper().array() + 0.5;
  const auto r = system(q, beyond, options);
  EXPECT_LE((r.q_next.tail(16) - model.upper()).maxCoeff(), 1e-8);
  options.joint_limits = false;
  EXPECT_GT((system(q, beyond, options).q_next.tail(16) - model.upper()).maxCoeff(), 0.1);
}

/// The rows that an exact step leaves out at first must not change its result: optimality over all contacts of random grasps.
TEST(Step, RandomStates_OptimalityHoldsOverAllContacts) {
  for (const char* task : {"planar_pushing", "planar_hand", "allegro_ball"}) {
    Stepper system(world::load_scene(source_dir() / "tasks" / (std::string(task) + ".yaml")));
    const Model& model = *system.model;
    core::Random random(5, 0);
    int in_contact = 0;
    for (int sample = 0; sample < 300; ++sample) {
      Eigen::VectorXd q = model.neutral();
      for (int j = 0; j < model.n_a(); ++j) {
        const double low = std::max(model.lower()[j], -0.6), high = std::min(model.upper()[j], 1.0);
        q[model.n_qu() + j] = random.uniform(low, high);
      }
      if (std::string(task) == "allegro_ball") q.head<3>() << -0.081, 0.001, 0.071;
      if (std::string(task) == "planar_hand") q[1] = 0.35;
      if (std::string(task) == "planar_pushing") q[1] = 0.5;
      Eigen::VectorXd u = q.tail(model.n_a());
      for (Eigen::Index j = 0; j < u.size(); ++j) u[j] += 0.1 * random.normal();
      StepResult r;
      const StepOptions options{.joint_limits = false};  // limits carry forces that are not in the contact list
      const Status status = step(model, {q, u}, options, system.work, r);
      if (status == Status::Infeasible) continue;  // deep interpenetration of the fingers
      ASSERT_EQ(status, Status::Solved);
      const Optimality o = recompute(model, q, u, options, r);
      EXPECT_LT(o.stationarity, 2e-8);
      EXPECT_LT(o.primal, 1e-8);
      EXPECT_LT(o.dual, 1e-8);
      EXPECT_LT(o.complementarity, 1e-8);
      for (const auto& c : r.contacts) in_contact += c.active ? 1 : 0;
    }
    EXPECT_GT(in_contact, 30) << task << ": too few contacts, the test says nothing";
  }
}

TEST(Step, SmoothedLargeCommands_EveryContactStaysOpenWhetherItsRowWasInOrNot) {
  Stepper system(world::load_scene(source_dir() / "tasks" / "allegro_ball_table_3_2.yaml"));
  const Model& model = *system.model;
  core::Random random(6, 0);
  int left_out = 0, pushed_by_self = 0;
  for (int sample = 0; sample < 300; ++sample) {
    Eigen::VectorXd q = model.neutral();
    q.head<3>() << -0.081, 0.001, 0.071;
    q.tail(16) << 0.035, 0.753, 0.741, 0.833, -0.144, 0.747, 0.619, 0.701, -0.069, 0.785, 0.829, 0.904, 0.633, 1.024, 0.641, 0.824;
    for (int j = 0; j < model.n_a(); ++j) q[model.n_qu() + j] += random.uniform(-0.1, 0.1);
    Eigen::VectorXd u = q.tail(model.n_a());
    for (Eigen::Index j = 0; j < u.size(); ++j) u[j] += 0.3 * random.normal();
    StepResult r;
    const Status status = step(model, {q, u}, {.smoothing = Analytic{}}, system.work, r);
    if (status != Status::Solved) continue;
    for (const auto& c : r.contacts) {
      EXPECT_GE(c.gap, 0.0);
      const auto& pair = model.pairs()[static_cast<std::size_t>(c.contact.pair)];
      const auto kind = [&](int g) {
        return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(g)].body)].kind;
      };
      const bool self = kind(pair.geometry_a) == world::BodyKind::Robot && kind(pair.geometry_b) == world::BodyKind::Robot;
      left_out += c.lambda[0] == 0 ? 1 : 0;
      pushed_by_self += self && c.lambda[0] > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(left_out, 300);
  EXPECT_GT(pushed_by_self, 300);
}

TEST(Step, DeepPenetration_ProjectsOut) {
  Stepper system(world::load_scene(source_dir() / "tasks" / "planar_pushing.yaml"));
  Eigen::VectorXd q(5), u(2);
  q << 0, 0.5, 0, 0, 0.0;  // the ball's centre lies on the face: 0.1 m deep
  u << 0, 0;
  const auto r = system(q, u, {});
  EXPECT_NEAR(r.contacts.at(0).contact.phi, -0.1, 1e-12);
  EXPECT_GT(r.contacts.at(0).gap, -1e-9);
  const auto again = system(r.q_next, r.q_next.tail(2), {});
  EXPECT_GT(again.contacts.at(0).contact.phi, -1e-6);
}

/// The pusher's ball slides along y and z beside a wall across x, into which it reaches: nothing can change that, and no force acts across it.
TEST(Step, OverlapThatNoJointCanUndo_StandsInNoWay) {
  for (const double overlap : {0.0, 1e-12, 1e-9, 1e-6, 1e-3, 0.05}) {
    for (const double friction : {0.0, 1.0}) {
      world::Scene scene = empty_scene();
      scene.robots.push_back(pusher(friction));
      scene.fixed.push_back(half_space(Eigen::Vector3d::UnitX(), {-0.1 + overlap, 0, 0}, friction));
      const auto model = world::Model::make(scene);
      StepWorkspace work(model);
      StepResult r;
      const Eigen::Vector2d q(0, 0), u(0.1, -0.2);
      ASSERT_EQ(step(*model, {q, u}, {}, work, r), Status::Solved) << overlap;
      EXPECT_NEAR((r.q_next - u).norm(), 0, 1e-9) << overlap << " " << friction;
      EXPECT_TRUE(r.contacts.empty());
    }
  }
}

TEST(Step, WarmStart_GivesTheResultOfAColdOne) {
  Stepper warm(world::load_scene(source_dir() / "tasks" / "allegro_ball.yaml"));
  Stepper cold(world::load_scene(source_dir() / "tasks" / "allegro_ball.yaml"));
  const Model& model = *warm.model;
  Eigen::VectorXd q = model.neutral();
  q.head<3>() << -0.081, 0.001, 0.071;
  core::Random random(8, 0);
  Eigen::VectorXd u = q.tail(16);
  for (int i = 0; i < 60; ++i) {
    for (int j = 0; j < 16; ++j) u[j] = std::clamp(u[j] + 0.03 * random.uniform(), model.lower()[j], model.upper()[j]);
    const auto a = warm(q, u, {});
    cold.work.forget();
    const auto b = cold(q, u, {.warm_start = false});
    // complementarity 1e-9 J·s leaves √(1e-9/(εm/h)) of freedom in a soft direction of the object
    EXPECT_LT((a.delta - b.delta).cwiseAbs().maxCoeff(), 5e-5);
    q = a.q_next;
  }
}

TEST(Step, SameInput_SameBits) {
  Stepper a(world::load_scene(source_dir() / "tasks" / "allegro_ball.yaml")),
      b(world::load_scene(source_dir() / "tasks" / "allegro_ball.yaml"));
  Eigen::VectorXd q = a.model->neutral();
  q.head<3>() << -0.081, 0.001, 0.071;
  const Eigen::VectorXd u = q.tail(16).array() + 0.05;
  b(q, q.tail(16), {});  // a different history, forgotten
  b.work.forget();
  EXPECT_EQ(a(q, u, {}).q_next, b(q, u, {}).q_next);
}

TEST(Step, AfterFirstCalls_AllocatesNothing) {
  if (!bench::counts_allocations()) GTEST_SKIP() << "mallocs are not counted under sanitizers";
  ASSERT_GT(bench::allocations(), 0) << "the counter does not count";
  Stepper system(world::load_scene(source_dir() / "tasks" / "allegro_ball.yaml"));
  Eigen::VectorXd q = system.model->neutral();
  q.head<3>() << -0.081, 0.001, 0.071;
  const Eigen::VectorXd u = q.tail(16).array() + 0.02;
  StepResult out;
  for (const bool smooth : {false, true}) {
    StepOptions options{.with_B = smooth};
    if (smooth) options.smoothing = Analytic{};
    for (int i = 0; i < 3; ++i) (void)step(*system.model, {q, u}, options, system.work, out);
    const long before = bench::allocations();
    for (int i = 0; i < 20; ++i) (void)step(*system.model, {q, u}, options, system.work, out);
    EXPECT_EQ(bench::allocations() - before, 0) << (smooth ? "smoothed" : "exact");
    options.with_A = options.with_B = options.with_force_derivatives = true;
    for (int i = 0; i < 3; ++i) (void)step(*system.model, {q, u}, options, system.work, out);
    const long before_A = bench::allocations();
    for (int i = 0; i < 20; ++i) (void)step(*system.model, {q, u}, options, system.work, out);
    EXPECT_EQ(bench::allocations() - before_A, 0) << (smooth ? "smoothed, with A" : "exact, with A");
  }
}

/// A plate on 100 balls, more contacts than a workspace is made for.
TEST(Step, MoreContactsThanTheWorkspaceWasMadeFor_GrowsOnceAndSaysSo) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 0, -9.81};
  scene.contact_distance = 0.02;
  scene.fixed.push_back(half_space(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero(), 0.5));
  world::ObjectSpec plate = ball(world::ObjectJoint::Free, 1, 0.1, 0.5);
  plate.geometries.clear();
  for (int i = 0; i < 100; ++i) {
    plate.geometries.push_back({.name = "foot_" + std::to_string(i), .shape = world::Sphere{0.004}, .X_BG = {}, .friction = 0.5});
    plate.geometries.back().X_BG.p = Eigen::Vector3d(0.02 * (i % 10), 0.02 * (i / 10), 0);
  }
  scene.objects.push_back(plate);
  Stepper system(scene);
  Eigen::VectorXd q = system.model->neutral();
  q[2] = 0.004;
  const StepOptions options{.h = 0.01, .regularisation = FixedEpsilon{1}};
  const StepResult first = system(q, Eigen::VectorXd(0), options), second = system(q, Eigen::VectorXd(0), options);
  EXPECT_EQ(first.contacts.size(), 100u);
  EXPECT_GT(first.growths, 0);
  EXPECT_EQ(second.growths, 0);
  double force = 0;
  for (const auto& c : first.contacts) force += c.lambda[0] / options.h;
  EXPECT_NEAR(force, 9.81, 1e-4);
}

TEST(Step, BadInput_NamesFieldGivenAndExpected) {
  Stepper system(wall_scene());
  StepResult out;
  const auto run = [&](const Eigen::VectorXd& q, const Eigen::VectorXd& u, const StepOptions& options) {
    return message_of([&] { (void)step(*system.model, {q, u}, options, system.work, out); });
  };
  const Eigen::Vector2d ok(0, 0.1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(run(Eigen::Vector3d::Zero(), ok, {}), "q: got 3 numbers, expected 2");
  EXPECT_EQ(run(ok, Eigen::Vector3d::Zero(), {}), "u: got 3 numbers, expected 2");
  EXPECT_EQ(run(Eigen::Vector2d(0, nan), ok, {}), "q: got a number that is not finite, expected finite numbers");
  EXPECT_EQ(run(ok, Eigen::Vector2d(nan, 0), {}), "u: got a number that is not finite, expected finite numbers");
  EXPECT_EQ(run(ok, ok, {.h = 0}), "h: got 0, expected a finite number > 0");
  EXPECT_EQ(run(ok, ok, {.smoothing = Analytic{-1}}), "smoothing.kappa: got -1, expected a finite number > 0");
  EXPECT_EQ(run(ok, ok, {.regularisation = ByRule{0}}), "regularisation.ratio: got 0, expected a finite number > 0");
  EXPECT_EQ(run(ok, ok, {.friction_scale = -0.5}), "friction_scale: got -0.5, expected a finite number ≥ 0");
  EXPECT_EQ(message_of([] { StepWorkspace(world::Model::make(empty_scene())); }),
            "model: got nothing that moves, expected an object, or a robot with a joint that has a range");
  StepWorkspace other(Stepper(wall_scene()).model);  // of as many coordinates: nothing but its model tells it apart
  EXPECT_EQ(message_of([&] {
              (void)step(*system.model, {ok, ok}, {}, other, out);
            }),
            "work: got the workspace of another model, expected one made for this model");
}

}  // namespace
}  // namespace stiction::dynamics::test
