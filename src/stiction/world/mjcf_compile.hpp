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

/// What MuJoCo makes of an MJCF. The text stands for `file`, beside which includes and meshes are found. @param name  of the file in messages
/// @param notes  grows by what was left out  @throws core::InvalidInput
CompiledMjcf compile_mjcf(const std::string& text, const std::filesystem::path& file, const std::filesystem::path& name,
                          std::vector<std::string>& notes);

}  // namespace stiction::world
