#pragma once

#include <atomic>
#include <chrono>
#include <exception>

#include "bindings.hpp"
#include "stiction/core/run_control.hpp"

namespace stiction::python {

using Callback = std::optional<nb::typed<nb::callable, std::optional<bool>(core::Progress)>>;

/// Lets Ctrl-C and the caller's function stop a run that goes on without Python's lock. False of the function keeps what was found so far,
/// an error in it is that of the call.
class Watcher {
 public:
  explicit Watcher(const Callback& callback) : callback_(callback) {}

  /// What stops the run: this, or the time.
  core::RunControl control(double timeout_s) {
    core::RunControl out;
    out.cancel = &cancel_;
    out.deadline = deadline_in(timeout_s);
    out.on_progress = [this](const core::Progress& progress) { see(progress); };
    return out;
  }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

  /// Calls something of the caller's under Python's lock; an error in it, or Ctrl-C, stops the run.
  template <class Call>
  void ask(const Call& call) {
    if (error_) return;
    const nb::gil_scoped_acquire locked;
    try {
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      call();
    } catch (...) {
      error_ = std::current_exception();
      cancel_.store(true);
    }
  }

 private:
  void see(const core::Progress& progress) {
    ask([&] {
      if (callback_ && is_false((*callback_)(progress))) cancel_.store(true);
    });
  }

  const Callback& callback_;
  std::exception_ptr error_;
  std::atomic<bool> cancel_{false};
};

/// Ctrl-C ends a run that asks whether it is abandoned, without Python's lock. Threads may ask; Python takes signals in its main thread only.
class Interrupt {
 public:
  /// What stops the run: this, or the time. None: as long as it takes.
  core::RunControl control(std::optional<double> timeout_s) {
    core::RunControl out;
    if (timeout_s) out.deadline = deadline_in(*timeout_s);
    out.abandoned = [this] { return has_come(); };  // asked once a tick
    return out;
  }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  using Clock = core::RunControl::Clock;

  bool has_come() {
    if (has_come_) return true;
    const Clock::time_point now = Clock::now();
    if (now < next_.load(std::memory_order_relaxed)) return false;
    next_.store(now + std::chrono::milliseconds(10), std::memory_order_relaxed);  // Python's lock takes longer than a tick
    const nb::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() == 0) return has_come_;
    error_ = std::make_exception_ptr(nb::python_error());
    has_come_ = true;
    return true;
  }

  std::exception_ptr error_;
  std::atomic<bool> has_come_{false};
  std::atomic<Clock::time_point> next_{Clock::time_point{}};
};

}  // namespace stiction::python
