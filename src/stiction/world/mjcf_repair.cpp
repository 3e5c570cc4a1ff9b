#include "stiction/world/mjcf_repair.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <set>
#include <system_error>

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;

template <class Visit>
void for_each(mjSpec* spec, mjtObj type, const Visit& visit) {
  std::vector<mjsElement*> elements;  // some are deleted on the way
  for (mjsElement* e = mjs_firstElement(spec, type); e != nullptr; e = mjs_nextElement(spec, e)) elements.push_back(e);
  std::for_each(elements.begin(), elements.end(), visit);
}

/// True if an asset names a file that does not exist. The asset may belong to another MJCF, which the file attaches.
bool is_missing(const mjsElement* asset, const mjString* file, mjString* mjsCompiler::*subfolder) {
  const mjSpec* of = mjs_getOriginSpec(asset);
  std::string name = mjs_getString(file);
  if (of->strippath) name.erase(0, name.find_last_of("/\\") + 1);
  const fs::path folder = mjs_getString(of->modelfiledir);
  std::error_code error;
  return !name.empty() && !fs::is_regular_file(folder / mjs_getString(mjs_getCompiler(asset)->*subfolder) / name, error) &&
         !fs::is_regular_file(folder / name, error);
}

/// Replaces the texture by one colour.
void flatten(mjsTexture* texture) {
  texture->builtin = mjBUILTIN_FLAT;
  texture->width = texture->height = 8;
  texture->gridsize[0] = texture->gridsize[1] = 1;
}

}  // namespace

void leave_out_missing_files(mjSpec* spec, std::vector<std::string>& notes) {
  std::set<std::string> missing, needed;
  for_each(spec, mjOBJ_MESH, [&](mjsElement* e) {
    if (is_missing(e, mjs_asMesh(e)->file, &mjsCompiler::meshdir)) missing.insert(mjs_getString(mjs_getName(e)));
  });
  if (!missing.empty()) {
    for_each(spec, mjOBJ_GEOM, [&](mjsElement* e) {
      const mjsGeom* geom = mjs_asGeom(e);
      const std::string mesh = mjs_getString(geom->meshname);
      if (!missing.contains(mesh)) return;
      if ((geom->contype | geom->conaffinity) != 0)
        needed.insert(mesh);  // a colliding geom needs the mesh: MuJoCo reports the missing file
      else
        mjs_delete(spec, e);
    });
    std::vector<std::string> names;
    for_each(spec, mjOBJ_MESH, [&](mjsElement* e) {
      const std::string name = mjs_getString(mjs_getName(e));
      if (!missing.contains(name) || needed.contains(name)) return;
      names.push_back(name);
      mjs_delete(spec, e);
    });
    if (!names.empty())
      notes.push_back(
          fmt::format("meshes whose files are missing are left out: what is only seen by them is not shown, and weighs nothing "
                      "where its body states no inertia: {}",
                      list_some(names)));
  }
  std::vector<std::string> textures;
  for_each(spec, mjOBJ_TEXTURE, [&](mjsElement* e) {
    mjsTexture* texture = mjs_asTexture(e);
    if (!is_missing(e, texture->file, &mjsCompiler::texturedir)) return;
    textures.push_back(mjs_getString(texture->file));
    mjs_setString(texture->file, "");
    flatten(texture);
  });
  if (!textures.empty())
    notes.push_back(fmt::format("textures whose files are missing, of which nothing is shown: {}", list_some(textures)));
}

bool leave_out_cube_textures(mjSpec* spec, std::vector<std::string>& notes) {
  std::vector<std::string> names;
  for_each(spec, mjOBJ_TEXTURE, [&](mjsElement* e) {
    mjsTexture* texture = mjs_asTexture(e);
    if (texture->type == mjTEXTURE_2D || texture->builtin != mjBUILTIN_NONE || mjs_getString(texture->file)[0] != '\0') return;
    names.push_back(mjs_getString(mjs_getName(e)));
    for (int side = 0; side < 6; ++side) mjs_setInStringVec(texture->cubefiles, side, "");
    flatten(texture);
  });
  if (names.empty()) return false;
  notes.push_back(fmt::format("textures of cubes, of which nothing is shown since a file could not be opened: {}", list_some(names)));
  return true;
}

std::string find_unstated_degrees(mjSpec* spec, const mjModel& model) {
  constexpr double kDegrees = 180 / std::numbers::pi, kLargest = 2 * std::numbers::pi;
  constexpr std::uint64_t kAngle = 1u << 6;  // the bit of `degree`, the seventh field of mjsCompiler, in its field `authored`
  std::vector<std::string> names;
  for_each(spec, mjOBJ_JOINT, [&](mjsElement* e) {
    const int j = mjs_getId(e);
    if (model.jnt_type[j] != mjJNT_HINGE || !model.jnt_limited[j] || (mjs_getCompiler(e)->authored & kAngle) != 0) return;
    const double lower = model.jnt_range[2 * j] * kDegrees, upper = model.jnt_range[2 * j + 1] * kDegrees;
    if (std::max(std::abs(lower), std::abs(upper)) > kLargest * 1.001) return;
    const char* name = mj_id2name(&model, mjOBJ_JOINT, j);
    names.push_back(fmt::format("{} [{:.3g}, {:.3g}]", name != nullptr ? name : fmt::format("#{}", j), lower, upper));
  });
  if (names.empty()) return "";
  return fmt::format(
      "no <compiler angle=\"…\"> says what angles are written in, so that these ranges are in degrees: {}; write "
      "<compiler angle=\"radian\"/> where they are radians",
      list_some(names));
}

}  // namespace stiction::world
