// Contacts that resist turning about their normal (S.26): the law of a single contact at three scales.
#include "dynamics/systems.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

constexpr double kMu = 0.5, kDensity = 1000;

/// A ball that rests on the ground. Its surface resists turning with a moment of `torsional` times the normal force.
struct Ball {
  explicit Ball(double radius) : weight(kDensity * 4 / 3 * M_PI * radius * radius * radius * kGravity), torsional(0.1 * radius) {
    world::Scene scene = empty_scene();
    scene.gravity = {0, 0, -kGravity};
    scene.contact_distance = radius / 2;
    scene.objects.push_back(ball(world::ObjectJoint::Free, weight / kGravity, radius, kMu));
    scene.objects[0].geometries[0].rule = {.dimension = 4, .torsional = torsional};
    scene.fixed.push_back(half_space(Vector3d::UnitZ(), Vector3d::Zero(), kMu));
    model = Model::make(scene);
    q = model->neutral();
    q[2] = radius;
  }

  /// One step under a moment about the normal.
  StepResult turn(double moment, const StepOptions& options) const {
    StepWorkspace work(model);
    StepResult r;
    VectorXd tau = VectorXd::Zero(6);
    tau[5] = moment;
    EXPECT_EQ(step(*model, {q, VectorXd(0), &tau}, options, work, r), Status::Solved);
    return r;
  }

  double weight, torsional;
  std::shared_ptr<const Model> model;
  VectorXd q;
};

/// Moment of all contacts about the vertical through the origin, on the object [N m].
double moment(const StepResult& r, double h) {
  double sum = 0;
  for (const ContactImpulse& c : r.contacts) sum += (c.contact.nhat_BA_W.z() > 0 ? 1 : -1) * calc_wrench(c, h)[5];
  return sum;
}

TEST(Turning, BallOnThePlane_TurnsBeyondTheLargestMoment) {
  for (const double radius : {0.005, 0.04, 0.5}) {
    const Ball ball(radius);
    ASSERT_EQ(ball.model->pairs().size(), 1u);
    const double largest = ball.torsional * ball.weight;
    for (const FrictionLaw law : {FrictionLaw::Anitescu, FrictionLaw::Coulomb}) {
      const StepOptions options{.regularisation = FixedEpsilon{1}, .friction_law = law};
      const StepResult sticks = ball.turn(0.95 * largest, options), turns = ball.turn(1.05 * largest, options);
      const double free_turn = options.h * options.h * 0.05 * largest / (0.4 * ball.weight / kGravity * radius * radius);
      EXPECT_EQ(sticks.contacts.size(), 2u);
      EXPECT_LT(std::abs(sticks.delta[5]), 1e-3 * free_turn) << radius;
      EXPECT_NEAR(moment(sticks, options.h), -0.95 * largest, 1e-4 * largest) << radius;
      EXPECT_GT(turns.delta[5], 0.1 * free_turn) << radius;
      if (law == FrictionLaw::Coulomb) {
        EXPECT_NEAR(turns.delta[5], free_turn, 0.02 * free_turn) << radius;
        EXPECT_NEAR(moment(turns, options.h), -largest, 1e-3 * largest) << radius;
      }
    }
  }
}

TEST(Turning, FactorsOfFriction_ScaleTheMoment) {
  const Ball ball(0.04);
  const StepOptions options{.regularisation = FixedEpsilon{1}, .friction_law = FrictionLaw::Coulomb, .friction_scale = 0.5};
  const double largest = ball.torsional * ball.weight;
  EXPECT_NEAR(moment(ball.turn(0.9 * largest, options), options.h), -0.5 * largest, 1e-3 * largest);
}

/// Friction of a contact that resists turning also resists rolling over it no more than a point does.
TEST(Turning, RollingBall_IsNotHeld) {
  const Ball ball(0.04);
  StepWorkspace work(ball.model);
  StepResult r;
  VectorXd tau = VectorXd::Zero(6);
  tau[4] = 0.01 * ball.torsional * ball.weight;
  ASSERT_EQ(step(*ball.model, {ball.q, VectorXd(0), &tau}, {.regularisation = FixedEpsilon{1}}, work, r), Status::Solved);
  const double inertia = 1.4 * ball.weight / kGravity * 0.04 * 0.04;  // about the point of contact
  EXPECT_NEAR(r.delta[4], 0.01 * tau[4] / inertia, 1e-3 * r.delta[4]);
}

}  // namespace
}  // namespace stiction::dynamics::test
