#include "stiction/world/urdf_visuals.hpp"

#include <fmt/format.h>

#include <map>
#include <optional>
#include <string>

#include "stiction/world/urdf.hpp"

namespace stiction::world {
namespace {

using Color = std::optional<std::array<double, 4>>;

class VisualReader {
 public:
  VisualReader(const XmlReader& reader, const XMLElement& robot, const std::filesystem::path& folder,
               std::span<const std::filesystem::path> package_dirs, RobotTree& tree)
      : reader_(reader), robot_(robot), folder_(folder), package_dirs_(package_dirs), tree_(tree) {}

  void read() {
    for (const XMLElement* e = robot_.FirstChildElement("material"); e != nullptr; e = e->NextSiblingElement("material"))
      attempt("materials", [&] { remember(*e); });
    for (const XMLElement* e = robot_.FirstChildElement("link"); e != nullptr; e = e->NextSiblingElement("link")) {
      const std::string link = e->Attribute("name") != nullptr ? e->Attribute("name") : "";
      for (const XMLElement* v = e->FirstChildElement("visual"); v != nullptr; v = v->NextSiblingElement("visual"))
        attempt(link, [&] { add(link, *v); });
    }
  }

 private:
  template <class Function>
  void attempt(const std::string& what, const Function& function) {
    try {
      function();
    } catch (const core::InvalidInput& e) {
      tree_.unseen.push_back(fmt::format("{}: {}", what, e.what()));
    }
  }

  /// The colour of a <material>; nullopt if it states none.
  Color color_of(const XMLElement& material) const {
    const XMLElement* color = material.FirstChildElement("color");
    if (color == nullptr) return std::nullopt;
    const Eigen::Vector4d c = reader_.vector4(*color, "rgba").cwiseMax(0).cwiseMin(1);
    return std::array{c[0], c[1], c[2], c[3]};
  }

  Color remember(const XMLElement& material) {
    const Color color = color_of(material);
    if (color && material.Attribute("name") != nullptr) colors_[material.Attribute("name")] = *color;
    return color;
  }

  Color find_color(const XMLElement& visual) {
    const XMLElement* material = visual.FirstChildElement("material");
    if (material == nullptr) return std::nullopt;
    if (const Color own = remember(*material)) return own;
    const auto known = colors_.find(material->Attribute("name") != nullptr ? material->Attribute("name") : "");
    return known != colors_.end() ? Color(known->second) : std::nullopt;
  }

  VisualFile read_mesh(const XMLElement& mesh) const {
    const std::string uri = reader_.required(mesh, "filename");
    const auto file = find_resource(uri, folder_, package_dirs_);
    if (file.empty()) reader_.fail(mesh, "mesh filename", fmt::format("'{}', which is nowhere", uri), "a file that exists");
    return {.file = file, .scale = reader_.vector3(mesh, "scale", Eigen::Vector3d::Ones())};
  }

  std::variant<Shape, VisualFile> read_form(const XMLElement& visual) const {
    const XMLElement& geometry = reader_.child(visual, "geometry");
    const XMLElement* shape = geometry.FirstChildElement();
    const std::string kind = shape != nullptr ? shape->Name() : "nothing";
    if (kind == "mesh") return read_mesh(*shape);
    Shape out;
    if (kind == "sphere")
      out = Sphere{reader_.number(*shape, "radius")};
    else if (kind == "box")
      out = Box{reader_.vector3(*shape, "size") / 2};
    else if (kind == "cylinder")
      out = Cylinder{reader_.number(*shape, "radius"), reader_.number(*shape, "length") / 2};
    else if (kind == "capsule")
      out = Capsule{reader_.number(*shape, "radius"), reader_.number(*shape, "length") / 2};
    else
      reader_.fail(geometry, "geometry", fmt::format("'{}'", kind), "sphere, box, cylinder, capsule or mesh");
    require_shape("visual", out);
    return out;
  }

  void add(const std::string& link, const XMLElement& visual) {
    tree_.visuals.push_back({.owner = link, .X_BV = reader_.origin(visual), .form = read_form(visual), .color = find_color(visual)});
  }

  const XmlReader& reader_;
  const XMLElement& robot_;
  const std::filesystem::path& folder_;
  std::span<const std::filesystem::path> package_dirs_;
  RobotTree& tree_;
  std::map<std::string, std::array<double, 4>> colors_{};  ///< colours of the materials, by name
};

}  // namespace

void read_urdf_visuals(const XmlReader& reader, const XMLElement& robot, const std::filesystem::path& folder,
                       std::span<const std::filesystem::path> package_dirs, RobotTree& tree) {
  VisualReader(reader, robot, folder, package_dirs, tree).read();
}

}  // namespace stiction::world
