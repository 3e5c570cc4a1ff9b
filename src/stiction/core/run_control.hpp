#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>

#include "stiction/core/status.hpp"

namespace stiction::core {

/// Progress that a long run reports between iterations.
struct Progress {
  long iteration = 0;
  double fraction = 0.0;                      ///< share of the budget that is used, in [0, 1]
  double best = 0.0;                          ///< figure of merit so far; smaller is better (for a planner: distance to the goal)
  long size = 0;                              ///< number of nodes, samples …
  std::optional<double> cost = std::nullopt;  ///< cost of the best solution, while the run continues to improve it
  double elapsed_s = 0.0;
};

/// Lets a caller stop and watch a long run. The run checks it between iterations; when stopped, it returns its best result so far.
struct RunControl {
  using Clock = std::chrono::steady_clock;

  const std::atomic<bool>* cancel = nullptr;  ///< set from a signal handler or another thread
  std::function<bool()> abandoned = nullptr;  ///< returns true if the run is no longer needed; acts as a cancellation
  std::optional<Clock::time_point> deadline;
  std::function<void(const Progress&)> on_progress;

  bool cancelled() const { return (cancel != nullptr && cancel->load(std::memory_order_relaxed)) || (abandoned && abandoned()); }
  bool expired() const { return deadline && Clock::now() >= *deadline; }
  bool stop() const { return cancelled() || expired(); }
  /// Status of a run that did not reach its end: Cancelled if it was cancelled, else MaxIterations.
  Status status_when_stopped() const { return cancelled() ? Status::Cancelled : Status::MaxIterations; }
};

inline double seconds_since(RunControl::Clock::time_point start) {
  return std::chrono::duration<double>(RunControl::Clock::now() - start).count();
}

}  // namespace stiction::core
