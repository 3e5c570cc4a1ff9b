#include "stiction/control/force_damping.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace stiction::control::test {
namespace {

constexpr double kTick = 0.005;

TEST(ForceDamping, ConstantError_ApproachesTheValueOfTheText) {
  ForceDamping damping({.largest = 2, .force_scale = 5, .forget_rate = 0.3});
  double w = 0;
  for (int k = 0; k < 200; ++k) w = damping.update(5, kTick);
  EXPECT_NEAR(w, 2 * (1 - std::exp(-1.0)), 1e-12);  // (5.28) with its sign corrected: near 1 for large errors
  EXPECT_NEAR(damping.update(0, kTick), 0.7 * w, 1e-12);
}

/// A command that moves to a reference at rest, (q_ref − q_cmd)/(1 + w) a tick, is slowed down as much per second by short ticks.
TEST(ForceDamping, ShortTicks_SlowDownAsMuchPerSecond) {
  const auto left_after = [](int ticks) {
    ForceDamping damping({.largest = 40, .force_scale = 5});
    const double dt = 0.1 / ticks;
    double left = 1;
    for (int k = 0; k < 10 * ticks; ++k) (void)damping.update(5, dt);
    for (int k = 0; k < ticks; ++k) left *= 1 - 1 / (1 + damping.update(5, dt));
    return left;
  };
  // 1/(1 + w) of a tick with w = 25 or, of a fifth of it, 126: −log(1 − 1/(1 + w)) = 1/w up to 1/w².
  EXPECT_NEAR(std::log(left_after(20)) / std::log(left_after(100)), 1, 0.03);
}

TEST(ForceDamping, PrintedFilter_ForgetsInTwoTicks) {
  ForceDamping recursive({.largest = 1, .forget_rate = 0.3}), printed({.largest = 1, .forget_rate = 0.3, .printed = true});
  (void)recursive.update(1e9, kTick), (void)printed.update(1e9, kTick);
  EXPECT_NEAR(printed.update(0, kTick), 0.7, 1e-12);
  EXPECT_NEAR(printed.update(0, kTick), 0, 1e-12);
  EXPECT_NEAR(recursive.update(0, kTick), 0.3 * 0.7, 1e-12);
  EXPECT_NEAR(recursive.update(0, kTick), 0.3 * 0.49, 1e-12);
}

}  // namespace
}  // namespace stiction::control::test
