#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app.hpp"
#include "stiction/tasks/lint.hpp"

namespace stiction::app {
namespace {

struct LintArguments {
  std::string task;
  std::string goal;
  bool json = false;
};

int run_lint(const LintArguments& arguments) {
  tasks::Task task = tasks::load_task(arguments.task, data_dirs());
  if (!arguments.goal.empty()) tasks::set_goal(task, parse_numbers("--goal", arguments.goal));
  const auto findings = tasks::lint(task);
  std::FILE* const to = people(arguments.json);
  say(to, "{}: {}\n", task.name,
      findings.empty() ? "nothing found" : fmt::format("{} finding{}", findings.size(), findings.size() == 1 ? "" : "s"));
  for (const auto& finding : findings) say(to, "  {:12} {}\n", finding.kind, finding.message);
  if (arguments.json) {
    nlohmann::ordered_json out;
    out["status"] = findings.empty() ? "Passed" : "Failed";
    out["task"] = task.name;
    out["findings"] = nlohmann::ordered_json::array();
    for (const auto& finding : findings) out["findings"].push_back({{"kind", finding.kind}, {"message", finding.message}});
    say(stdout, "{}\n", out.dump());
  }
  return findings.empty() ? kDone : kCheckFailed;
}

}  // namespace

void print_warnings(const std::vector<tasks::Finding>& findings) {
  for (const auto& finding : findings) say(stderr, "stiction: warning: {}\n", finding.message);
}

Run declare_lint(CLI::App& command) {
  const auto arguments = std::make_shared<LintArguments>();
  LintArguments& a = *arguments;
  add_task(command, a.task);
  add_goal(command, a.goal);
  add_json(command, a.json);
  return [arguments] { return run_lint(*arguments); };
}

}  // namespace stiction::app
