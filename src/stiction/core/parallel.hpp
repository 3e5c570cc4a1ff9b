#pragma once

#include <atomic>
#include <functional>
#include <memory>

namespace stiction::core {

/// A fixed set of worker threads. run() calls body(item, worker) for item = 0 … n−1 with worker in {0 … size()−1}; items are
/// handed out in order, so which worker takes which item varies: results must not depend on it.
/// An exception of a body is thrown again from run(), the one of the smallest item first.
class ThreadPool {
 public:
  /// An item of run_until() under way.
  class Turn {
   public:
    bool over() const;  ///< nothing needs it any more: what the item does is thrown away

   private:
    friend class ThreadPool;
    const std::atomic<int>* needed = nullptr;  ///< items of its run
    int item = 0, worker = 0;
    const Turn* outer = nullptr;  ///< that of the item whose body started the run
  };

  explicit ThreadPool(int threads);  ///< ≥ 1; 1 runs everything on the calling thread
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int size() const;
  void run(int n, const std::function<void(int item, int worker)>& body);

  /// Tries in order, for example until one works: a body returns how many of the n items are needed now that it is known, and the least of what needed ones
  /// return counts, whichever ended first. Items that are not needed do not begin, or are over. A body may start a run of its own: a thread that
  /// finds no items left here helps with that of the smallest item under way.
  /// @param outer  turn of the item that starts the run; nullptr: it is the outermost   @returns items that were needed, all of them done
  int run_until(int n, const std::function<int(int item, int worker, const Turn& turn)>& body, const Turn* outer = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Number of hardware threads, at least 1.
int hardware_threads();

}  // namespace stiction::core
