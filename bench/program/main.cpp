#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "commit.hpp"
#include "guard.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/version.hpp"
#include "table.hpp"

namespace stiction::app {
namespace {

std::string machine() {
  std::ifstream in("/proc/cpuinfo");
  std::string text;
  std::string name = "unknown processor";
  int threads = 0;
  while (std::getline(in, text)) {
    if (text.starts_with("processor")) ++threads;
    if (text.starts_with("model name") || text.starts_with("Model")) name = text.substr(std::min(text.find(':') + 2, text.size()));
  }
  return fmt::format("{}, {} threads", name, threads);
}

nlohmann::ordered_json number(std::optional<double> value) { return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(); }

int run_bench(const BenchArguments& arguments) {
  catch_signals();
  BenchTable table(arguments);
  if (arguments.tasks.empty()) {
    for (const auto add : {add_step_rows, add_cone_rows, add_plan_rows, add_sensing_rows, add_control_rows}) add(table);
  } else {
    add_task_rows(table);
  }
  table.line().clear();
  const auto& rows = table.rows();
  if (rows.empty() && !interrupted()) core::throw_invalid("--filter", fmt::format("'{}'", arguments.filter), "part of the name of a row");
  if (arguments.json) {
    nlohmann::ordered_json out;
    out["machine"] = machine();
    out["commit"] = kCommit;
    out["results"] = nlohmann::ordered_json::array();
    for (const auto& row : rows) {
      nlohmann::ordered_json entry;
      entry["name"] = row.name;
      entry["median_s"] = row.median_s;
      entry["p95_s"] = row.p95_s;
      entry["p99_s"] = row.p99_s;
      entry["published_s"] = number(row.reference.published);
      entry["peer_s"] = number(row.reference.peer);
      entry["ratio"] = number(row.reference.published ? std::optional(row.median_s / *row.reference.published) : std::nullopt);
      entry["allocations"] = row.allocations ? nlohmann::ordered_json(*row.allocations) : nlohmann::ordered_json();
      entry["contacts"] = number(row.contacts);
      out["results"].push_back(std::move(entry));
    }
    fmt::print("{}\n", out.dump());
  }
  return interrupted() ? kInterrupted : kDone;
}

void declare_options(CLI::App& command, BenchArguments& a) {
  add_json(command, a.json);
  command.add_option("--filter", a.filter, "Only the rows whose name contains this");
  command.add_option("--task", a.tasks, "Only steps of this task, a built-in one or a file (.yaml); may be given again");
  add_integer(command, "--repeat", a.repeat, "Repetitions of each timing", {1, 1000});
}

}  // namespace
}  // namespace stiction::app

int main(int argc, char** argv) {
  using namespace stiction;
  return app::guard("stiction bench", argc, argv, [&] {
    CLI::App cli("Figures of this machine beside the published ones", "stiction bench");
    cli.set_version_flag("--version", std::string("stiction-bench ") + std::string(core::version()));
    app::BenchArguments arguments;
    app::declare_options(cli, arguments);
    try {
      cli.parse(argc, argv);
    } catch (const CLI::Success& e) {
      return cli.exit(e);
    }
    return app::run_bench(arguments);
  });
}
