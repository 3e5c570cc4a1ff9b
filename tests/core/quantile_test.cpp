#include "stiction/core/quantile.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace stiction::core::test {
namespace {

TEST(Quantile, UnsortedValues_NearestRank) {
  const std::vector<double> values{4, 1, 5, 2, 3};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.5), 3);
  EXPECT_EQ(quantile(values, 0.6), 3);   // rank 2.4
  EXPECT_EQ(quantile(values, 0.95), 5);  // rank 3.8
  EXPECT_EQ(quantile(values, 1), 5);
  EXPECT_EQ(quantile({2, 1}, 0.5), 2);
}

TEST(Quantile, NoValues_IsNaN) { EXPECT_TRUE(std::isnan(quantile({}, 0.5))); }

}  // namespace
}  // namespace stiction::core::test
