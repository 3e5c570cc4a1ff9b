#include "stiction/world/xml_reader.hpp"

#include <Eigen/Geometry>

#include "stiction/world/encoding.hpp"

namespace stiction::world {
namespace {

/// The format of a file by its root element, and a remedy for the message. {} in the remedy stands for the file's name.
struct Root {
  std::string_view element, what, remedy;
};
constexpr Root kRoots[] = {{"mujoco", "an MJCF", "an MJCF stands under the key mjcf"},
                           {"mujocoinclude", "a part of an MJCF", "the MJCF that includes it stands under the key mjcf"},
                           {"robot", "a URDF", "a URDF stands under the key urdf"},
                           {"sdf", "an SDF", "`stiction import {} -o NEW.yaml` makes an MJCF of it, NEW.xml"},
                           {"COLLADA", "a mesh", "a mesh is named in the file of a robot"},
                           {"html", "a web page", "download the file itself"}};

/// Names and root elements of the formats that are read.
struct Format {
  std::string_view key, name, root;
};
constexpr Format kFormats[] = {{"urdf", "a URDF", "robot"}, {"srdf", "an SRDF", "robot"}, {"mjcf", "an MJCF", "mujoco"}};

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return out;
}

}  // namespace

Pose XmlReader::origin(const XMLElement& at) const {
  const XMLElement* element = at.FirstChildElement("origin");
  if (element == nullptr) return {};
  const Eigen::Vector3d p = vector3(*element, "xyz", Eigen::Vector3d::Zero());
  if (element->Attribute("quat_xyzw") == nullptr) return {rotation_from_rpy(vector3(*element, "rpy", Eigen::Vector3d::Zero())), p};
  if (element->Attribute("rpy") != nullptr) fail(*element, "origin", "rpy beside quat_xyzw", "one of the two");
  const Eigen::Vector4d xyzw = vector4(*element, "quat_xyzw");
  if (!(std::abs(xyzw.norm() - 1) < 1e-3)) fail(*element, "origin quat_xyzw", fmt::format("length {:.6g}", xyzw.norm()), "length 1");
  return {Eigen::Quaterniond(xyzw).normalized().toRotationMatrix(), p};
}

const XMLElement* parse_xml(tinyxml2::XMLDocument& document, const std::string& text, const std::filesystem::path& file,
                            std::string_view format) {
  const Format& wanted = *std::find_if(std::begin(kFormats), std::end(kFormats), [&](const Format& f) { return f.key == format; });
  if (const auto found = find_stand_in(text))
    throw core::InvalidInput(
        fmt::format("{}:1: {}: got {}, expected {}; {}", file.string(), format, found->what, wanted.name, found->remedy));
  document.Parse(text.data(), text.size());
  if (document.Error() && document.ErrorID() != tinyxml2::XML_ERROR_EMPTY_DOCUMENT) {
    const auto first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
    const std::string got = first != std::string::npos && text[first] == '<' ? fmt::format("malformed XML ({})", document.ErrorName())
                                                                             : "a text that is no XML";
    throw core::InvalidInput(
        fmt::format("{}:{}: {}: got {}, expected {}", file.string(), document.ErrorLineNum(), format, got, wanted.name));
  }
  const XMLElement* root = document.RootElement();
  if (root == nullptr || root->Name() == wanted.root) return root;
  const std::string name = file.has_extension() ? file.filename().string() : "FILE";  // a text has no extension
  std::string got = fmt::format("'{}'", root->Name()), expected = fmt::format("'{}'", wanted.root);
  for (const Root& known : kRoots) {
    if (lower_case(known.element) != lower_case(root->Name())) continue;
    got += fmt::format(", so {}", known.what);
    expected += fmt::format(", the root of {}; {}", wanted.name, fmt::format(fmt::runtime(known.remedy), name));
  }
  XmlReader(file).fail(*root, "root element", got, expected);
}

}  // namespace stiction::world
