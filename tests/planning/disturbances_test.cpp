#include "stiction/planning/disturbances.hpp"

#include <array>

#include "planning/systems.hpp"

namespace stiction::planning::test {
namespace {

// m ‖g‖ tan(angle) on what moves freely, at right angles to gravity, from four sides that cancel.
TEST(WeightsAside, FreeObject_FromFourSidesAtRightAngles) {
  const auto model = load_model("iiwa_bimanual");  // a can of 0.5 kg
  const double angle = 0.05, force = 0.5 * 9.8 * std::tan(angle);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(model->n_v());
  for (int draw = 0; draw < kDisturbances; ++draw) {
    const Eigen::VectorXd tau = calc_weights_aside(*model, angle, draw);
    const Eigen::Vector3d f = tau.segment<3>(model->objects()[0].v_begin);
    EXPECT_NEAR(f.norm(), force, 1e-12);
    EXPECT_NEAR(f.z(), 0, 1e-12);
    EXPECT_NEAR(tau.norm(), force, 1e-12) << "nothing but that force";
    const Eigen::Vector3d next = calc_weights_aside(*model, angle, (draw + 1) % kDisturbances).segment<3>(model->objects()[0].v_begin);
    EXPECT_NEAR(f.dot(next), 0, 1e-12);
    sum += tau;
  }
  EXPECT_NEAR(sum.norm(), 0, 1e-12);
  EXPECT_EQ(calc_weights_aside(*model, 0, 1).norm(), 0);
}

TEST(WeightsAside, ObjectOnJoints_FeelsNothing) {
  const auto model = load_model("planar_pushing");
  EXPECT_TRUE(calc_weights_aside(*model, 0.1, 0).isZero(0));
}

// Left arm, right arm and floor: each has less in two draws, any two differ in two.
TEST(FrictionFactors, TwoArmsAndAFloor_AreTriedAgainstEachOther) {
  const auto model = load_model("iiwa_bimanual");
  const RobotChains chains(*model);
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
}  // namespace stiction::planning::test
