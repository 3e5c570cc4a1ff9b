#include "stiction/core/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace stiction::core {
namespace {

std::vector<std::uint64_t> take(std::uint64_t seed, std::uint64_t stream, int n) {
  Random random(seed, stream);
  std::vector<std::uint64_t> bits(static_cast<std::size_t>(n));
  std::generate(bits.begin(), bits.end(), [&] { return random.bits(); });
  return bits;
}

TEST(Random, SameSeedAndStream_SameSequence) { EXPECT_EQ(take(7, 3, 1000), take(7, 3, 1000)); }

// Neighbouring seeds and streams are the ones in use: item i of seed s takes stream i.
TEST(Random, NeighbouringSeedsAndStreams_ShareNoValue) {
  std::set<std::uint64_t> seen;
  std::size_t drawn = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (std::uint64_t stream = 0; stream < 20; ++stream) {
      for (const std::uint64_t bits : take(seed, stream, 100)) {
        seen.insert(bits);
        ++drawn;
      }
    }
  }
  // 40 000 draws of 64 bits collide with probability 4e4²/2⁶⁵ < 1e-10.
  EXPECT_EQ(seen.size(), drawn);
}

TEST(Random, StreamsOfOneSeed_AreUncorrelated) {
  constexpr int kN = 20000;
  for (std::uint64_t stream = 0; stream < 8; ++stream) {
    Random a(1, stream), b(1, stream + 1);
    double sum = 0;
    for (int i = 0; i < kN; ++i) sum += (a.uniform() - 0.5) * (b.uniform() - 0.5);
    // The product has variance 1/144; five standard deviations of the mean.
    EXPECT_LT(std::abs(sum / kN), 5.0 / 12.0 / std::sqrt(kN)) << stream;
  }
}

TEST(Random, EveryBit_IsSetHalfOfTheTime) {
  constexpr int kN = 20000;
  std::vector<int> ones(64, 0);
  for (const std::uint64_t bits : take(11, 0, kN)) {
    for (int k = 0; k < 64; ++k) ones[static_cast<std::size_t>(k)] += static_cast<int>(bits >> k & 1U);
  }
  for (int k = 0; k < 64; ++k) EXPECT_LT(std::abs(ones[static_cast<std::size_t>(k)] - kN / 2), 5 * std::sqrt(kN) / 2) << "bit " << k;
}

TEST(Random, Uniform_StaysInRangeWithTheRightMoments) {
  constexpr int kN = 100000;
  Random random(0, 0);
  double sum = 0, sum2 = 0;
  for (int i = 0; i < kN; ++i) {
    const double x = random.uniform();
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    sum += x;
    sum2 += x * x;
  }
  EXPECT_NEAR(sum / kN, 0.5, 5 / std::sqrt(12.0 * kN));
  EXPECT_NEAR(sum2 / kN, 1.0 / 3.0, 5 * std::sqrt(4.0 / 45.0 / kN));  // Var(x²) = 1/5 − 1/9
}

TEST(Random, UniformInRange_CoversItsEndsAndNothingElse) {
  Random random(0, 1);
  double low = 1e9, high = -1e9;
  for (int i = 0; i < 10000; ++i) {
    const double x = random.uniform(-3.0, 5.0);
    low = std::min(low, x);
    high = std::max(high, x);
  }
  EXPECT_GE(low, -3.0);
  EXPECT_LT(high, 5.0);
  EXPECT_LT(low, -2.99);
  EXPECT_GT(high, 4.99);
}

TEST(Random, Normal_HasTheRightMomentsAndIsFinite) {
  constexpr int kN = 100000;
  Random random(5, 0);
  double sum = 0, sum2 = 0, sum4 = 0;
  for (int i = 0; i < kN; ++i) {
    const double x = random.normal();
    ASSERT_TRUE(std::isfinite(x));
    sum += x;
    sum2 += x * x;
    sum4 += x * x * x * x;
  }
  EXPECT_NEAR(sum / kN, 0.0, 5 / std::sqrt(kN));
  EXPECT_NEAR(sum2 / kN, 1.0, 5 * std::sqrt(2.0 / kN));   // Var(x²) = 2
  EXPECT_NEAR(sum4 / kN, 3.0, 5 * std::sqrt(96.0 / kN));  // Var(x⁴) = 105 − 9
}

TEST(Random, Index_HitsEveryValueEvenly) {
  constexpr int kN = 70000, kValues = 7;
  Random random(0, 9);
  std::vector<int> count(kValues, 0);
  for (int i = 0; i < kN; ++i) {
    const int k = random.index(kValues);
    ASSERT_GE(k, 0);
    ASSERT_LT(k, kValues);
    ++count[static_cast<std::size_t>(k)];
  }
  for (const int c : count) EXPECT_LT(std::abs(c - kN / kValues), 5 * std::sqrt(kN / kValues)) << c;
  EXPECT_EQ(Random(0, 0).index(1), 0);
}

TEST(Random, Chance_ZeroNeverAndOneAlways) {
  Random random(0, 2);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_FALSE(random.chance(0.0));
    EXPECT_TRUE(random.chance(1.0));
  }
}

}  // namespace
}  // namespace stiction::core
