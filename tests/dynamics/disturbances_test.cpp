#include "stiction/dynamics/disturbances.hpp"

#include <array>
#include <tuple>

#include "dynamics/systems.hpp"

namespace stiction::dynamics::test {
namespace {

// m ‖g‖ tan(angle) on what moves freely, at right angles to gravity, from four sides that cancel.
TEST(WeightsAside, FreeObject_FromFourSidesAtRightAngles) {
  const auto model = load_task("iiwa_bimanual");  // a can of 0.5 kg
  const double angle = 0.05, force = 0.5 * 9.8 * std::tan(angle);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(model->n_v());
  for (int draw = 0; draw < kDisturbances; ++draw) {
    const Eigen::VectorXd tau = calc_weights_aside(*model, model->neutral(), angle, draw);
    const Eigen::Vector3d f = tau.segment<3>(model->objects()[0].v_begin);
    EXPECT_NEAR(f.norm(), force, 1e-12);
    EXPECT_NEAR(f.z(), 0, 1e-12);
    EXPECT_NEAR(tau.norm(), force, 1e-12) << "nothing but that force";
    const Eigen::Vector3d next =
        calc_weights_aside(*model, model->neutral(), angle, (draw + 1) % kDisturbances).segment<3>(model->objects()[0].v_begin);
    EXPECT_NEAR(f.dot(next), 0, 1e-12);
    sum += tau;
  }
  EXPECT_NEAR(sum.norm(), 0, 1e-12);
  EXPECT_EQ(calc_weights_aside(*model, model->neutral(), 0, 1).norm(), 0);
}

// What a free object feels whose frame is not at its centre of mass: the difference between two gravities.
TEST(WeightsAside, ObjectInItsOwnFrame_FeelsTheForceAtItsCentreOfMass) {
  world::Scene scene = load_task("iiwa_bimanual")->scene();
  scene.objects[0].p_BCom = {0.02, -0.01, 0.05};
  const auto gravity = [&](const Eigen::Vector3d& g) {
    scene.gravity = g;
    const auto model = world::Model::make(scene);
    Eigen::VectorXd q = model->neutral();
    q.segment<4>(3) << 0.1, -0.3, 0.5, std::sqrt(1 - 0.35);
    world::KinematicsWorkspace work(*model);
    world::Kinematics kinematics;
    world::calc_kinematics(*model, q, work, kinematics);
    Eigen::VectorXd tau = Eigen::VectorXd::Zero(model->n_v());
    world::calc_gravity(*model, kinematics, tau.head(model->n_vu()));
    return std::tuple(model, q, tau);
  };
  const Eigen::Vector3d down(0, 0, -9.8);
  for (int draw = 0; draw < kDisturbances; ++draw) {
    const auto [model, q, tau] = gravity(down);
    const Eigen::VectorXd aside = calc_weights_aside(*model, q, 0.05, draw);
    ASSERT_GT(aside.segment<3>(3).norm(), 1e-3) << "no moment: the test would say nothing";
    const auto [other, q_other, expected] = gravity(down + aside.head<3>() / model->objects()[0].mass);
    EXPECT_NEAR((tau + aside - expected).norm(), 0, 1e-12);
  }
}

TEST(WeightsAside, ObjectOnJoints_FeelsNothing) {
  const auto model = load_task("planar_pushing");
  EXPECT_TRUE(calc_weights_aside(*model, model->neutral(), 0.1, 0).isZero(0));
}

// Left arm, right arm and floor: each has less in two draws, any two differ in two.
TEST(FrictionFactors, TwoArmsAndAFloor_AreTriedAgainstEachOther) {
  const auto model = load_task("iiwa_bimanual");
  const world::RobotChains chains(*model);
  ASSERT_EQ(chains.size(), 2);
  std::array<Eigen::Vector4d, 3> less;  // of the left arm, the right one, and the can on the floor, per draw
  for (int draw = 0; draw < kDisturbances; ++draw) {
    const Eigen::VectorXd factors = calc_friction_factors(*model, chains, 0.3, draw);
    ASSERT_EQ(factors.size(), static_cast<Eigen::Index>(model->pairs().size()));
    for (int pair = 0; pair < factors.size(); ++pair) {
      if (chains.mask_of_pair(pair) != 0 && !chains.touches_object(pair)) continue;
      const int group = chains.mask_of_pair(pair) == 1 ? 0 : chains.mask_of_pair(pair) == 2 ? 1 : 2;
      const double value = factors[pair] == 0.7 ? 1 : -1;
      EXPECT_TRUE(factors[pair] == 1 || factors[pair] == 0.7);
      less[static_cast<std::size_t>(group)][draw] = value;
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_EQ(less[a].sum(), 0);
    for (std::size_t b = 0; b < a; ++b) EXPECT_EQ(less[a].dot(less[b]), 0);
  }
}

}  // namespace
}  // namespace stiction::dynamics::test
