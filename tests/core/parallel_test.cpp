#include "stiction/core/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "stiction/core/run_control.hpp"

namespace stiction::core {
namespace {

class ThreadPools : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Threads, ThreadPools, ::testing::Values(1, 2, 5));

TEST_P(ThreadPools, Run_CallsEveryItemOnceWithAWorkerInRange) {
  ThreadPool pool(GetParam());
  ASSERT_EQ(pool.size(), GetParam());
  for (const int n : {0, 1, 2, 1000}) {
    std::vector<std::atomic<int>> calls(static_cast<std::size_t>(n));
    std::atomic<bool> in_range{true};
    pool.run(n, [&](int item, int worker) {
      ++calls[static_cast<std::size_t>(item)];
      if (worker < 0 || worker >= pool.size()) in_range = false;
    });
    for (const auto& c : calls) EXPECT_EQ(c.load(), 1);
    EXPECT_TRUE(in_range);
  }
}

// Each worker owns a scratch entry without a lock: two items must never run on one worker at once (the thread sanitizer looks here too).
TEST_P(ThreadPools, Run_OneWorkerDoesOneItemAtATime) {
  ThreadPool pool(GetParam());
  std::vector<long> scratch(static_cast<std::size_t>(pool.size()), 0);
  for (int repeat = 0; repeat < 50; ++repeat) {
    pool.run(100, [&](int item, int worker) { scratch[static_cast<std::size_t>(worker)] += item; });
  }
  long sum = 0;
  for (const long s : scratch) sum += s;
  EXPECT_EQ(sum, 50L * 99 * 100 / 2);
}

TEST_P(ThreadPools, Run_WithSubstreams_DoesNotDependOnTheNumberOfThreads) {
  const auto draw = [](int threads) {
    ThreadPool pool(threads);
    std::vector<double> out(500);
    pool.run(500, [&](int item, int) {
      Random random(42, static_cast<std::uint64_t>(item));
      for (int k = 0; k < 10; ++k) out[static_cast<std::size_t>(item)] += random.normal();
    });
    return out;
  };
  EXPECT_EQ(draw(1), draw(GetParam()));  // bit by bit
}

TEST_P(ThreadPools, Run_SeveralItemsThrow_TheSmallestOneIsReported) {
  ThreadPool pool(GetParam());
  for (int repeat = 0; repeat < 20; ++repeat) {
    std::atomic<int> calls{0};
    try {
      pool.run(64, [&](int item, int) {
        ++calls;
        if (item == 9 || item == 10 || item == 63) throw std::runtime_error("item " + std::to_string(item));
      });
      FAIL() << "nothing thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "item 9");
    }
    EXPECT_EQ(calls.load(), 64) << "the other items still run";
  }
  int sum = 0;
  ThreadPool one(1);
  one.run(3, [&](int item, int) { sum += item; });
  EXPECT_EQ(sum, 3);
}

TEST_P(ThreadPools, Run_AfterAnException_Works) {
  ThreadPool pool(GetParam());
  EXPECT_THROW(pool.run(4, [](int, int) { throw std::runtime_error("x"); }), std::runtime_error);
  std::atomic<int> calls{0};
  EXPECT_NO_THROW(pool.run(4, [&](int, int) { ++calls; }));
  EXPECT_EQ(calls.load(), 4);
}

TEST(ThreadPool, LessThanOneThread_IsRefused) {
  try {
    ThreadPool pool(0);
    FAIL() << "nothing thrown";
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(), "threads: got 0, expected at least 1");
  }
}

TEST(HardwareThreads, Always_AtLeastOne) { EXPECT_GE(hardware_threads(), 1); }

TEST(RunControl, Default_NeverStops) {
  const RunControl control;
  EXPECT_FALSE(control.stop());
}

TEST(RunControl, CancelFlagAndDeadline_Stop) {
  std::atomic<bool> cancel{false};
  RunControl control;
  control.cancel = &cancel;
  EXPECT_FALSE(control.stop());
  cancel = true;
  EXPECT_TRUE(control.cancelled());
  EXPECT_TRUE(control.stop());

  RunControl timed;
  timed.deadline = RunControl::Clock::now() + std::chrono::hours(1);
  EXPECT_FALSE(timed.expired());
  timed.deadline = RunControl::Clock::now() - std::chrono::nanoseconds(1);
  EXPECT_TRUE(timed.expired());
  EXPECT_TRUE(timed.stop());
}

}  // namespace
}  // namespace stiction::core
