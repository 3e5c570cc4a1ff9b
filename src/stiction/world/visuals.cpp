#include "stiction/world/visuals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/mjcf.hpp"
#include "stiction/world/mjcf_compile.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/visual_mesh.hpp"

namespace stiction::world {
namespace {

using MeshPointer = std::shared_ptr<const VisualMesh>;

/// Copies one mesh of a compiled MJCF.
MeshPointer take_mesh(const mjModel& m, int number) {
  const Eigen::Map<const Eigen::Matrix3Xf> vertices(m.mesh_vert + 3 * m.mesh_vertadr[number], 3, m.mesh_vertnum[number]);
  const Eigen::Map<const Eigen::Matrix3Xi> triangles(m.mesh_face + 3 * m.mesh_faceadr[number], 3, m.mesh_facenum[number]);
  return std::make_shared<const VisualMesh>(VisualMesh{vertices, triangles});
}

class VisualsReader {
 public:
  explicit VisualsReader(const Model& model) : model_(model) {}

  Visuals read() {
    for (const RobotSpec& robot : model_.scene().robots) {
      if (robot.contents == nullptr) continue;
      robot_ = &robot;
      compiled_.clear();
      files_.clear();
      for (const std::string& note : robot.contents->robot.unseen) add_note(note);
      for (const FileVisual& visual : robot.contents->robot.visuals) attempt(visual);
    }
    return std::move(out_);
  }

 private:
  void add_note(const std::string& what) {
    const std::string note = fmt::format("{}: not shown: {}", robot_->name, what);
    if (noted_.insert(note).second) out_.notes.push_back(note);
  }

  void attempt(const FileVisual& visual) {
    try {
      add(visual);
    } catch (const core::InvalidInput& e) {
      add_note(e.what());
    }
  }

  /// Index of a body by name; −1 if the scene has no such body, for example because the object does not collide.
  int find_body(const std::string& owner) const {
    const auto find = [&](const std::string& name) {
      const auto bodies = model_.bodies();
      const auto found = std::find_if(bodies.begin(), bodies.end(), [&](const Body& body) { return body.name == name; });
      return found == bodies.end() ? -1 : static_cast<int>(found - bodies.begin());
    };
    const auto& tree = robot_->contents->robot;
    if (owner.empty()) {
      const int fixed = find(name_of_fixed(*robot_));
      return fixed >= 0 || tree.links.empty() ? fixed : find(fmt::format("{}/{}", robot_->name, tree.links[0].name));
    }
    const int link = find(fmt::format("{}/{}", robot_->name, owner));
    return link >= 0 ? link : find(owner);
  }

  void add(const FileVisual& visual) {
    const int body = find_body(visual.owner);
    if (body < 0) return;
    Visual out{.body = body, .X_BV = visual.X_BV, .form = Shape{}};
    if (visual.color) out.color = Eigen::Map<const Eigen::Vector4d>(visual.color->data());
    if (const auto* shape = std::get_if<Shape>(&visual.form)) {
      out.form = *shape;
      out_.visuals.push_back(std::move(out));
      return;
    }
    const auto& file = std::get<VisualFile>(visual.form);
    if (file.number >= 0) {
      out.form = number_of(find_mesh(file));
      out_.visuals.push_back(std::move(out));
      return;
    }
    for (const ColoredMesh& part : find_parts(file)) {
      out.form = number_of(part.mesh);
      if (!visual.color) out.color = part.color.value_or(Visual{}.color);
      out_.visuals.push_back(out);
    }
  }

  int number_of(const MeshPointer& mesh) {
    const auto [known, fresh] = numbers_.try_emplace(mesh.get(), static_cast<int>(out_.meshes.size()));
    if (fresh) out_.meshes.push_back(mesh);
    return known->second;
  }

  /// Finds a mesh of an MJCF. The file is compiled only once, even if several of its meshes are visible.
  MeshPointer find_mesh(const VisualFile& file) {
    auto& meshes = compiled_[file.file];
    if (!meshes) {
      meshes.emplace();
      compile(file.file, *meshes);
    }
    if (file.number >= static_cast<int>(meshes->size()))
      throw core::InvalidInput(
          fmt::format("{}: a mesh that is not there any more", (file.file.empty() ? robot_->mjcf : file.file).string()));
    return (*meshes)[static_cast<std::size_t>(file.number)];
  }

  /// @param mounted  empty: the robot's own file or text
  void compile(const std::filesystem::path& mounted, std::vector<MeshPointer>& meshes) const {
    const bool is_text = mounted.empty() && !robot_->text.empty();
    const std::filesystem::path& file = mounted.empty() ? robot_->mjcf : mounted;  // of a text its folder
    const std::string text = xml_text(is_text ? robot_->text : read_bytes(file), file, "mjcf");
    std::vector<std::string> ignored;  // Model::make() has already reported these notes
    const CompiledMjcf model = compile_mjcf(text, file.parent_path(), file, ignored);
    for (int number = 0; number < model->nmesh; ++number) meshes.push_back(take_mesh(*model, number));
  }

  const std::vector<ColoredMesh>& find_parts(const VisualFile& file) {
    const std::pair key{file.file, std::array{file.scale[0], file.scale[1], file.scale[2]}};
    const auto known = files_.find(key);
    if (known != files_.end()) return known->second;
    files_[key] = {};  // a file that cannot be read is tried only once
    return files_[key] = load_visual_mesh(file.file, file.scale);
  }

  const Model& model_;
  const RobotSpec* robot_ = nullptr;
  std::map<std::filesystem::path, std::optional<std::vector<MeshPointer>>> compiled_{};
  std::map<std::pair<std::filesystem::path, std::array<double, 3>>, std::vector<ColoredMesh>> files_{};
  std::map<const VisualMesh*, int> numbers_{};
  std::set<std::string> noted_{};
  Visuals out_{};
};

}  // namespace

Visuals read_visuals(const Model& model) { return VisualsReader(model).read(); }

}  // namespace stiction::world
