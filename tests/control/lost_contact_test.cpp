// A contact that is lost stays bounded where it was last seen until nothing is held back, (C.15), (C.17).
#include <gtest/gtest.h>

#include "control/pressed_arm.hpp"

namespace stiction::control::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// q does not move: what the reference asks for stays, and the bound grows to it in T (demand / λ_max − 1), the predicted force with it.
TEST(Controller, LostContact_IsKeptUntilItsBoundHoldsNothingBack) {
  Bench bench({.release_time = 0.1});
  bench.q_ref[0] = 0.3;
  for (int k = 0; k < 100; ++k) (void)bench.update();
  const Row row(bench);
  const double demand = row.calc_force(bench.q_ref, bench.q);
  ASSERT_GT(demand, 3 * 15) << "the bound holds nothing back";
  bench.contacts.clear();
  int kept = 0;
  while (!bench.update().taken.empty()) {
    ++kept;
    const double allowed = 15 * (1 + kept * kTick / 0.1);
    ASSERT_LE(
        row.calc_force(bench.controller.update({.time = -1, .q = bench.q, .q_ref = bench.q_ref, .contacts = {}}, kTick).q_cmd, bench.q),
        1.02 * allowed)
        << "a jump in tick " << kept;
  }
  EXPECT_NEAR(kept * kTick, 0.1 * (demand / 15 - 1), 2 * kTick);
}

/// Nothing is there any more and the arm is where it was commanded to be: it gets on by the preload, and then by λ_max/(k T) a second.
TEST(Controller, LostContact_ArmThatMeetsNothing_ClosesTheGapSlowly) {
  Bench bench;
  bench.q_ref[0] = 0.3;
  for (int k = 0; k < 200; ++k) (void)bench.update();
  const Row row(bench);
  const VectorXd lost_at = bench.q;
  bench.contacts.clear();
  double advance = 0;
  for (int k = 1; k <= 200; ++k) {
    bench.q = bench.update().q_cmd;
    advance = row.calc_force(bench.q, lost_at);
    ASSERT_LE(advance, 1.1 * 15 * (1 + k * kTick / 0.5)) << "tick " << k << ", up to curvature";
  }
  EXPECT_GT(advance, 0.9 * 15 * (1 + 200 * kTick / 0.5)) << "it does not close";
}

/// A reference that goes on against a contact that is lost is followed at its own speed.
TEST(Controller, LostContact_ReferenceThatGoesOn_IsFollowedAtItsSpeed) {
  Bench bench;
  bench.q_ref[0] = 0.3;
  for (int k = 0; k < 200; ++k) (void)bench.update();
  const Row row(bench);
  bench.contacts.clear();
  const double behind = row.calc_force(bench.q_ref, bench.q);
  for (int k = 0; k < 100; ++k) {
    bench.q_ref[0] += 2e-3;
    bench.q = bench.update().q_cmd;
  }
  EXPECT_LT(row.calc_force(bench.q_ref, bench.q), behind) << "0.2 rad farther";
}

TEST(Controller, ContactThatTheReferenceLeaves_IsForgottenAtOnce) {
  Bench bench;
  bench.q_ref[0] = 0.3;
  for (int k = 0; k < 100; ++k) (void)bench.update();
  bench.q_ref[0] = -0.3;
  EXPECT_EQ(bench.update().taken.size(), 1u) << "it is felt";
  bench.contacts.clear();
  EXPECT_TRUE(bench.update().taken.empty());
}

/// What was held back is made up for in the release time instead of in ticks, although the reference leaves and no wall is kept: of w, T/h at first, each tick
/// leaves the share h/(T + h) less.
TEST(Controller, ArmThatGotFree_MakesUpForWhatItWasHeldBackInTheReleaseTime) {
  Bench bench({.release_time = 0.2});
  bench.q_ref[0] = 0.3;
  for (int k = 0; k < 200; ++k) (void)bench.update();
  bench.contacts.clear();
  bench.q_ref[0] = -0.1;
  VectorXd last = bench.update().q_cmd;
  double w = 0.2 / kTick, left = (bench.q_ref - last).norm(), fastest = 0;
  const double start = left;
  for (int k = 0; k < 400; ++k) {
    const VectorXd q_cmd = bench.update().q_cmd;
    fastest = std::max(fastest, (q_cmd - last).norm() / kTick);
    last = q_cmd;
    w /= 1 + kTick / 0.2, left *= 1 - 1 / (1 + w);
    ASSERT_NEAR((bench.q_ref - q_cmd).norm(), left, 1e-9) << "tick " << k;
  }
  EXPECT_LE(fastest, 1.05 * start / 0.2);
  EXPECT_LT(left, 1e-9) << "it ends";
}

}  // namespace
}  // namespace stiction::control::test
