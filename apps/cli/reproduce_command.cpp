#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "python_start.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;

struct ReproduceArguments {
  std::string name;
  std::string out_dir = "reproduction";
  std::string docs;
  bool quick = false;
  bool json = false;
};

/// Numbers of a name, so that figure-2.3 comes before figure-2.13.
std::vector<int> numbers_of(const std::string& name) {
  std::vector<int> out;
  for (std::size_t at = name.find('-'); at != std::string::npos; at = name.find('.', at + 1))
    out.push_back(std::atoi(name.c_str() + at + 1));
  return out;
}

}  // namespace

std::vector<std::string> list_experiments() {
  std::vector<std::string> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(experiments_dir() / "experiments", error)) {
    std::string name = entry.path().stem().string();
    const bool known =
        name.starts_with("figure_") || name.starts_with("table_") || name.starts_with("section_") || name.starts_with("errata_");
    if (!known || entry.path().extension() != ".py") continue;
    std::replace(name.begin(), name.end(), '_', '.');
    name[name.find('.')] = '-';
    out.push_back(name);
  }
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) {
    const auto x = numbers_of(a), y = numbers_of(b);
    return x != y ? x < y : a < b;
  });
  return out;
}

namespace {

int run_reproduce(const ReproduceArguments& arguments) {
  const auto names = list_experiments();
  if (arguments.name != "all" && std::find(names.begin(), names.end(), arguments.name) == names.end())
    core::throw_invalid("name", fmt::format("'{}'", arguments.name), fmt::format("one of {}, or 'all'", fmt::join(names, ", ")));
  std::vector<std::string> words = {"experiments", arguments.name, "-o", arguments.out_dir};
  if (arguments.quick) words.emplace_back("--quick");
  if (!arguments.docs.empty()) words.insert(words.end(), {"--docs", arguments.docs});
  catch_signals();  // the child ends on Ctrl-C and says so; what was computed until then stays
  const int code = run_python("reproduce", Packages::Experiments, words);
  if (code == 128 + 2 || code == 128 + 15 || code == kInterrupted) return kInterrupted;
  if (code != kDone && code != kCheckFailed) return kInternalError;
  if (arguments.json) {
    std::ifstream file(fs::path(arguments.out_dir) / "report.json");
    say(stdout, "{}\n", nlohmann::ordered_json::parse(file).dump());
  }
  return code;
}

}  // namespace

Run declare_reproduce(CLI::App& command) {
  const auto arguments = std::make_shared<ReproduceArguments>();
  ReproduceArguments& a = *arguments;
  command.add_option("name", a.name, fmt::format("Figure or table to compute, one of {}, or 'all'", fmt::join(list_experiments(), ", ")))
      ->required();
  command.add_option("-o,--out", a.out_dir, "Folder for data, pictures and report.html")->capture_default_str();
  command.add_flag("--quick", a.quick, "Compute fewer and coarser points, which takes seconds");
  command.add_option("--docs", a.docs, "Markdown page to write as well, with its pictures beside it");
  add_json(command, a.json);
  return [arguments] { return run_reproduce(*arguments); };
}

}  // namespace stiction::app
