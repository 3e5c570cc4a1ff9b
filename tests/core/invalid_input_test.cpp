#include "stiction/core/invalid_input.hpp"

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <limits>

namespace stiction::core {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

// The message of the InvalidInput that `call` throws; "nothing thrown" otherwise.
std::string message(const std::function<void()>& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST(InvalidInput, ThrowInvalid_NamesFieldGotAndExpected) {
  EXPECT_EQ(message([] { throw_invalid("step.h", "-1", "a number > 0"); }), "step.h: got -1, expected a number > 0");
}

TEST(InvalidInput, IsAStandardInvalidArgument) { EXPECT_THROW(throw_invalid("a", "b", "c"), std::invalid_argument); }

TEST(RequireSize, Mismatch_SaysBothSizes) {
  EXPECT_EQ(message([] { require_size("q", 3, 7); }), "q: got 3 numbers, expected 7");
  EXPECT_NO_THROW(require_size("q", 0, 0));
}

TEST(RequireFinite, NanAndInfinity_AreRefused) {
  EXPECT_EQ(message([] { require_finite("mass", kNan); }), "mass: got nan, expected a finite number");
  EXPECT_EQ(message([] { require_finite("mass", -kInf); }), "mass: got -inf, expected a finite number");
  EXPECT_NO_THROW(require_finite("mass", 0.0));
}

TEST(RequireFinite, Vector_NamesTheFirstBadEntry) {
  const std::array<double, 4> values{0.0, 1.0, kInf, kNan};
  EXPECT_EQ(message([&] { require_finite("u", values); }), "u[2]: got inf, expected a finite number");
  EXPECT_NO_THROW(require_finite("u", std::span<const double>{}));
}

TEST(RequirePositive, ZeroNegativeAndNan_AreRefused) {
  for (const double bad : {0.0, -1e-300, kNan, kInf}) EXPECT_THROW(require_positive("h", bad), InvalidInput) << bad;
  EXPECT_EQ(message([] { require_positive("h", 0.0); }), "h: got 0, expected a finite number > 0");
  EXPECT_NO_THROW(require_positive("h", 1e-300));
}

TEST(RequireNonnegative, NegativeAndNan_AreRefused) {
  for (const double bad : {-1e-300, kNan, kInf}) EXPECT_THROW(require_nonnegative("mu", bad), InvalidInput) << bad;
  EXPECT_EQ(message([] { require_nonnegative("mu", -0.5); }), "mu: got -0.5, expected a finite number ≥ 0");
  EXPECT_NO_THROW(require_nonnegative("mu", 0.0));
}

/// Their squares and cubes would be infinite.
TEST(RequireFinite, NumbersBeyondAllSizes_AreRefused) {
  EXPECT_EQ(message([] { require_finite("x", 1e300); }), "x: got 1e+300, expected a number of at most 1e+50");
  const double values[] = {0, 1e50, -1e51};
  EXPECT_EQ(message([&] { require_finite("q", values); }), "q[2]: got -1e+51, expected a number of at most 1e+50");
  EXPECT_EQ(message([] { require_positive("m", 1e300); }), "m: got 1e+300, expected a number of at most 1e+50");
  EXPECT_EQ(message([] { require_nonnegative("mu", 1e300); }), "mu: got 1e+300, expected a number of at most 1e+50");
}

}  // namespace
}  // namespace stiction::core
