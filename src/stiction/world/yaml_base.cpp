#include <fmt/format.h>

#include <algorithm>

#include "stiction/world/yaml.hpp"

namespace stiction::world {
namespace {

YamlNode with_base(const YamlNode& node, std::vector<std::filesystem::path>& seen) {
  node.require_map();
  const auto base = node.find("base");
  if (!base) return node;
  const std::filesystem::path& file = node.file();
  const auto here = std::filesystem::weakly_canonical(file);
  if (std::find(seen.begin(), seen.end(), here) != seen.end()) base->fail("a file that does not lead back to this one");
  seen.push_back(here);
  const auto other = file.parent_path() / base->string();
  if (!std::filesystem::is_regular_file(other)) base->fail(fmt::format("a file that exists ({} does not)", other.string()));
  return merge(with_base(YamlNode::load(other), seen), node).without("base");
}

}  // namespace

YamlNode load_yaml_with_base(const std::filesystem::path& file) {
  std::vector<std::filesystem::path> seen;
  return with_base(YamlNode::load(file), seen);
}

YamlNode parse_yaml_with_base(const std::string& text, const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> seen;
  return with_base(YamlNode::parse(text, folder / ""), seen);
}

}  // namespace stiction::world
