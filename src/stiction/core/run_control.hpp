#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>

namespace stiction::core {

/// What a long run reports between iterations.
struct Progress {
  long iteration = 0;
  double fraction = 0.0;                      ///< of the budget used, in [0, 1]
  double best = 0.0;                          ///< figure of merit so far; smaller is better (for a planner: distance to the goal)
  long size = 0;                              ///< nodes, samples …
  std::optional<double> cost = std::nullopt;  ///< of the best solution, while a run goes on to improve it
  double elapsed_s = 0.0;
};

/// How a caller stops and watches a long run. The run looks at it between iterations and returns its best result so far.
struct RunControl {
  using Clock = std::chrono::steady_clock;

  const std::atomic<bool>* cancel = nullptr;  ///< set from a signal handler or another thread
  std::function<bool()> abandoned = nullptr;  ///< nothing needs the run any more; as good as cancelled
  std::optional<Clock::time_point> deadline;
  std::function<void(const Progress&)> on_progress;

  bool cancelled() const { return (cancel != nullptr && cancel->load(std::memory_order_relaxed)) || (abandoned && abandoned()); }
  bool expired() const { return deadline && Clock::now() >= *deadline; }
  bool stop() const { return cancelled() || expired(); }
};

inline double seconds_since(RunControl::Clock::time_point start) {
  return std::chrono::duration<double>(RunControl::Clock::now() - start).count();
}

}  // namespace stiction::core
