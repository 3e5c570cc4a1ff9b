#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "app.hpp"
#include "import_command.hpp"
#include "python_start.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/import_scene.hpp"
#include "stiction/tasks/task.hpp"
#include "stiction/world/encoding.hpp"

namespace stiction::app {
namespace {

namespace fs = std::filesystem;

struct ImportArguments {
  std::string file, out, object;
};

bool is_sdf(const fs::path& file) {
  std::ifstream text(file, std::ios::binary);
  return world::find_root(text) == "sdf";
}

void require_new(const fs::path& file) {
  if (fs::exists(file)) core::throw_invalid("-o", fmt::format("'{}', which is there already", file.string()), "a file that is not there");
  if (file.has_parent_path() && !fs::is_directory(file.parent_path()))
    core::throw_invalid("-o", fmt::format("'{}', whose folder does not exist", file.string()), "a file in a folder that is there");
}

/// Where the MJCF of an SDF is written.
fs::path mjcf_beside(const fs::path& out, const fs::path& file) {
  if (out.empty())
    core::throw_invalid("-o", "none", fmt::format("a task file, beside which the MJCF of {} is written", file.filename().string()));
  fs::path mjcf = out;
  mjcf.replace_extension(".xml");
  require_new(mjcf);
  return mjcf;
}

int run_import(const ImportArguments& arguments) {
  const fs::path out = arguments.out == "-" ? "" : arguments.out;
  const fs::path folder = out.empty() || !out.has_parent_path() ? fs::current_path() : out.parent_path();
  fs::path file = arguments.file;
  if (!out.empty()) require_new(out);
  if (is_sdf(file)) {
    const fs::path mjcf = mjcf_beside(out, file);
    const int code = run_python("import", Packages::Module, {"stiction", "sdf", file.string(), mjcf.string()});
    if (code != kDone) return code;  // it has said why
    file = mjcf;
  }
  const std::string text = tasks::import_scene(file, folder, arguments.object);
  print_notes(tasks::parse_task(text, folder));
  if (out.empty()) {
    say(stdout, "{}", text);
    return kDone;
  }
  tasks::write_text(text, out);
  say(stdout, "wrote {}: edit its goal, then run `stiction lint {}` and `stiction plan {}`\n", out.string(), out.string(), out.string());
  return kDone;
}

}  // namespace

Run declare_import(CLI::App& command) {
  const auto arguments = std::make_shared<ImportArguments>();
  command
      .add_option("file", arguments->file,
                  "MJCF, URDF or SDF file with a robot and objects; an SDF file is converted to an MJCF file beside the task")
      ->required();
  command.add_option("-o,--out", arguments->out, "Task file to write (default, or -: print the task on stdout)");
  command.add_option("--object", arguments->object, "Name of the object that the goal moves (default: the first object)");
  return [arguments] { return run_import(*arguments); };
}

}  // namespace stiction::app
