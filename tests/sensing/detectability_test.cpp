#include "stiction/sensing/detectability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sensing/robots.hpp"
#include "stiction/core/random.hpp"

namespace stiction::sensing::test {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

Vector3d random_unit(core::Random& random) { return Vector3d(random.normal(), random.normal(), random.normal()).normalized(); }

TEST(CapIntersection, Limits_AreThoseOfCaps) {
  const auto cap = [](double a) { return 2 * pi * (1 - std::cos(a)); };
  EXPECT_EQ(calc_cap_intersection(0.3, 0.4, 0.8), 0);                                      // apart
  EXPECT_DOUBLE_EQ(calc_cap_intersection(0.3, 1.0, 0.5), cap(0.3));                        // inside
  EXPECT_NEAR(calc_cap_intersection(pi / 2, pi / 2, 1.0), 2 * (pi - 1.0), 1e-12);          // a lune of half spheres
  EXPECT_NEAR(calc_cap_intersection(2.5, 2.8, 3.0), cap(2.5) + cap(2.8) - 4 * pi, 1e-12);  // together they cover the sphere
  EXPECT_NEAR(calc_cap_intersection(0.7, 0.9, 0.2 + 1e-9), cap(0.7), 1e-6);                // continuous where one leaves the other
}

TEST(Undetectability, ClosedForm_IsTheShareOfSampledForces) {
  core::Random random(1, 0);
  constexpr int kForces = 20000;
  for (int i = 0; i < 60; ++i) {
    const Vector3d k = random_unit(random), m = 0.2 * random.uniform() * random_unit(random);
    const double mu = 0.1 + 2 * random.uniform(), epsilon = 0.1 * random.uniform() + 1e-3;
    const double least = std::cos(std::atan(mu));
    const auto frame = make_contact_frame(-k);
    int small = 0;
    for (int s = 0; s < kForces; ++s) {  // uniform on the cap: cos θ uniform
      const double c = random.uniform(least, 1), angle = 2 * pi * random.uniform(), r = std::sqrt(1 - c * c);
      const Vector3d f = frame * Vector3d(c, r * std::cos(angle), r * std::sin(angle));
      small += std::abs(m.dot(f)) <= epsilon;
    }
    const double eta = calc_undetectability(m, k, mu, epsilon);
    EXPECT_NEAR(eta, static_cast<double>(small) / kForces, 4.5 * 0.5 / std::sqrt(kForces)) << "case " << i;
  }
}

TEST(Undetectability, OnTheAxis_IsOne) {
  EXPECT_EQ(calc_undetectability(Vector3d::Zero(), Vector3d::UnitX(), 1, 1e-6), 1);
  EXPECT_EQ(calc_undetectability({0, 0.1, 0}, Vector3d::UnitX(), 1, 0.11), 1);  // no unit force makes more than the lever
  EXPECT_EQ(calc_undetectability({0, 0.1, 0}, Vector3d::UnitY(), 0, 0.05), 0);  // without friction: one force
  EXPECT_EQ(calc_undetectability({0, 0.1, 0}, Vector3d::UnitX(), 0, 0.05), 1);
}

TEST(Detectability, SignsOfRays_SayWhetherTheProgramIsInfeasible) {
  core::Random random(2, 0);
  int full = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d k = random_unit(random), m = random_unit(random);
    const auto R = make_contact_frame(-k);
    const FrictionCone cone(0.3 + random.uniform(), 0), rays(cone.friction(), 4);
    const bool exact = classify(m, R, cone) == Detectability::Full, polyhedral = classify(m, R, rays) == Detectability::Full;
    EXPECT_TRUE(!exact || polyhedral) << "the polyhedral cone lies in the exact one";
    full += exact;
    // The least |m·f| over sampled unit forces of the exact cone.
    double least = 1, most = -1;
    for (int s = 0; s < 360; ++s) {
      const double angle = s * pi / 180;
      const double torque = m.dot(R * Vector3d(1, cone.friction() * std::cos(angle), cone.friction() * std::sin(angle)).normalized());
      least = std::min(least, torque);
      most = std::max(most, torque);
    }
    if (std::min(std::abs(least), std::abs(most)) > 1e-3) {
      EXPECT_EQ(exact, least * most > 0) << "case " << i;
    }
  }
  EXPECT_GT(full, 200);
}

TEST(JointLine, OfAWeldedLink_IsThatOfTheJointBeforeIt) {
  const auto model = make_robot(R"(<robot name="r"><link name="base"/><link name="arm"/><link name="tool"/>
<joint name="j" type="prismatic"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/><limit lower="0" upper="1" effort="1" velocity="1"/></joint>
<joint name="w" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0.3 0 0" rpy="0 0 1.5707963267948966"/></joint></robot>)");
  const JointLine line = find_joint_line(*model, body_index(*model, "robot/tool"));
  EXPECT_TRUE(line.prismatic);
  EXPECT_NEAR((line.axis_L - Vector3d(1, 0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((line.origin_L - Vector3d(0, 0.3, 0)).norm(), 0, 1e-12);
}

// Measured elsewhere on the same mesh (collision STL, joint axis y, 20 000 samples, μ = 1): 30.1 % for four rays, 29.2 % for the exact cone; mean
// η of 0.132 and 0.236 at ε = 0.01 and 0.02. The thesis has 32.58 % for the forearm, with a mesh, an axis and n_d that it does not state.
TEST(Detectability, Ur5Forearm_HasTheSharesMeasuredElsewhere) {
  SensorOptions options;
  options.links = {"arm/forearm_link"};
  options.samples = 20000;
  options.sampling = Sampling::Uniform;
  options.surface.rays = 0;  // faces at the joints stay, as they were there
  const auto sensor = Sensor::make(make_arm(kUr5), options);
  const SensedLink& forearm = sensor->links()[0];
  const double error = 4 * std::sqrt(2 * 0.3 * 0.7 / 20000);  // of the difference of two samples, four standard deviations
  const DetectabilityMap exact = calc_detectability(sensor->model(), forearm, FrictionCone(1, 0), 0.02);
  EXPECT_NEAR(exact.full / 20000.0, 0.292, error);
  EXPECT_NEAR(calc_detectability(sensor->model(), forearm, FrictionCone(1, 4), 0.02).full / 20000.0, 0.301, error);
  EXPECT_NEAR(exact.eta.mean(), 0.236, 0.01);
  EXPECT_NEAR(calc_detectability(sensor->model(), forearm, FrictionCone(1, 0), 0.01).eta.mean(), 0.132, 0.01);
}

}  // namespace
}  // namespace stiction::sensing::test
