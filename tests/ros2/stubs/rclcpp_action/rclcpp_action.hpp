#pragma once

// What the package uses of rclcpp_action, with the signatures of Jazzy; for tests a server takes a goal by `ask` and keeps its handle.
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "rclcpp/rclcpp.hpp"

namespace rclcpp_action {

using GoalUUID = std::array<std::uint8_t, 16>;
enum class GoalResponse {
  REJECT,
  ACCEPT_AND_EXECUTE,
  ACCEPT_AND_DEFER
};
enum class CancelResponse {
  REJECT,
  ACCEPT
};

template <class Action>
class ServerGoalHandle {
 public:
  using Result = std::shared_ptr<typename Action::Result>;
  explicit ServerGoalHandle(std::shared_ptr<const typename Action::Goal> goal) : goal_(std::move(goal)) {}
  std::shared_ptr<const typename Action::Goal> get_goal() const { return goal_; }
  bool is_canceling() const { return canceling.load(); }
  void publish_feedback(const std::shared_ptr<typename Action::Feedback>& message) {
    const std::scoped_lock lock(mutex_);
    feedback.push_back(*message);
  }
  void succeed(const Result& of) { end("succeeded", of); }
  void abort(const Result& of) { end("aborted", of); }
  void canceled(const Result& of) { end("canceled", of); }

  // ---- for tests
  typename Action::Result wait() {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return !how.empty(); });
    return result;
  }
  std::atomic<bool> canceling{false};
  std::vector<typename Action::Feedback> feedback;
  std::string how;
  typename Action::Result result;

 private:
  void end(const char* what, const Result& of) {
    const std::scoped_lock lock(mutex_);
    how = what;
    result = *of;
    ended_.notify_all();
  }
  std::shared_ptr<const typename Action::Goal> goal_;
  std::mutex mutex_;
  std::condition_variable ended_;
};

template <class Action>
struct Server {
  using SharedPtr = std::shared_ptr<Server>;
  using Handle = std::shared_ptr<ServerGoalHandle<Action>>;
  std::function<GoalResponse(const GoalUUID&, std::shared_ptr<const typename Action::Goal>)> on_goal;
  std::function<CancelResponse(Handle)> on_cancel;
  std::function<void(Handle)> on_accepted;

  /// What a client does. @returns null: refused
  Handle ask(const typename Action::Goal& goal) const {
    const auto shared = std::make_shared<const typename Action::Goal>(goal);
    if (on_goal({}, shared) == GoalResponse::REJECT) return nullptr;
    const auto handle = std::make_shared<ServerGoalHandle<Action>>(shared);
    on_accepted(handle);
    return handle;
  }
};

template <class Action, class OnGoal, class OnCancel, class OnAccepted>
typename Server<Action>::SharedPtr create_server(const rclcpp::Node::SharedPtr& node, const std::string& name, OnGoal on_goal,
                                                 OnCancel on_cancel, OnAccepted on_accepted) {
  const auto out = std::make_shared<Server<Action>>(Server<Action>{on_goal, on_cancel, on_accepted});
  node->topics["action:" + name] = out;
  return out;
}

}  // namespace rclcpp_action
