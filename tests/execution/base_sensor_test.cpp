#include "stiction/execution/contact_control/base_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/message_of.hpp"

namespace stiction::execution::test {
namespace {

using Eigen::VectorXd;
using stiction::test::message_of;

const Vector6 kWrench = (Vector6() << 3, -2, 10, 1, 0.5, -4).finished();

Vector6 given(const sensing::BaseWrench& w) { return (Vector6() << w.force_W, w.moment_W).finished(); }

TEST(BaseSensor, NoiseHasItsDeviation_AndTheMemoryOfTheLag) {
  BaseSensor sensor(7, 0.005, {.time_constant = 0.01, .seed = 3}, {.force_noise = 0.8, .moment_noise = 0.05});
  const VectorXd q = VectorXd::Zero(7);
  Vector6 sum = Vector6::Zero(), squares = Vector6::Zero(), products = Vector6::Zero(), last = Vector6::Zero();
  constexpr int kCount = 60000;
  for (int k = 0; k < kCount; ++k) {
    const Vector6 error = given(sensor.update(kWrench, q)) - kWrench;
    sum += error, squares += error.cwiseAbs2(), products += error.cwiseProduct(last), last = error;
  }
  const double memory = 1 - 0.005 / 0.015;  // of one period, 1 − h/(T_O + h)
  for (int i = 0; i < 6; ++i) {
    const double deviation = i < 3 ? 0.8 : 0.05;
    EXPECT_NEAR(sum[i] / kCount, 0, 0.05 * deviation);
    EXPECT_NEAR(std::sqrt(squares[i] / kCount), deviation, 0.03 * deviation);
    EXPECT_NEAR(products[i] / squares[i], memory, 0.03);
  }
}

TEST(BaseSensor, Offsets_HaveTheirDeviationOverRunsAndChangeWithPosture) {
  double force = 0, moment = 0;
  constexpr int kRuns = 400;
  VectorXd q = VectorXd::Zero(7);
  for (int seed = 0; seed < kRuns; ++seed) {
    BaseSensor sensor(7, 0.005, {.bias_reach = 1, .seed = static_cast<std::uint64_t>(seed)},
                      {.force_noise = 1e-9, .moment_noise = 1e-9, .force_offset = 2, .moment_offset = 0.3});
    q.setZero();
    const Vector6 here = given(sensor.update(kWrench, q)) - kWrench;
    q[2] = 1e-4;
    EXPECT_LT((given(sensor.update(kWrench, q)) - kWrench - here).norm(), 0.01);
    q.setConstant(2);
    EXPECT_GT((given(sensor.update(kWrench, q)) - kWrench - here).norm(), 1e-3);
    force += here.head<3>().squaredNorm() / (3 * kRuns), moment += here.tail<3>().squaredNorm() / (3 * kRuns);
  }
  EXPECT_NEAR(std::sqrt(force), 2, 0.15);
  EXPECT_NEAR(std::sqrt(moment), 0.3, 0.0225);
}

TEST(BaseSensor, BadOptions_AreNamed) {
  const auto message = [](const BaseSensorOptions& options) { return message_of([&] { options.validate(); }); };
  EXPECT_NE(message({.force_noise = 0}).find("estimator.base_wrench.force_noise"), std::string::npos);
  EXPECT_NE(message({.moment_noise = -1}).find("estimator.base_wrench.moment_noise"), std::string::npos);
  EXPECT_NE(message({.moment_offset = -1}).find("estimator.base_wrench.moment_offset"), std::string::npos);
}

}  // namespace
}  // namespace stiction::execution::test
