#include "stiction/world/mjcf_compile.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/call_mujoco.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/mjcf_numbers.hpp"
#include "stiction/world/mjcf_repair.hpp"

namespace stiction::world {
namespace {

struct Delete {
  void operator()(mjVFS* files) const { mj_deleteVFS(files); }
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
};

[[noreturn]] void fail_mjcf(const std::filesystem::path& file, std::string_view got, std::string_view expected) {
  throw core::InvalidInput(fmt::format("{}: mjcf: got {}, expected {}", file.string(), got, expected));
}

/// Lets MuJoCo choose all sizes: those of a file are for its simulation, and may be gigabytes.
void leave_out_sizes(mjSpec& spec) {
  spec.memory = spec.nstack = -1;
  spec.njmax = spec.nconmax = -1;
  spec.nuserdata = 0;
  for (int* size : {&spec.nuser_body, &spec.nuser_jnt, &spec.nuser_geom, &spec.nuser_site, &spec.nuser_cam, &spec.nuser_tendon,
                    &spec.nuser_actuator, &spec.nuser_sensor})
    *size = -1;
}

}  // namespace

CompiledMjcf compile_mjcf(const std::string& text, const std::filesystem::path& folder, const std::filesystem::path& name,
                          std::vector<std::string>& notes) {
  mjVFS files;
  mj_defaultVFS(&files);
  const std::unique_ptr<mjVFS, Delete> cleared(&files);
  // MuJoCo tells files in memory apart by their last name alone, and a file may include one of its own name in another folder.
  const std::filesystem::path file = folder / ".text.xml";
  if (mj_addBufferVFS(&files, file.c_str(), text.data(), static_cast<int>(text.size())) != 0)
    fail_mjcf(name, "a text that MuJoCo does not take", "an MJCF");
  char error[1024] = "";
  mjSpec* parsed = nullptr;
  auto report = call_mujoco([&] { parsed = mj_parseXML(file.c_str(), &files, error, sizeof(error)); });
  const std::unique_ptr<mjSpec, Delete> spec(parsed);
  const auto refuse = [&](std::string said) {
    std::replace(said.begin(), said.end(), '\n', ' ');
    while (said.ends_with(' ')) said.pop_back();
    fail_mjcf(name, fmt::format("'{}'", said), "a file that MuJoCo compiles");
  };
  if (parsed == nullptr) refuse(report.failed ? report.error : error);
  leave_out_sizes(*parsed);
  leave_out_missing_files(parsed, notes);
  parsed->compiler.usethread = 0;  // call_mujoco() does not receive messages of other threads
  mjModel* compiled = nullptr;
  const auto compile = [&] {
    report = call_mujoco([&] { compiled = mj_compile(parsed, &files); });
    const char* reason = mjs_getError(parsed);
    return compiled != nullptr ? "" : report.failed ? report.error : std::string(reason != nullptr ? reason : "");
  };
  std::string said = compile();
  if (compiled == nullptr && !report.failed && leave_out_cube_textures(parsed, notes)) said = compile();
  if (compiled == nullptr) refuse(said);
  CompiledMjcf model(compiled);
  if (line_of_foreign_bytes({model->names, static_cast<std::size_t>(model->nnames)}))
    fail_mjcf(name, "names with bytes that are not UTF-8, in a file that it includes", "UTF-8");
  require_numbers(*model, name);
  if (const std::string note = find_unstated_degrees(parsed, *model); !note.empty()) notes.push_back(note);
  return model;
}

}  // namespace stiction::world
