#include "stiction/world/mjcf_repair.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cmath>
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

/// True if the text names a file that does not exist.
bool is_missing(const mjString* file, const fs::path& folder, const mjString* subfolder) {
  const std::string name = mjs_getString(file);
  std::error_code error;
  return !name.empty() && !fs::is_regular_file(folder / mjs_getString(subfolder) / name, error) &&
         !fs::is_regular_file(folder / name, error);
}

/// Replaces the texture by one colour.
void flatten(mjsTexture* texture) {
  texture->builtin = mjBUILTIN_FLAT;
  texture->width = texture->height = 8;
  texture->gridsize[0] = texture->gridsize[1] = 1;
}

bool states_angle(const tinyxml2::XMLElement& root, const fs::path& folder, std::set<fs::path>& seen);

bool file_states_angle(const fs::path& file, const fs::path& folder, std::set<fs::path>& seen) {
  tinyxml2::XMLDocument document;
  if (!seen.insert(file.lexically_normal()).second) return false;
  return document.LoadFile(file.c_str()) == tinyxml2::XML_SUCCESS && document.RootElement() != nullptr &&
         states_angle(*document.RootElement(), folder, seen);
}

bool states_angle(const tinyxml2::XMLElement& root, const fs::path& folder, std::set<fs::path>& seen) {
  for (const auto* child = root.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
    const std::string_view name = child->Name();
    if (name == "compiler" && child->Attribute("angle") != nullptr) return true;
    const char* included = name == "include" ? child->Attribute("file") : nullptr;
    if (included != nullptr && file_states_angle(folder / included, folder, seen)) return true;
    if (states_angle(*child, folder, seen)) return true;
  }
  return false;
}

}  // namespace

void leave_out_missing_files(mjSpec* spec, const fs::path& folder, std::vector<std::string>& notes) {
  std::set<std::string> missing, needed;
  for_each(spec, mjOBJ_MESH, [&](mjsElement* e) {
    if (is_missing(mjs_asMesh(e)->file, folder, spec->compiler.meshdir)) missing.insert(mjs_getString(mjs_getName(e)));
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
    if (!is_missing(texture->file, folder, spec->compiler.texturedir)) return;
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

std::string find_unstated_degrees(const mjModel& model, const std::string& text, const fs::path& file) {
  constexpr double kDegrees = 180 / std::numbers::pi, kLargest = 2 * std::numbers::pi;
  std::vector<std::string> names;
  for (int j = 0; j < model.njnt; ++j) {
    if (model.jnt_type[j] != mjJNT_HINGE || !model.jnt_limited[j]) continue;
    const double lower = model.jnt_range[2 * j] * kDegrees, upper = model.jnt_range[2 * j + 1] * kDegrees;
    if (std::max(std::abs(lower), std::abs(upper)) > kLargest * 1.001) continue;
    const char* name = mj_id2name(&model, mjOBJ_JOINT, j);
    names.push_back(fmt::format("{} [{:.3g}, {:.3g}]", name != nullptr ? name : fmt::format("#{}", j), lower, upper));
  }
  if (names.empty()) return "";
  tinyxml2::XMLDocument document;
  std::set<fs::path> seen;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS || document.RootElement() == nullptr) return "";
  if (states_angle(*document.RootElement(), file.parent_path(), seen)) return "";
  return fmt::format(
      "no <compiler angle=\"…\"> says what angles are written in, so that these ranges are in degrees: {}; write "
      "<compiler angle=\"radian\"/> where they are radians",
      list_some(names));
}

}  // namespace stiction::world
