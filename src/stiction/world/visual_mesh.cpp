#include "stiction/world/visual_mesh.hpp"

#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/mesh_contents.hpp"

namespace stiction::world {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_visual(const fs::path& file, std::string_view got, std::string_view expected) {
  throw core::InvalidInput(fmt::format("{}: mesh: got {}, expected {}", file.string(), got, expected));
}

/// Gives Assimp access to one file and the material files beside it only, because a mesh could name any other file.
class MeshFolder final : public Assimp::IOSystem {
 public:
  MeshFolder(fs::path file, std::string bytes) : file_(std::move(file)) { contents_.emplace(file_.string(), std::move(bytes)); }
  bool Exists(const char* name) const override {
    const fs::path path(name);
    return path == file_ || (path.extension() == ".mtl" &&
                             path.lexically_normal().parent_path() == file_.lexically_normal().parent_path() && fs::is_regular_file(path));
  }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char*) override {
    if (!Exists(name)) return nullptr;
    const auto [bytes, fresh] = contents_.try_emplace(name);
    if (fresh) bytes->second = read_bytes(name);
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(bytes->second.data()), bytes->second.size());
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  fs::path file_;
  std::map<std::string, std::string> contents_{};
};

std::optional<Eigen::Vector4d> color_of(const aiMaterial& material) {
  aiString name;
  if (material.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS && std::string_view(name.C_Str()) == AI_DEFAULT_MATERIAL_NAME)
    return std::nullopt;
  aiColor4D color;
  if (material.Get(AI_MATKEY_COLOR_DIFFUSE, color) != aiReturn_SUCCESS) return std::nullopt;
  return Eigen::Vector4d(color.r, color.g, color.b, 1).cwiseMax(0).cwiseMin(1);
}

ColoredMesh take_part(const aiScene& scene, const aiMesh& mesh, const Eigen::Vector3d& scale) {
  VisualMesh out;
  out.vertices.resize(3, mesh.mNumVertices);
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D& p = mesh.mVertices[i];
    out.vertices.col(i) = Eigen::Vector3d(p.x, p.y, p.z).cwiseProduct(scale).cast<float>();
  }
  std::vector<Eigen::Vector3i> corners;
  const bool mirrored = scale.prod() < 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) continue;
    const Eigen::Vector3i corner(static_cast<int>(face.mIndices[0]), static_cast<int>(face.mIndices[mirrored ? 2 : 1]),
                                 static_cast<int>(face.mIndices[mirrored ? 1 : 2]));
    if (corner.minCoeff() >= 0 && corner.maxCoeff() < static_cast<int>(mesh.mNumVertices)) corners.push_back(corner);
  }
  out.triangles.resize(3, static_cast<Eigen::Index>(corners.size()));
  for (std::size_t i = 0; i < corners.size(); ++i) out.triangles.col(static_cast<Eigen::Index>(i)) = corners[i];
  ColoredMesh part{.mesh = std::make_shared<const VisualMesh>(std::move(out))};
  if (mesh.mMaterialIndex < scene.mNumMaterials) part.color = color_of(*scene.mMaterials[mesh.mMaterialIndex]);
  return part;
}

}  // namespace

std::vector<ColoredMesh> load_visual_mesh(const fs::path& file, const Eigen::Vector3d& scale) {
  if (!fs::is_regular_file(file)) fail_visual(file, "a file that does not exist", "a mesh");
  std::string bytes = read_bytes(file);
  require_mesh_contents(file, bytes);
  Assimp::Importer importer;
  importer.SetIOHandler(new MeshFolder(file, std::move(bytes)));  // the importer deletes it
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);  // as in load_mesh()
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene* scene = importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices);
  if (scene == nullptr) fail_visual(file, fmt::format("a file that cannot be read ({})", importer.GetErrorString()), "a mesh");
  std::vector<ColoredMesh> parts;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    ColoredMesh part = take_part(*scene, *scene->mMeshes[m], scale);
    if (part.mesh->triangles.cols() > 0 && part.mesh->vertices.allFinite()) parts.push_back(std::move(part));
  }
  if (parts.empty()) fail_visual(file, "no triangles", "a mesh");
  return parts;
}

}  // namespace stiction::world
