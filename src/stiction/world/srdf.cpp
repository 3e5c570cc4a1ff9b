#include "stiction/world/srdf.hpp"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <iterator>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/encoding.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/xml_reader.hpp"

namespace stiction::world {
namespace {

/// Calls `visit` with every element of that name below the root.
template <class Visit>
void each_child(const XMLElement& root, const char* name, const Visit& visit) {
  for (const XMLElement* e = root.FirstChildElement(name); e != nullptr; e = e->NextSiblingElement(name)) visit(*e);
}

/// Adds notes on joints that move differently here than in the file.
void add_joint_notes(const XmlReader& reader, const XMLElement& root, Srdf& out) {
  std::vector<std::string> passive, moving_bases;
  each_child(root, "passive_joint", [&](const XMLElement& e) { passive.push_back(reader.required(e, "name")); });
  each_child(root, "virtual_joint", [&](const XMLElement& e) {
    const std::string type = reader.required(e, "type");
    if (type != "fixed") moving_bases.push_back(fmt::format("{} ({})", reader.required(e, "name"), type));
  });
  if (!passive.empty()) out.notes.push_back("passive joints of the SRDF have motors here: " + list_some(passive));
  if (!moving_bases.empty())
    out.notes.push_back("virtual joints of the SRDF that would move the base, which stands still here: " + list_some(moving_bases));
}

}  // namespace

Srdf read_srdf(const std::filesystem::path& file) {
  Srdf out;
  tinyxml2::XMLDocument document;
  const XMLElement* root = parse_xml(document, xml_text(read_bytes(file), file, "srdf"), file, "srdf");
  if (root == nullptr) {
    out.notes.push_back(fmt::format("{} has no element, so that it disables no pair of links", file.filename().string()));
    return out;
  }
  const XmlReader reader(file);
  for (const char* of_urdf : {"link", "joint"}) {
    if (const XMLElement* e = root->FirstChildElement(of_urdf))
      reader.fail(*e, "srdf", fmt::format("an element '{}', so a URDF", of_urdf), "an SRDF; a URDF stands under the key urdf");
  }
  const auto pair_of = [&](const XMLElement& e) { return Srdf::LinkPair(reader.required(e, "link1"), reader.required(e, "link2")); };
  each_child(*root, "disable_collisions", [&](const XMLElement& e) { out.disabled.push_back(pair_of(e)); });
  each_child(*root, "enable_collisions", [&](const XMLElement& e) { out.enabled.push_back(pair_of(e)); });
  each_child(*root, "disable_default_collisions",
             [&](const XMLElement& e) { out.disabled_by_default.push_back(reader.required(e, "link")); });
  add_joint_notes(reader, *root, out);
  return out;
}

std::vector<Srdf::LinkPair> Srdf::pairs_apart(std::span<const std::string> links) const {
  const auto names = [](const std::vector<LinkPair>& pairs, const std::string& a, const std::string& b) {
    return std::ranges::any_of(pairs, [&](const LinkPair& p) { return p == LinkPair(a, b) || p == LinkPair(b, a); });
  };
  const auto is_apart_by_default = [&](const std::string& link) {
    return std::ranges::find(disabled_by_default, link) != disabled_by_default.end();
  };
  const auto is_there = [&](const std::string& link) { return std::ranges::find(links, link) != links.end(); };
  std::vector<LinkPair> out;
  std::ranges::copy_if(disabled, std::back_inserter(out), [&](const LinkPair& p) { return is_there(p.first) && is_there(p.second); });
  for (std::size_t i = 0; i < links.size(); ++i) {
    for (std::size_t k = i + 1; k < links.size(); ++k) {
      const std::string &a = links[i], &b = links[k];
      if (!is_apart_by_default(a) && !is_apart_by_default(b)) continue;
      if (!names(disabled, a, b) && !names(enabled, a, b)) out.emplace_back(a, b);
    }
  }
  return out;
}

}  // namespace stiction::world
