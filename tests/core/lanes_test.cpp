#include "stiction/core/lanes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace stiction::core {
namespace {

/// Rounds of given costs; items take some time, less in the first thread.
class Fake : public LaneTask {
 public:
  explicit Fake(std::vector<long> costs, int items = 2) : costs_(std::move(costs)), items_(items) {}

  int turn(int) override {
    EXPECT_EQ(inside_++, 0) << "a turn is alone in its lane";
    EXPECT_EQ(done_, drawn_) << "all items of the round are done";
    done_ = 0;
    if (round_ > 0 && round_ <= costs_.size()) cost_ += costs_[round_ - 1];
    const bool ended = round_ >= costs_.size();
    round_ = std::min(round_ + 1, costs_.size() + 1);
    drawn_ = ended ? 0 : items_;
    --inside_;
    return drawn_;
  }
  void work(int item, int worker) override {
    EXPECT_GE(item, 0);
    EXPECT_LT(item, items_);
    std::this_thread::sleep_for(std::chrono::microseconds(worker == 0 ? 50 : 300));
    ++done_;
  }
  long cost() const override { return cost_; }

 private:
  std::vector<long> costs_;
  int items_, drawn_ = 0;
  std::size_t round_ = 0;
  long cost_ = 0;
  std::atomic<int> inside_{0}, done_{0};
};

/// The order in which tasks of given costs end, each taken by the lane that is free: "task@clock".
std::string order_of_ends(const std::vector<std::vector<long>>& costs, int lanes, int threads) {
  ThreadPool pool(threads);
  std::vector<std::unique_ptr<Fake>> tasks;
  std::vector<std::size_t> in_lane(static_cast<std::size_t>(lanes));
  std::string out;
  run_lanes(pool, lanes, [&](int lane, LaneTask* ended, long clock) -> LaneTask* {
    auto& number = in_lane[static_cast<std::size_t>(lane)];
    if (ended != nullptr) {
      EXPECT_EQ(ended, tasks[number].get());
      out += std::to_string(number) + "@" + std::to_string(clock) + " ";
    }
    if (tasks.size() == costs.size()) return nullptr;
    number = tasks.size();
    return tasks.emplace_back(std::make_unique<Fake>(costs[number])).get();
  });
  return out;
}

TEST(Lanes, OneLane_OneAfterTheOther) { EXPECT_EQ(order_of_ends({{3, 4}, {5}, {1, 1}}, 1, 2), "0@7 1@12 2@14 "); }

TEST(Lanes, EndsComeInTheOrderOfTheClocks_ForAnyNumberOfThreads) {
  const std::vector<std::vector<long>> costs{{9, 9, 9}, {5}, {4, 4}, {10, 1}, {2}, {7, 7, 7}};
  for (int threads = 1; threads <= 4; ++threads) {
    EXPECT_EQ(order_of_ends(costs, 2, threads), "1@5 2@13 3@24 4@26 0@27 5@47 ") << threads;
    EXPECT_EQ(order_of_ends(costs, 3, threads), "1@5 2@8 4@10 3@16 0@27 5@31 ") << threads;
  }
}

TEST(Lanes, EqualClocks_FirstLaneFirst) { EXPECT_EQ(order_of_ends({{5, 5}, {10}, {2, 8}}, 3, 3), "0@10 1@10 2@10 "); }

TEST(Lanes, NothingToGrow_Ends) {
  ThreadPool pool(2);
  int asked = 0;
  run_lanes(pool, 3, [&](int, LaneTask*, long) -> LaneTask* { return ++asked, nullptr; });
  EXPECT_EQ(asked, 3);
}

TEST(Lanes, TaskThatGoesOn_KeepsItsCost) {
  ThreadPool pool(2);
  Fake task({4, 4});
  std::vector<long> clocks;
  run_lanes(pool, 1, [&](int, LaneTask* ended, long clock) -> LaneTask* {
    clocks.push_back(clock);
    if (clocks.size() == 3) return nullptr;
    return ended == nullptr ? &task : ended;  // has ended, and ends again at once
  });
  EXPECT_EQ(clocks, (std::vector<long>{0, 8, 8}));
}

TEST(Lanes, Exception_EndsTheRun) {
  struct Throws : Fake {
    using Fake::Fake;
    void work(int, int) override { throw std::runtime_error("broken"); }
  };
  for (int threads = 1; threads <= 3; ++threads) {
    ThreadPool pool(threads);
    Throws bad({1});
    Fake good(std::vector<long>(20, 1));
    std::vector<LaneTask*> tasks{&bad, &good};
    EXPECT_THROW(
        run_lanes(pool, 2,
                  [&](int lane, LaneTask* ended, long) { return ended == nullptr ? tasks[static_cast<std::size_t>(lane)] : nullptr; }),
        std::runtime_error);
  }
}

}  // namespace
}  // namespace stiction::core
