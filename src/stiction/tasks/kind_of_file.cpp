#include "stiction/tasks/kind_of_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <string_view>

namespace stiction::tasks {
namespace {

using world::YamlNode;

struct Kind {
  FileKind kind;
  std::string_view name, command;
  std::span<const std::string_view> own_keys;  ///< keys that no other kind has
};

constexpr std::string_view kOfTasks[] = {"planner", "optimize", "bystanders"};
constexpr std::string_view kOfSensing[] = {"sensing", "series", "torques", "contact", "contacts", "base_wrench", "poke"};
constexpr std::string_view kOfControl[] = {"reference", "hand", "hold"};
constexpr std::string_view kOfTouch[] = {"moves", "unknown", "misplaced", "max_touches", "friction_motion"};
constexpr Kind kKinds[] = {{FileKind::Task, "a task", "plan", kOfTasks},
                           {FileKind::Sensing, "a scenario of sensing", "sense", kOfSensing},
                           {FileKind::Control, "a scenario of control", "control", kOfControl},
                           {FileKind::Touch, "a scenario of touch", "touch", kOfTouch}};

bool has_own_keys(const YamlNode& top, const Kind& kind) {
  if (std::ranges::any_of(kind.own_keys, [&](std::string_view key) { return top.has(key); })) return true;
  const auto tolerance = top.find("tolerance");
  return kind.kind == FileKind::Task && top.has("goal") && tolerance && tolerance->is_map();
}

}  // namespace

void refuse_other_kind(const YamlNode& top, FileKind wanted) {
  if (!top.is_map()) return;
  const Kind& expected = *std::ranges::find(kKinds, wanted, &Kind::kind);
  const auto format = top.find("format");
  if (format && format->is_scalar() && format->string() == "stiction-plan")
    top.fail("a plan file", fmt::format("{}; `stiction check` and the other commands for plans read it", expected.name));
  if (has_own_keys(top, expected)) return;
  for (const Kind& other : kKinds) {
    if (other.kind != wanted && has_own_keys(top, other))
      top.fail(other.name, fmt::format("{}; `stiction {}` reads it", expected.name, other.command));
  }
}

}  // namespace stiction::tasks
