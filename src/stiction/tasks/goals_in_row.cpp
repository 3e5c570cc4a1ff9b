#include "stiction/tasks/goals_in_row.hpp"

#include <fmt/format.h>

#include <string_view>

#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/task_sections.hpp"

namespace stiction::tasks {
namespace {

namespace fs = std::filesystem;
using planning::PlanningProblem;
using world::YamlNode;

/// The task with its objects at the previous goal.
Task after(const Task& task, const std::vector<PlanningProblem>& before) {
  Task out = task;
  if (!before.empty()) out.problem.q_start.head(before.back().q_goal.size()) = before.back().q_goal;
  return out;
}

void finish(Task& task) {
  if (const auto bystanders = task.document.find("bystanders")) read_bystanders(*bystanders, *task.model, task.problem);
  task.problem.validate();
}

void read_one(const YamlNode& node, Task& task) {
  if (node.is_map()) {
    task.problem.goal.region.reset();
    return read_goal(node, *task.model, task.problem);
  }
  if (!node.is_sequence()) node.fail("a list of numbers, or what the goal of a task may be");
  std::vector<std::optional<double>> values;
  for (const YamlNode& item : node.items())
    values.push_back(item.kind() == YamlNode::Kind::Null ? std::nullopt : std::optional(item.number()));
  set_goal(task, values);
}

std::string_view without(std::string_view text, std::string_view prefix) {
  return text.starts_with(prefix) ? text.substr(prefix.size()) : text;
}

/// @param tell  makes the message from the number of the goal and its fault
template <class Tell>
std::vector<PlanningProblem> read_list(const Task& task, const YamlNode& list, std::string_view name, const Tell& tell) {
  if (!list.is_sequence() || list.items().empty())
    core::throw_invalid(name, list.is_sequence() ? "an empty list" : list.describe(), "a list of goals");
  std::vector<PlanningProblem> out;
  const auto items = list.items();
  for (std::size_t i = 0; i < items.size(); ++i) {
    Task next = after(task, out);
    try {
      read_one(items[i], next);
      finish(next);
    } catch (const core::InvalidInput& e) {
      throw core::InvalidInput(tell(items[i], i, items.size(), std::string_view(e.what())));
    }
    out.push_back(std::move(next.problem));
  }
  return out;
}

}  // namespace

std::vector<PlanningProblem> load_goals(const Task& task, const fs::path& file) {
  const auto tell = [&](const YamlNode& node, std::size_t i, std::size_t n, std::string_view what) {
    const std::string here = node.file().string() + ":";
    const std::string rest =
        what.starts_with(here) ? std::string(what.substr(here.size())) : fmt::format("{}: {}", node.line(), without(what, "goal: "));
    return fmt::format("goal {} of {} in {}{}", i + 1, n, here, rest);
  };
  return read_list(task, YamlNode::load(file), file.string(), tell);
}

std::vector<PlanningProblem> parse_goals(const Task& task, const std::string& text, const std::string& name) {
  const auto tell = [&](const YamlNode& node, std::size_t, std::size_t, std::string_view what) {
    return what.starts_with(node.path()) ? fmt::format("{}{}", name, what)
                                         : fmt::format("{}{}: {}", name, node.path(), without(what, "goal: "));
  };
  return read_list(task, YamlNode::parse(text, fs::current_path() / ""), name, tell);
}

std::vector<PlanningProblem> make_goals(const Task& task, const std::vector<std::vector<std::optional<double>>>& goals,
                                        const std::string& name) {
  std::vector<PlanningProblem> out;
  for (std::size_t i = 0; i < goals.size(); ++i) {
    Task next = after(task, out);
    try {
      set_goal(next, goals[i]);
      if (goals.size() > 1) finish(next);
    } catch (const core::InvalidInput& e) {
      if (goals.size() == 1) throw;
      throw core::InvalidInput(fmt::format("{} {} of {}: {}", name, i + 1, goals.size(), without(e.what(), "goal: ")));
    }
    out.push_back(std::move(next.problem));
  }
  return out;
}

}  // namespace stiction::tasks
