#include "stiction/sensing/few_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stiction::sensing::test {
namespace {

/// Quantiles of Student's distribution, from tables: P(|t| > x) = 0.05, 0.001.
struct Row {
  double freedom, at_5, at_01;
};

class StudentBound : public ::testing::TestWithParam<Row> {};

TEST_P(StudentBound, Quantiles_AreThoseOfTables) {
  const auto [freedom, at_5, at_01] = GetParam();
  const double root = std::sqrt(calc_student_variance(freedom));
  EXPECT_NEAR(root * calc_student_bound(freedom, 1.959963985), at_5, 6e-4);
  EXPECT_NEAR(root * calc_student_bound(freedom, 3.290526731), at_01, 6e-4 * at_01);
}

INSTANTIATE_TEST_SUITE_P(Tables, StudentBound,
                         ::testing::Values(Row{1, 12.706, 636.619}, Row{2, 4.303, 31.599}, Row{3, 3.182, 12.924}, Row{5, 2.571, 6.869},
                                           Row{9, 2.262, 4.781}, Row{17, 2.110, 3.965}, Row{40, 2.021, 3.551}, Row{120, 1.980, 3.373}));

TEST(StudentBound, ManyRows_AreTheNormalDistribution) {
  EXPECT_NEAR(calc_student_bound(9999, 4), 4, 0.01);
  EXPECT_EQ(calc_student_bound(std::numeric_limits<double>::infinity(), 4), 4);
  EXPECT_EQ(calc_student_variance(std::numeric_limits<double>::infinity()), 1);
}

TEST(StudentBound, FewerRows_NeedLargerTorques) {
  double before = std::numeric_limits<double>::infinity();
  for (const double freedom : {1.0, 1.5, 2.0, 4.0, 4.5, 9.0, 30.0, 300.0}) {
    const double bound = calc_student_bound(freedom, 4) * std::sqrt(calc_student_variance(freedom));
    EXPECT_LT(bound, before);
    before = bound;
  }
}

}  // namespace
}  // namespace stiction::sensing::test
