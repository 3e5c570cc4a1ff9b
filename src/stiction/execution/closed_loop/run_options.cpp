#include <fmt/format.h>

#include <algorithm>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/closed_loop/run.hpp"

namespace stiction::execution {

std::string_view to_string(RunState state) {
  switch (state) {
    case RunState::Hold:
      return "hold";
    case RunState::Push:
      return "push";
    case RunState::Regrasp:
      return "regrasp";
    case RunState::Replan:
      return "replan";
  }
  return "";
}

std::string_view to_string(RunEnd end) {
  switch (end) {
    case RunEnd::Reached:
      return "Reached";
    case RunEnd::Dropped:
      return "Dropped";
    case RunEnd::NoPlan:
      return "NoPlan";
    case RunEnd::Replans:
      return "Replans";
    case RunEnd::TimeUp:
      return "TimeUp";
    case RunEnd::Deadline:
      return "Deadline";
    case RunEnd::Cancelled:
      return "Cancelled";
    case RunEnd::Silent:
      return "Silent";
    case RunEnd::Unfelt:
      return "Unfelt";
  }
  return "";
}

void RunOptions::validate() const {
  core::require_positive("tick", tick);
  if (!(watch_interval >= tick))
    core::throw_invalid("watch_interval", fmt::format("{:g} s", watch_interval), fmt::format("at least a tick of {:g} s", tick));
  core::require_positive("off_on_the_way", off_on_the_way);
  core::require_positive("off_at_the_end", off_at_the_end);
  core::require_positive("settle_time", settle_time);
  core::require_nonnegative("hold", hold);
  for (const auto& [name, value] : {std::pair("plan_fraction", plan_fraction), {"friction", friction}}) {
    if (!(value > 0 && value <= 1)) core::throw_invalid(name, fmt::format("{:g}", value), "a number in (0, 1]");
  }
  core::require_positive("plan_timeout", plan_timeout);
  if (plan_processor_time) core::require_positive("plan_processor_time", *plan_processor_time);
  core::require_nonnegative("planning_rate", planning_rate);
  if (plan_step_time) core::require_positive("plan_step_time", *plan_step_time);
  if (refusals < 1) core::throw_invalid("refusals", std::to_string(refusals), "at least 1");
  if (replans < 0) core::throw_invalid("replans", std::to_string(replans), "0 or more");
  core::require_positive("duration", duration);
  core::require_positive("speed", speed_factor);
  core::require_positive("silence", silence);
  if (!(absence >= silence))
    core::throw_invalid("absence", fmt::format("{:g} s", absence), fmt::format("at least the silence of {:g} s", silence));
}

long RunResult::goals_reached() const {
  return std::count_if(goals.begin(), goals.end(), [](const RunGoal& g) { return g.reached; });
}

long RunResult::count(planning::SegmentKind kind) const {
  return std::count_if(pieces.begin(), pieces.end(), [kind](const RunPiece& p) { return p.kind == kind; });
}

}  // namespace stiction::execution
