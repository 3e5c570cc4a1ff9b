#pragma once

#include <atomic>
#include <functional>
#include <memory>

namespace stiction::core {

/// Most threads of one pool: each may have a workspace.
inline constexpr int kMostThreads = 1024;

/// A fixed set of worker threads. run() calls body(item, worker) for item = 0 … n−1 with worker in {0 … size()−1}. Items are handed out in
/// order, but the worker that takes an item varies from run to run, so results must not depend on the worker.
/// run() throws an exception of a body again; if several bodies throw, the exception of the smallest item.
class ThreadPool {
 public:
  /// An item of run_until() that is being worked on.
  class Turn {
   public:
    bool over() const;  ///< true if the item is no longer needed: its result is discarded

   private:
    friend class ThreadPool;
    const std::atomic<int>* needed = nullptr;  ///< number of items that its run needs
    int item = 0, worker = 0;
    const Turn* outer = nullptr;  ///< turn of the item whose body started the run
  };

  explicit ThreadPool(int threads);  ///< in [1, kMostThreads]; 1 runs everything on the calling thread
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int size() const;
  void run(int n, const std::function<void(int item, int worker)>& body);

  /// Runs items in order and may stop early, for example at the first try that works. Each body returns how many of the n items are needed
  /// given its result. The least value that a needed item returns counts, whatever the order in which items end. An item that is not needed
  /// does not begin; if it has begun, its turn is over(). A body may start an inner run. A thread that finds no item left in this run helps
  /// with the inner run of the smallest item in progress.
  /// @param outer  turn of the item whose body starts this run; nullptr for the outermost run
  /// @returns      number of items that were needed; all of them are done
  int run_until(int n, const std::function<int(int item, int worker, const Turn& turn)>& body, const Turn* outer = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Number of hardware threads, in [1, kMostThreads].
int hardware_threads();

}  // namespace stiction::core
