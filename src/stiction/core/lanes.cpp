#include "stiction/core/lanes.hpp"

#include <condition_variable>
#include <mutex>
#include <vector>

namespace stiction::core {
namespace {

struct Lane {
  enum class Stage {
    Turn,
    InTurn,
    Round,
    Ended,
    Closed
  };
  Stage stage = Stage::Ended;
  LaneTask* task = nullptr;
  long start = 0, clock = 0;  ///< of the task when it had cost nothing, and now
  int items = 0, begun = 0, done = 0;

  bool open() const { return stage != Stage::Closed; }
  bool has_work() const { return stage == Stage::Turn || (stage == Stage::Round && begun < items); }
};

class Lanes {
 public:
  Lanes(int lanes, const std::function<LaneTask*(int, LaneTask*, long)>& next) : next_(next), lanes_(static_cast<std::size_t>(lanes)) {
    for (Lane& lane : lanes_) follow_end(lane);
  }

  /// One thread, until all lanes are closed.
  void work(int worker) {
    std::unique_lock lock(mutex_);
    try {
      while (!failed_) {
        follow_ends();
        if (Lane* lane = most_behind([](const Lane& l) { return l.has_work(); })) {
          work_on(*lane, worker, lock);
        } else if (most_behind([](const Lane& l) { return l.open(); }) == nullptr) {
          return;
        } else {
          changed_.wait(lock);
        }
      }
    } catch (...) {
      if (!lock.owns_lock()) lock.lock();
      failed_ = true;
      changed_.notify_all();
      throw;
    }
  }

 private:
  template <class Fits>
  Lane* most_behind(const Fits& fits) {
    Lane* out = nullptr;
    for (Lane& lane : lanes_) {
      if (fits(lane) && (out == nullptr || lane.clock < out->clock)) out = &lane;
    }
    return out;
  }

  /// Ends that no other lane can come before any more.
  void follow_ends() {
    const auto open = [](const Lane& l) { return l.open(); };
    for (Lane* lane = most_behind(open); lane != nullptr && lane->stage == Lane::Stage::Ended; lane = most_behind(open)) follow_end(*lane);
  }

  void follow_end(Lane& lane) {
    lane.task = next_(static_cast<int>(&lane - lanes_.data()), lane.task, lane.clock);
    lane.stage = lane.task == nullptr ? Lane::Stage::Closed : Lane::Stage::Turn;
    if (lane.task != nullptr) lane.start = lane.clock - lane.task->cost();
    changed_.notify_all();
  }

  void work_on(Lane& lane, int worker, std::unique_lock<std::mutex>& lock) {
    if (lane.stage == Lane::Stage::Turn) {
      lane.stage = Lane::Stage::InTurn;
      lock.unlock();
      const int items = lane.task->turn(worker);
      const long cost = lane.task->cost();
      lock.lock();
      lane.clock = lane.start + cost;
      lane.items = items;
      lane.begun = lane.done = 0;
      lane.stage = items > 0 ? Lane::Stage::Round : Lane::Stage::Ended;
      changed_.notify_all();
    } else {
      const int item = lane.begun++;
      lock.unlock();
      lane.task->work(item, worker);
      lock.lock();
      if (++lane.done < lane.items) return;
      lane.stage = Lane::Stage::Turn;
      changed_.notify_all();
    }
  }

  const std::function<LaneTask*(int, LaneTask*, long)>& next_;
  std::vector<Lane> lanes_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool failed_ = false;
};

}  // namespace

void run_lanes(ThreadPool& pool, int lanes, const std::function<LaneTask*(int lane, LaneTask* ended, long clock)>& next) {
  Lanes run(lanes, next);
  pool.run(pool.size(), [&run](int, int worker) { run.work(worker); });
}

}  // namespace stiction::core
