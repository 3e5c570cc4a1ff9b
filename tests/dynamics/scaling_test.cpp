// Steps in other units: small and light things rest where large ones do, and a heavy bystander changes nothing.
#include "dynamics/systems.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using world::Model;

world::ObjectSpec cube(const std::string& name, double size, double mass) {
  world::ObjectSpec object;
  object.name = name;
  object.joint = world::ObjectJoint::Free;
  object.mass = mass;
  object.inertia = mass * size * size / 6 * Eigen::Matrix3d::Identity();
  object.geometries.push_back({.name = name, .shape = world::Box{Eigen::Vector3d::Constant(size / 2)}, .X_BG = {}, .friction = 0.8});
  return object;
}

world::Scene cube_on_floor(double size, double mass) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 0, -9.81};
  scene.contact_distance = size;
  scene.objects.push_back(cube("cube", size, mass));
  scene.fixed.push_back(half_space(Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero(), 0.8));
  return scene;
}

double floor_force(const StepResult& r, double h) {
  double force = 0;
  for (const auto& c : r.contacts) force += std::abs(calc_wrench(c, h)[2]);
  return force;
}

class Resting : public testing::TestWithParam<std::tuple<double, double, double>> {};

TEST_P(Resting, Cube_StaysOnTheFloorThatCarriesItsWeight) {
  const auto& [size, mass, h] = GetParam();
  const auto model = Model::make(cube_on_floor(size, mass));
  StepWorkspace work(model);
  StepResult r;
  Eigen::VectorXd q = model->neutral();
  q[2] = size / 2;
  for (const FrictionLaw law : {FrictionLaw::Anitescu, FrictionLaw::Coulomb}) {
    for (int k = 0; k < 20; ++k) {
      ASSERT_EQ(step(*model, {q, Eigen::VectorXd(0)}, {.h = h, .friction_law = law}, work, r), Status::Solved);
      q = r.q_next;
    }
    EXPECT_NEAR(q[2] / size, 0.5, 1e-4);
    EXPECT_NEAR(floor_force(r, h) / (mass * 9.81), 1, 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, Resting,
                         testing::Values(std::tuple(1e-1, 1.0, 0.1), std::tuple(1e-2, 1e-3, 0.1), std::tuple(1e-3, 1e-6, 0.1),
                                         std::tuple(1e-3, 1e-6, 0.01), std::tuple(1e-4, 1e-9, 0.1), std::tuple(1.0, 1e3, 0.1),
                                         std::tuple(10.0, 1e6, 0.1), std::tuple(1e-2, 10.0, 0.001)));

// Lengths times s, masses times m: every number of the step is the same but for its exponent where s is a power of two and m one of four, since
// the scaling of the rows takes roots of w/z.
TEST(Scaling, PowersOfTwo_PushIsTheSameToTheLastBit) {
  const auto pushed = [](double s, double m, std::vector<double>& lengths, std::vector<double>& impulses) {
    world::Scene scene = cube_on_floor(0.25 * s, 0.5 * m);
    scene.gravity *= s;  // accelerations in the new unit of length
    const auto model = Model::make(scene);
    StepWorkspace work(model);
    StepResult r;
    Eigen::VectorXd q = model->neutral(), tau = Eigen::VectorXd::Zero(6);
    q[2] = 0.125 * s;
    tau.head<3>() << 6.0 * m * s, 1.0 * m * s, -0.5 * m * s;
    tau[5] = 0.25 * m * s * s;
    int iterations = 0;
    for (const FrictionLaw law : {FrictionLaw::Anitescu, FrictionLaw::Coulomb}) {
      for (int k = 0; k < 3; ++k) {
        const StepOptions options{.regularisation = FixedEpsilon{1}, .friction_law = law};
        EXPECT_EQ(step(*model, {q, Eigen::VectorXd(0), &tau}, options, work, r), Status::Solved);
        iterations += r.iterations;
        q = r.q_next;
        for (int i = 0; i < 3; ++i) lengths.push_back(r.delta[i] / s);
        for (const auto& c : r.contacts) impulses.push_back(c.lambda[0] / (m * s));
      }
    }
    return iterations;
  };
  std::vector<double> lengths, impulses;
  const int iterations = pushed(1, 1, lengths, impulses);
  EXPECT_GT(*std::ranges::max_element(lengths), 1e-3) << "the cube never moved: the test would say nothing";
  for (const auto& [s, m] : {std::pair{std::ldexp(1, -10), std::ldexp(1, -30)}, std::pair{16.0, std::ldexp(1, 12)}, std::pair{0.5, 4.0}}) {
    std::vector<double> other_lengths, other_impulses;
    EXPECT_EQ(pushed(s, m, other_lengths, other_impulses), iterations) << s << " m, " << m << " kg";
    EXPECT_EQ(other_lengths, lengths) << s << " m, " << m << " kg";
    EXPECT_EQ(other_impulses, impulses) << s << " m, " << m << " kg";
  }
}

TEST(Scaling, HeavyBystander_ContactOfALightObjectStaysActive) {
  world::Scene scene = cube_on_floor(0.1, 0.5);
  world::ObjectSpec stone = cube("stone", 1, 1e4);
  scene.objects.push_back(stone);
  const auto model = Model::make(scene);
  StepWorkspace work(model);
  StepResult r;
  Eigen::VectorXd q = model->neutral();
  q[2] = 0.05;
  q.segment<3>(7) << 50, 50, 0.5;
  ASSERT_EQ(step(*model, {q, Eigen::VectorXd(0)}, {}, work, r), Status::Solved);
  int active = 0;
  double force = 0;
  for (const auto& c : r.contacts) {
    if (model->scales().pair(c.contact.pair).force > 100) continue;
    active += c.active ? 1 : 0;
    force += c.lambda[0] / 0.1;
  }
  EXPECT_GT(active, 0);
  EXPECT_NEAR(force, 0.5 * 9.81, 1e-3);
  EXPECT_NEAR(r.q_next[2], 0.05, 1e-4);
}

}  // namespace
}  // namespace stiction::dynamics::test
