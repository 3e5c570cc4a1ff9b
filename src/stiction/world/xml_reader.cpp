#include "stiction/world/xml_reader.hpp"

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

const XMLElement* parse_xml(tinyxml2::XMLDocument& document, const std::string& text, const std::filesystem::path& file,
                            std::string_view format) {
  const Format& wanted = *std::find_if(std::begin(kFormats), std::end(kFormats), [&](const Format& f) { return f.key == format; });
  document.Parse(text.data(), text.size());
  // Web pages are seldom valid XML, but the message should name them as web pages.
  const bool page = lower_case(text.substr(0, std::min<std::size_t>(text.size(), 256))).find("<!doctype html") != std::string::npos;
  if (page || (document.Error() && document.ErrorID() != tinyxml2::XML_ERROR_EMPTY_DOCUMENT)) {
    const std::string got = page ? "a web page" : fmt::format("malformed XML ({})", document.ErrorName());
    throw core::InvalidInput(fmt::format("{}:{}: {}: got {}, expected {}{}", file.string(), page ? 1 : document.ErrorLineNum(), format, got,
                                         wanted.name, page ? "; download the file itself" : ""));
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
