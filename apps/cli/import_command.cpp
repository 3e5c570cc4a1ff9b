#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>

#include "app.hpp"
#include "import_command.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/import_scene.hpp"
#include "stiction/tasks/task.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;

struct ImportArguments {
  std::string file, out, object;
};

int run_import(const ImportArguments& arguments) {
  const fs::path out = arguments.out;
  const fs::path folder = out.empty() || !out.has_parent_path() ? fs::current_path() : out.parent_path();
  const std::string text = tasks::import_scene(arguments.file, folder, arguments.object);
  print_notes(tasks::parse_task(text, folder));
  if (out.empty()) {
    say(stdout, "{}", text);
    return kDone;
  }
  if (fs::exists(out)) core::throw_invalid("-o", fmt::format("'{}', which is there already", out.string()), "a file that is not there");
  std::ofstream file(out, std::ios::binary);
  file << text;
  file.close();
  if (!file) core::throw_invalid("-o", fmt::format("'{}', which cannot be written", out.string()), "a file in a folder that is there");
  say(stdout, "{}: edit its goal, then `stiction lint {}` and `stiction plan {}`\n", out.string(), out.string(), out.string());
  return kDone;
}

}  // namespace

Run declare_import(CLI::App& command) {
  const auto arguments = std::make_shared<ImportArguments>();
  command.add_option("file", arguments->file, "MJCF or URDF file with a robot and objects")->required();
  command.add_option("-o,--out", arguments->out, "Task file to write; without it the task goes to stdout");
  command.add_option("--object", arguments->object, "Object that the goal moves; left out: the first one");
  return [arguments] { return run_import(*arguments); };
}

}  // namespace stiction::app
