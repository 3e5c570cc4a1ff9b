#pragma once

#include <mutex>

namespace realtime_tools {

/// The newest value of another thread; the one of ROS never waits in the loop.
template <class T>
class RealtimeBuffer {
 public:
  void writeFromNonRT(const T& value) {
    const std::scoped_lock lock(mutex_);
    new_ = value;
    has_new_ = true;
  }
  T* readFromRT() {
    if (mutex_.try_lock()) {
      if (has_new_) current_ = new_;
      has_new_ = false;
      mutex_.unlock();
    }
    return &current_;
  }

 private:
  std::mutex mutex_;
  T new_{}, current_{};
  bool has_new_ = false;
};

}  // namespace realtime_tools
