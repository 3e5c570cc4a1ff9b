#include "stiction/core/run_control.hpp"

#include <gtest/gtest.h>

namespace stiction::core {
namespace {

TEST(RunControl, Abandoned_StopsLikeACancelledRunUntilTheDeadlineOrNot) {
  RunControl control;
  EXPECT_FALSE(control.stop()) << "nothing asks for it";
  bool over = false;
  control.abandoned = [&] { return over; };
  EXPECT_FALSE(control.stop());
  over = true;
  EXPECT_TRUE(control.cancelled());
  EXPECT_TRUE(control.stop());
  EXPECT_FALSE(control.expired());
  over = false;
  std::atomic<bool> cancel = true;
  control.cancel = &cancel;
  EXPECT_TRUE(control.cancelled()) << "either is enough";
  cancel = false;
  control.deadline = RunControl::Clock::now();
  EXPECT_FALSE(control.cancelled());
  EXPECT_TRUE(control.stop());
}

}  // namespace
}  // namespace stiction::core
