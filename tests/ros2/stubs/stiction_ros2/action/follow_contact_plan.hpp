#pragma once

// As rosidl makes it of action/FollowContactPlan.action.
#include <cstdint>
#include <string>
#include <vector>

namespace stiction_ros2::action {

struct FollowContactPlan {
  struct Goal {
    std::string plan;
    std::vector<double> goal;
    double duration = 0;
  };
  struct Result {
    bool reached = false;
    std::string message;
    double position_error = 0, angle_error = 0, duration = 0;
    std::uint32_t plans = 0;
  };
  struct Feedback {
    double time = 0;
    std::string state;
    double goal_share = 0;
    std::uint32_t plans = 0;
    std::int32_t piece = 0;
  };
};

}  // namespace stiction_ros2::action
