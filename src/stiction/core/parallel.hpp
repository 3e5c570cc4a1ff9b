#pragma once

#include <functional>
#include <memory>

namespace stiction::core {

/// A fixed set of worker threads. run() calls body(item, worker) for item = 0 … n−1 with worker in {0 … size()−1}; items are
/// handed out in order, so which worker takes which item varies: results must not depend on it.
/// An exception of a body is thrown again from run(), the one of the smallest item first.
class ThreadPool {
 public:
  explicit ThreadPool(int threads);  ///< ≥ 1; 1 runs everything on the calling thread
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int size() const;
  void run(int n, const std::function<void(int item, int worker)>& body);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Number of hardware threads, at least 1.
int hardware_threads();

}  // namespace stiction::core
