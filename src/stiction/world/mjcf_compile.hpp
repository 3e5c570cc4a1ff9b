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

/// Compiles the text of an MJCF with MuJoCo. @param folder  folder for includes and meshes
/// @param name   name of the file in messages
/// @param notes  receives a note on everything that was left out  @throws core::InvalidInput
CompiledMjcf compile_mjcf(const std::string& text, const std::filesystem::path& folder, const std::filesystem::path& name,
                          std::vector<std::string>& notes);

}  // namespace stiction::world
