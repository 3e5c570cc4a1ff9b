#include "stiction/core/status.hpp"

#include <gtest/gtest.h>

#include <string>

#include "stiction/core/version.hpp"

namespace stiction::core {
namespace {

TEST(Status, EveryValue_HasItsOwnName) {
  EXPECT_EQ(to_string(Status::Solved), "Solved");
  EXPECT_EQ(to_string(Status::MaxIterations), "MaxIterations");
  EXPECT_EQ(to_string(Status::Infeasible), "Infeasible");
  EXPECT_EQ(to_string(Status::NumericalFailure), "NumericalFailure");
  EXPECT_EQ(to_string(Status::Cancelled), "Cancelled");
}

TEST(Version, Always_ThreeNumbers) {
  const std::string text(version());
  int dots = 0;
  for (const char c : text) {
    EXPECT_TRUE(c == '.' || (c >= '0' && c <= '9')) << text;
    dots += c == '.';
  }
  EXPECT_EQ(dots, 2) << text;
}

}  // namespace
}  // namespace stiction::core
