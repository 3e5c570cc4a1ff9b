#include "stiction/core/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

#include "stiction/core/invalid_input.hpp"

namespace stiction::core {

struct ThreadPool::Impl {
  std::vector<std::thread> threads;
  std::mutex mutex;
  std::condition_variable start;
  std::condition_variable done;
  long generation = 0;
  int busy = 0;
  bool quit = false;
  int n = 0;
  const std::function<void(int, int)>* body = nullptr;
  std::atomic<int> next{0};
  std::exception_ptr error;
  int error_item = std::numeric_limits<int>::max();

  void work(int worker) {
    for (int item = next.fetch_add(1); item < n; item = next.fetch_add(1)) {
      try {
        (*body)(item, worker);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (item < error_item) {
          error_item = item;
          error = std::current_exception();
        }
      }
    }
  }

  void loop(int worker) {
    long seen = 0;
    for (;;) {
      {
        std::unique_lock lock(mutex);
        start.wait(lock, [&] { return quit || generation != seen; });
        if (quit) return;
        seen = generation;
      }
      work(worker);
      const std::lock_guard lock(mutex);
      if (--busy == 0) done.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads) : impl_(std::make_unique<Impl>()) {
  if (threads < 1) throw_invalid("threads", std::to_string(threads), "at least 1");
  for (int worker = 1; worker < threads; ++worker) {
    impl_->threads.emplace_back([this, worker] { impl_->loop(worker); });
  }
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->quit = true;
  }
  impl_->start.notify_all();
  for (auto& thread : impl_->threads) thread.join();
}

int ThreadPool::size() const { return static_cast<int>(impl_->threads.size()) + 1; }

void ThreadPool::run(int n, const std::function<void(int, int)>& body) {
  Impl& pool = *impl_;
  {
    const std::lock_guard lock(pool.mutex);
    pool.n = n;
    pool.body = &body;
    pool.next = 0;
    pool.error = nullptr;
    pool.error_item = std::numeric_limits<int>::max();
    pool.busy = static_cast<int>(pool.threads.size());
    ++pool.generation;
  }
  if (!pool.threads.empty()) pool.start.notify_all();
  pool.work(0);
  std::unique_lock lock(pool.mutex);
  pool.done.wait(lock, [&] { return pool.busy == 0; });
  if (pool.error) std::rethrow_exception(pool.error);
}

int hardware_threads() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

}  // namespace stiction::core
