#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace stiction::world {

struct DeleteModel {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
using CompiledMjcf = std::unique_ptr<mjModel, DeleteModel>;

/// Compiles an MJCF with MuJoCo. The text is the contents of `file`; includes and meshes are found relative to that file.
/// @param name   name of the file in messages
/// @param notes  receives a note on everything that was left out  @throws core::InvalidInput
CompiledMjcf compile_mjcf(const std::string& text, const std::filesystem::path& file, const std::filesystem::path& name,
                          std::vector<std::string>& notes);

}  // namespace stiction::world
