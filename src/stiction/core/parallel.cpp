#include "stiction/core/parallel.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

#include "stiction/core/invalid_input.hpp"

namespace stiction::core {
namespace {

using Body = std::function<int(int, int, const ThreadPool::Turn&)>;

struct Job {
  const Body& body;
  const ThreadPool::Turn* outer;
  int place;                ///< item of the outermost run that this run belongs to; −1 for the outermost run itself
  std::atomic<int> needed;  ///< number of items that are needed
  int begun = 0, running = 0;
  std::exception_ptr error = nullptr;
  int error_item = std::numeric_limits<int>::max();

  bool has_items() const { return begun < needed; }
};

}  // namespace

struct ThreadPool::Impl {
  std::vector<std::thread> threads;
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Job*> jobs;
  bool quit = false;

  /// Returns a run that has an item to begin: the outermost run, else the inner run of the smallest item.
  Job* find_work() const {
    Job* out = nullptr;
    for (Job* job : jobs) {
      if (job->has_items() && (out == nullptr || job->place < out->place)) out = job;
    }
    return out;
  }

  void do_item(Job& job, int worker, std::unique_lock<std::mutex>& lock) {
    Turn turn;
    turn.needed = &job.needed;
    turn.item = job.begun++;
    turn.worker = worker;
    turn.outer = job.outer;
    ++job.running;
    lock.unlock();
    int needed = std::numeric_limits<int>::max();
    std::exception_ptr error;
    try {
      needed = job.body(turn.item, worker, turn);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    if (error && turn.item < job.error_item) {
      job.error_item = turn.item;
      job.error = error;
    }
    if (turn.item < job.needed) job.needed = std::min(job.needed.load(), std::max(needed, turn.item + 1));
    if (--job.running == 0 && !job.has_items()) changed.notify_all();
  }

  void loop(int worker) {
    std::unique_lock lock(mutex);
    while (!quit) {
      if (Job* job = find_work()) {
        do_item(*job, worker, lock);
      } else {
        changed.wait(lock);
      }
    }
  }
};

bool ThreadPool::Turn::over() const { return item >= needed->load(std::memory_order_relaxed) || (outer != nullptr && outer->over()); }

ThreadPool::ThreadPool(int threads) : impl_(std::make_unique<Impl>()) {
  if (threads < 1) throw_invalid("threads", std::to_string(threads), "at least 1");
  if (threads > kMostThreads) throw_invalid("threads", std::to_string(threads), "at most " + std::to_string(kMostThreads));
  for (int worker = 1; worker < threads; ++worker) {
    impl_->threads.emplace_back([this, worker] { impl_->loop(worker); });
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->quit = true;
  }
  impl_->changed.notify_all();
  for (auto& thread : impl_->threads) thread.join();
}

int ThreadPool::size() const { return static_cast<int>(impl_->threads.size()) + 1; }

void ThreadPool::run(int n, const std::function<void(int, int)>& body) {
  run_until(n, [&](int item, int worker, const Turn&) {
    body(item, worker);
    return n;
  });
}

int ThreadPool::run_until(int n, const Body& body, const Turn* outer) {
  int place = -1;
  for (const Turn* turn = outer; turn != nullptr; turn = turn->outer) place = turn->item;
  const int worker = outer != nullptr ? outer->worker : 0;
  Job job{body, outer, place, n};
  Impl& pool = *impl_;
  std::unique_lock lock(pool.mutex);
  pool.jobs.push_back(&job);
  if (!pool.threads.empty()) pool.changed.notify_all();
  while (job.has_items() || job.running > 0) {
    // A thread inside an item takes no item of another run, because its worker's data are in use: it waits.
    if (Job* next = job.has_items() ? &job : outer == nullptr ? pool.find_work() : nullptr) {
      pool.do_item(*next, worker, lock);
    } else {
      pool.changed.wait(lock);
    }
  }
  std::erase(pool.jobs, &job);
  lock.unlock();
  if (job.error && job.error_item < job.needed) std::rethrow_exception(job.error);
  return job.needed;
}

int hardware_threads() { return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMostThreads); }

}  // namespace stiction::core
