#include <numbers>

#include "dynamics/systems.hpp"
#include "stiction/dynamics/local_model.hpp"
#include "support/message_of.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using world::Model;

constexpr double kMu = 0.5, kMass = 2.0, kRadius = 0.1;

/// A ball on the ground z = 0 that is too stiff to roll: rotations are damped by 1e6 N·m·s/rad.
struct StiffBall {
  StiffBall() {
    world::Scene scene = empty_scene();
    scene.gravity = {0, 0, -kGravity};
    scene.contact_distance = 0.05;
    scene.objects.push_back(ball(world::ObjectJoint::Free, kMass, kRadius, kMu));
    scene.fixed.push_back(half_space(Vector3d::UnitZ(), Vector3d::Zero(), kMu));
    model = Model::make(scene);
    q = model->neutral();
    q[2] = kRadius;
    damping.setZero(6);
    damping.tail<3>().setConstant(1e6);
  }

  /// One step under a horizontal force of the given size that friction at `angle` from t1 of the contact opposes.
  StepResult push(double force, double angle, const StepOptions& options) const {
    StepWorkspace work(model);
    StepResult r;
    EXPECT_EQ(step(*model, {q, Eigen::VectorXd(0)}, options, work, r), Status::Solved);
    const auto& c = r.contacts.at(0).contact;
    Eigen::VectorXd tau = Eigen::VectorXd::Zero(6);
    tau.head<3>() = -force * (std::cos(angle) * c.t1_W + std::sin(angle) * c.t2_W);
    EXPECT_EQ(step(*model, {q, Eigen::VectorXd(0), &tau, &damping}, options, work, r), Status::Solved);
    return r;
  }

  std::shared_ptr<const Model> model;
  Eigen::VectorXd q, damping;
};

TEST(PolyhedralFriction, ForceBetweenTwoRays_SlidesAboveThePyramidNotTheCone) {
  const StiffBall system;
  const double weight = kMass * kGravity;
  for (const int rays : {3, 4, 6, 16}) {
    for (const double share : {0.0, 0.25, 0.5}) {
      const double angle = 2 * std::numbers::pi * share / rays;
      // boundary of the regular polygon with corners at μN d_k
      const double half = std::numbers::pi / rays;
      const double limit = kMu * weight * std::cos(half) / std::cos(angle - half);
      const StepOptions options{.regularisation = FixedEpsilon{1}, .friction_cone = PolyhedralCone{rays}};
      EXPECT_LT(system.push(0.98 * limit, angle, options).contacts[0].slide(), 1e-6) << rays << " rays, " << share;
      const auto r = system.push(1.02 * limit, angle, options);
      EXPECT_GT(r.contacts[0].slide(), 1e-5) << rays << " rays, " << share;
      // Anitescu's gap lifts the ball, which takes m δz/h² more than the weight
      EXPECT_NEAR(r.contacts[0].lambda[0] / options.h, weight + kMass * r.delta[2] / (options.h * options.h), 1e-6 * weight);
      EXPECT_NEAR(r.contacts[0].anitescu_gap(), r.delta[2], 1e-9);
    }
  }
}

TEST(PolyhedralFriction, ManyRays_GoToTheConeAsOneOverRaysSquared) {
  const StiffBall system;
  StepOptions options{.regularisation = FixedEpsilon{1}};
  const double force = 1.5 * kMu * kMass * kGravity;
  // halfway between two rays, where pyramid and cone are farthest apart: 1 − cos(π/n) of the friction force
  const auto error = [&](int rays) {
    options.friction_cone = PolyhedralCone{rays};
    const double angle = std::numbers::pi / rays;
    const Vector3d polyhedral = system.push(force, angle, options).delta.head<3>();
    options.friction_cone = SecondOrderCone{};
    return (polyhedral - system.push(force, angle, options).delta.head<3>()).norm();
  };
  const double coarse = error(8), fine = error(16), finest = error(32);
  EXPECT_GT(coarse, 1e-5);
  EXPECT_NEAR(coarse / fine, 4, 0.2);
  EXPECT_NEAR(fine / finest, 4, 0.2);
}

/// The ball of allegro_ball in the fingers of the hand.
Eigen::VectorXd grasped_ball(const Model& model) {
  Eigen::VectorXd q = model.neutral();
  q.head<3>() << -0.081, 0.001, 0.071;
  q.tail(16) << 0.035, 0.753, 0.741, 0.833, -0.144, 0.747, 0.619, 0.701, -0.069, 0.785, 0.829, 0.904, 0.633, 1.024, 0.641, 0.824;
  return q;
}

/// Optimality of (2.10) recomputed from contacts and impulses: λ = Σ β_k (n + μ d_k) with β ≥ 0 means that λ lies in the pyramid.
TEST(PolyhedralFriction, RandomHandStates_ImpulsesLieInThePyramidAndBalance) {
  const auto model = load_task("allegro_ball");
  StepWorkspace work(model);
  core::Random random(3, 0);
  constexpr int kRays = 6;
  const StepOptions options{.friction_cone = PolyhedralCone{kRays}, .joint_limits = false};
  int loaded = 0;
  for (int sample = 0; sample < 100; ++sample) {
    const Eigen::VectorXd q = grasped_ball(*model);
    Eigen::VectorXd u = q.tail(16);
    for (int j = 0; j < 16; ++j) u[j] += 0.1 * random.normal();
    StepResult r;
    ASSERT_EQ(step(*model, {q, u}, options, work, r), Status::Solved);
    for (const auto& c : r.contacts) {
      const double mu = c.contact.friction, apothem = mu * std::cos(std::numbers::pi / kRays);
      for (int k = 0; k < kRays; ++k) {  // outward normals of the pyramid's faces
        const double angle = (2 * k + 1) * std::numbers::pi / kRays;
        EXPECT_LE(std::cos(angle) * c.lambda[1] + std::sin(angle) * c.lambda[2], apothem * c.lambda[0] + 1e-8);
        const double ray = 2 * k * std::numbers::pi / kRays;
        const double row = c.contact.phi + c.displacement[0] + mu * (std::cos(ray) * c.displacement[1] + std::sin(ray) * c.displacement[2]);
        EXPECT_GE(row, -1e-9);
      }
      loaded += c.active ? 1 : 0;
      EXPECT_LT(c.lambda.dot(c.displacement + Vector3d(c.contact.phi, 0, 0)), 1e-8);
    }
  }
  EXPECT_GT(loaded, 100);
}

TEST(CoulombFriction, PushedBall_SlidesClosedByTheForceThatFrictionLeaves) {
  const StiffBall system;
  const StepOptions options{.regularisation = FixedEpsilon{1}, .friction_law = FrictionLaw::Coulomb};
  const double weight = kMass * kGravity, h = options.h;
  for (const double angle : {0.0, 0.7, 2.5}) {
    for (const double force : {0.5 * kMu * weight, 1.01 * kMu * weight, 1.5 * kMu * weight, 4 * kMu * weight}) {
      const auto r = system.push(force, angle, options);
      const auto& c = r.contacts.at(0);
      const double slip = std::max(0.0, force - kMu * weight) * h * h / kMass;
      EXPECT_NEAR(c.slide(), slip, 1e-6 + 2e-2 * slip) << force;
      EXPECT_NEAR(c.anitescu_gap(), 0, 1e-6 + 2e-2 * slip) << force;
      EXPECT_NEAR(c.lambda[0] / h, weight, 1e-3 * weight) << force;
      EXPECT_NEAR(c.lambda[1] / h, std::min(force, kMu * weight) * std::cos(angle), 1e-3 * weight);
      EXPECT_NEAR(c.lambda[2] / h, std::min(force, kMu * weight) * std::sin(angle), 1e-3 * weight);
    }
  }
}

/// Signorini's and Coulomb's laws from contacts and impulses: closed where there is force, force within the cone, and against the slip at its edge.
TEST(CoulombFriction, RandomHandStates_ObeyTheLawOrAreAnitescus) {
  const auto model = load_task("allegro_ball");
  StepWorkspace work(model);
  core::Random random(3, 0);
  const StepOptions options{.friction_law = FrictionLaw::Coulomb}, relaxed{.warm_start = false};
  int sliding = 0, relaxed_steps = 0;
  for (int sample = 0; sample < 100; ++sample) {
    const Eigen::VectorXd q = grasped_ball(*model);
    Eigen::VectorXd u = q.tail(16);
    for (int j = 0; j < 16; ++j) u[j] += 0.1 * random.normal();
    StepResult r, anitescu;
    ASSERT_EQ(step(*model, {q, u}, options, work, r), Status::Solved);
    ASSERT_EQ(step(*model, {q, u}, relaxed, work, anitescu), Status::Solved);
    if (r.delta == anitescu.delta) {
      ++relaxed_steps;
      continue;
    }
    for (const auto& c : r.contacts) {
      const double mu = c.contact.friction;
      EXPECT_GE(c.anitescu_gap(), -3e-4);
      EXPECT_LE(c.lambda.tail<2>().norm(), mu * c.lambda[0] + 1e-8);
      if (!c.active) continue;
      EXPECT_LE(c.anitescu_gap(), 3e-4);
      if (c.slide() < 1e-3) continue;
      ++sliding;
      EXPECT_LE(c.lambda.tail<2>().dot(c.displacement.tail<2>()), -0.99 * mu * c.lambda[0] * c.slide() + 1e-9);
    }
    StepResult again;
    ASSERT_EQ(step(*model, {q, u}, options, work, again), Status::Solved);
    EXPECT_EQ(again.delta, r.delta) << "what the workspace saw before must not count";
  }
  EXPECT_GT(sliding, 50);
  EXPECT_LT(relaxed_steps, 20);
}

TEST(CoulombFriction, SmoothedStepsAndLocalModels_AreAnitescus) {
  const StiffBall system;
  StepWorkspace work(system.model);
  Eigen::VectorXd tau = Eigen::VectorXd::Zero(6);
  tau[0] = 2 * kMu * kMass * kGravity;
  const StepInput in{system.q, Eigen::VectorXd(0), &tau, &system.damping};
  StepResult relaxed, r;
  for (const Smoothing& smoothing : {Smoothing(Analytic{100}), Smoothing(Exact{})}) {
    const StepOptions options{.smoothing = smoothing, .friction_law = FrictionLaw::Coulomb};
    ASSERT_EQ(step(*system.model, in, options, work, r), Status::Solved);
    work.forget();
    ASSERT_EQ(step(*system.model, in, {.smoothing = smoothing}, work, relaxed), Status::Solved);
    EXPECT_EQ((r.delta - relaxed.delta).norm() < 1e-6, !std::holds_alternative<Exact>(smoothing));
  }
  LocalModelWorkspace models(system.model);
  LocalModel model;
  ASSERT_EQ(calc_local_model(*system.model, in, Exact{}, {.friction_law = FrictionLaw::Coulomb}, false, models, model), Status::Solved);
  EXPECT_LT((model.c - relaxed.q_next).norm(), 1e-6);
}

TEST(CoulombFriction, PyramidsAndPlanarModels_AreRefused) {
  const StiffBall system;
  StepWorkspace work(system.model);
  StepResult r;
  const StepOptions options{.friction_cone = PolyhedralCone{4}, .friction_law = FrictionLaw::Coulomb};
  const auto message = stiction::test::message_of([&] { (void)step(*system.model, {system.q, Eigen::VectorXd(0)}, options, work, r); });
  EXPECT_NE(message.find("friction_law"), std::string::npos) << message;
  const auto planar = load_task("planar_hand");
  StepWorkspace planar_work(planar);
  EXPECT_NE(stiction::test::message_of([&] {
              (void)step(*planar, {planar->neutral(), Eigen::VectorXd::Zero(planar->n_a())}, {.friction_law = FrictionLaw::Coulomb},
                         planar_work, r);
            }).find("friction_law"),
            std::string::npos);
}

TEST(Damping, FreeBall_MovesByForceOverMassAndDamping) {
  const StiffBall system;
  Eigen::VectorXd q = system.q, tau = Eigen::VectorXd::Zero(6), damping = Eigen::VectorXd::Constant(6, 3.0);
  q[2] = 10;
  tau << 1, 2, kMass * kGravity, 0, 0, 0.1;
  const StepOptions options{.h = 0.05, .regularisation = FixedEpsilon{1}};
  StepWorkspace work(system.model);
  StepResult r;
  ASSERT_EQ(step(*system.model, {q, Eigen::VectorXd(0), &tau, &damping}, options, work, r), Status::Solved);
  EXPECT_NEAR(r.delta[0], 0.05 * 1 / (kMass / 0.05 + 3), 1e-12);
  EXPECT_NEAR(r.delta[5], 0.05 * 0.1 / (0.4 * kMass * kRadius * kRadius / 0.05 + 3), 1e-12);
  damping[2] = -1;
  EXPECT_NE(stiction::test::message_of([&] {
              (void)step(*system.model, {q, Eigen::VectorXd(0), &tau, &damping}, options, work, r);
            }).find("damping"),
            std::string::npos);
}

// A ball that is pushed with nine tenths of what friction holds stays with all of μ and slides with eight tenths, from the same state, whatever came before.
TEST(FrictionFactors, Ball_SlidesWhereItsPairHasLess) {
  const StiffBall system;
  Eigen::VectorXd tau = Eigen::VectorXd::Zero(6), factors = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(system.model->pairs().size()));
  tau[0] = 0.9 * kMu * kMass * kGravity;
  StepWorkspace work(system.model);
  StepResult r;
  const auto slide = [&](const Eigen::VectorXd* friction) {
    EXPECT_EQ(
        step(*system.model, {system.q, Eigen::VectorXd(0), &tau, &system.damping, friction}, {.regularisation = FixedEpsilon{1}}, work, r),
        Status::Solved);
    return r.contacts[0].slide();
  };
  for (int k = 0; k < 2; ++k) {
    factors[0] = 1;
    EXPECT_LT(slide(&factors), 1e-6);
    factors[0] = 0.8;
    EXPECT_GT(slide(&factors), 1e-5);
    EXPECT_NEAR(r.contacts[0].lambda.tail<2>().norm(), 0.8 * kMu * r.contacts[0].lambda[0], 1e-8) << "on the smaller cone";
    EXPECT_LT(slide(nullptr), 1e-6);
  }
  factors[0] = -1;
  EXPECT_NE(stiction::test::message_of([&] { (void)slide(&factors); }).find("friction"), std::string::npos);
  factors.resize(2);
  EXPECT_NE(stiction::test::message_of([&] { (void)slide(&factors); }).find("friction"), std::string::npos);
}

TEST(Wrench, BallOnGround_CarriesWeightThroughTheContactPoint) {
  const StiffBall system;
  Eigen::VectorXd q = system.q;
  q[0] = 0.3;
  StepWorkspace work(system.model);
  StepResult r;
  const StepOptions options{};
  ASSERT_EQ(step(*system.model, {q, Eigen::VectorXd(0)}, options, work, r), Status::Solved);
  const auto wrench = calc_wrench(r.contacts.at(0), options.h);
  const Vector3d weight(0, 0, kMass * kGravity);
  EXPECT_LT((wrench.head<3>() - weight).norm(), 1e-5);
  EXPECT_LT((wrench.tail<3>() - Vector3d(0.3, 0, 0).cross(weight)).norm(), 1e-5);
}

TEST(PolyhedralFriction, TwoRays_AreRefused) {
  const StiffBall system;
  EXPECT_NE(stiction::test::message_of([&] { StepOptions{.friction_cone = PolyhedralCone{2}}.validate(); }).find("friction_cone.rays"),
            std::string::npos);
}

}  // namespace
}  // namespace stiction::dynamics::test
