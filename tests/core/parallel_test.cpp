#include "stiction/core/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
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

// Which of the items come to an end first does not matter: the smallest one that is enough counts, and all before it are done.
TEST_P(ThreadPools, RunUntil_EndsWithTheFirstItemThatIsEnough) {
  ThreadPool pool(GetParam());
  for (int repeat = 0; repeat < 50; ++repeat) {
    std::vector<std::atomic<int>> calls(40);
    const int needed = pool.run_until(40, [&](int item, int, const ThreadPool::Turn&) {
      ++calls[static_cast<std::size_t>(item)];
      if (item % 5 == 3) std::this_thread::sleep_for(std::chrono::microseconds(100));
      return item == 7 ? 9 : item == 12 || item == 8 ? item + 1 : 40;
    });
    ASSERT_EQ(needed, 9);
    for (std::size_t i = 0; i < 9; ++i) ASSERT_EQ(calls[i].load(), 1) << i;
    for (const auto& c : calls) ASSERT_LE(c.load(), 1);
    EXPECT_TRUE(pool.size() > 1 || calls[9].load() == 0);
  }
  EXPECT_EQ(pool.run_until(0, [](int, int, const ThreadPool::Turn&) { return 0; }), 0);
}

TEST_P(ThreadPools, RunUntil_AnItemThatIsNotNeededAnyMore_IsOver) {
  ThreadPool pool(GetParam());
  const int needed = pool.run_until(8, [&](int item, int, const ThreadPool::Turn& turn) {
    if (item == 0) return 1;
    while (!turn.over()) std::this_thread::yield();  // for ever, were it not told
    return 8;
  });
  EXPECT_EQ(needed, 1);
}

// Items start runs of their own. The worker of an item that waits for its run is not given anything else.
TEST_P(ThreadPools, RunUntil_InItems_GivesWhatOneThreadGives) {
  ThreadPool pool(GetParam());
  for (int repeat = 0; repeat < 20; ++repeat) {
    std::vector<int> busy(static_cast<std::size_t>(pool.size()), 0);  // without a lock, as a workspace is used
    std::atomic<bool> alone{true};
    std::vector<int> inner(6, -1);
    const int needed = pool.run_until(6, [&](int item, int worker, const ThreadPool::Turn& turn) {
      int& mine = busy[static_cast<std::size_t>(worker)];
      if (mine++ != 0) alone = false;
      inner[static_cast<std::size_t>(item)] = pool.run_until(
          10,
          [&](int k, int helper, const ThreadPool::Turn& at) {
            int& theirs = busy[static_cast<std::size_t>(helper)];
            if (theirs++ != (helper == worker ? 1 : 0)) alone = false;
            for (int spin = 0; spin < 1000 && !at.over(); ++spin) std::atomic_signal_fence(std::memory_order_seq_cst);
            --theirs;
            return k == item + 2 ? k + 1 : 10;
          },
          &turn);
      --mine;
      return item == 4 ? 5 : 6;
    });
    ASSERT_EQ(needed, 5);
    for (int item = 0; item < 5; ++item) ASSERT_EQ(inner[static_cast<std::size_t>(item)], item + 3);
    ASSERT_TRUE(alone);
  }
}

TEST_P(ThreadPools, RunUntil_OnlyWhatIsNeededThrows) {
  ThreadPool pool(GetParam());
  const auto throws_at = [&](int bad) {
    return pool.run_until(16, [bad](int item, int, const ThreadPool::Turn&) {
      if (item == bad) throw std::runtime_error("bad");
      return item == 5 ? 6 : 16;
    });
  };
  EXPECT_EQ(throws_at(6), 6);
  EXPECT_THROW(throws_at(4), std::runtime_error);
}

TEST_P(ThreadPools, Run_AfterAnException_Works) {
  ThreadPool pool(GetParam());
  EXPECT_THROW(pool.run(4, [](int, int) { throw std::runtime_error("x"); }), std::runtime_error);
  std::atomic<int> calls{0};
  EXPECT_NO_THROW(pool.run(4, [&](int, int) { ++calls; }));
  EXPECT_EQ(calls.load(), 4);
}

TEST(ThreadPool, LessThanOneThreadOrTooMany_AreRefused) {
  try {
    ThreadPool pool(0);
    FAIL() << "nothing thrown";
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(), "threads: got 0, expected at least 1");
  }
  try {
    ThreadPool pool(100000);
    FAIL() << "nothing thrown";
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(), "threads: got 100000, expected at most 1024");
  }
}

TEST(HardwareThreads, Always_MakeAPool) {
  EXPECT_GE(hardware_threads(), 1);
  EXPECT_LE(hardware_threads(), kMostThreads) << "ThreadPool takes no more";
}

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
