#pragma once

// What the package uses of rclcpp, with the signatures of Jazzy. Messages are handed over at once by those who publish.
#include <any>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "messages.hpp"

namespace rclcpp {

class Duration {
 public:
  static Duration from_seconds(double seconds) { return Duration(seconds); }
  double seconds() const { return seconds_; }

 private:
  explicit Duration(double seconds) : seconds_(seconds) {}
  double seconds_;
};

class Time {
 public:
  explicit Time(std::int64_t nanoseconds = 0) : seconds_(1e-9 * static_cast<double>(nanoseconds)) {}
  explicit Time(const builtin_interfaces::msg::Time& stamp) : seconds_(stamp.sec + 1e-9 * stamp.nanosec) {}
  double seconds() const { return seconds_; }

 private:
  double seconds_;
};

struct QoS {
  explicit QoS(std::size_t) {}
};
struct SystemDefaultsQoS : QoS {
  SystemDefaultsQoS() : QoS(0) {}
};

/// Lines that were logged, in order.
struct Logger {
  std::shared_ptr<std::vector<std::string>> lines = std::make_shared<std::vector<std::string>>();
};
template <class... Arguments>
void log(const Logger& logger, const char* format, Arguments... arguments) {
  char line[1000];
  if constexpr (sizeof...(arguments) > 0) {
    std::snprintf(line, sizeof line, format, arguments...);
  } else {
    std::snprintf(line, sizeof line, "%s", format);
  }
  logger.lines->push_back(line);
}

class Parameter {
 public:
  using Value = std::variant<std::string, double, std::int64_t, bool>;
  explicit Parameter(Value value) : value_(std::move(value)) {}
  std::string as_string() const { return std::get<std::string>(value_); }
  double as_double() const { return std::get<double>(value_); }

 private:
  Value value_;
};

template <class Message>
struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription>;
  std::function<void(const Message&)> callback;
};
template <class Message>
struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher>;
  std::function<void(const Message&)> sink;
  void publish(const Message& message) const {
    if (sink) sink(message);
  }
};

struct Clock {
  using SharedPtr = std::shared_ptr<Clock>;
  std::function<double()> seconds = [] { return 0.0; };
  Time now() const { return Time(static_cast<std::int64_t>(std::llround(1e9 * seconds()))); }
  bool sleep_for(const Duration& duration) { return !sleep || sleep(duration.seconds()); }
  std::function<bool(double)> sleep;
};

class Node {
 public:
  using SharedPtr = std::shared_ptr<Node>;
  explicit Node(std::string name) : name_(std::move(name)) {}

  template <class T>
  T declare_parameter(const std::string& name, const T& value) {
    const auto known = parameters.try_emplace(name, Parameter::Value(value)).first;
    return std::get<T>(known->second);
  }
  Parameter get_parameter(const std::string& name) const {
    const auto found = parameters.find(name);
    if (found == parameters.end()) throw std::runtime_error("no parameter " + name);
    return Parameter(found->second);
  }
  template <class Message, class Callback>
  typename Subscription<Message>::SharedPtr create_subscription(const std::string& topic, const QoS&, Callback callback) {
    auto out = std::make_shared<Subscription<Message>>();
    out->callback = callback;
    topics[topic] = std::function<void(const Message&)>(callback);
    return out;
  }
  template <class Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string& topic, const QoS&) {
    auto out = std::make_shared<Publisher<Message>>();
    out->sink = [this, topic](const Message& message) {
      const auto found = sinks.find(topic);
      if (found != sinks.end()) std::any_cast<std::function<void(const Message&)>>(found->second)(message);
    };
    return out;
  }
  Logger get_logger() const { return logger; }
  Clock::SharedPtr get_clock() const { return clock; }
  Time now() const { return clock->now(); }
  const char* get_name() const { return name_.c_str(); }

  // ---- for tests
  template <class Message>
  void deliver(const std::string& topic, const Message& message) {
    std::any_cast<std::function<void(const Message&)>>(topics.at(topic))(message);
  }
  std::map<std::string, Parameter::Value> parameters;
  std::map<std::string, std::any> topics, sinks;
  Logger logger;
  Clock::SharedPtr clock = std::make_shared<Clock>();

 private:
  std::string name_;
};

}  // namespace rclcpp

#define RCLCPP_INFO(logger, ...) rclcpp::log(logger, __VA_ARGS__)
#define RCLCPP_WARN(logger, ...) rclcpp::log(logger, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) rclcpp::log(logger, __VA_ARGS__)
