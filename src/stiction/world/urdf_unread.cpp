#include "stiction/world/urdf_unread.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

using tinyxml2::XMLElement;

/// Words between blanks.
std::set<std::string_view> words(std::string_view text) {
  std::set<std::string_view> out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    out.insert(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

/// What the reader knows of an element: attributes, elements that it may contain once, and elements that it may contain several times.
/// Elements without an entry are not looked into.
struct Known {
  std::string_view element, attributes, once, often;
};
constexpr Known kKnown[] = {
    {"link", "name type", "inertial", "visual collision"},
    {"joint", "name type", "origin parent child axis limit dynamics mimic calibration safety_controller", ""},
    {"origin", "xyz rpy quat_xyzw", "", ""},
    {"parent", "link", "", ""},
    {"child", "link", "", ""},
    {"axis", "xyz", "", ""},
    {"limit", "lower upper effort velocity acceleration deceleration jerk", "", ""},
    {"dynamics", "damping friction", "", ""},
    {"mimic", "joint multiplier offset", "", ""},
    {"inertial", "", "origin mass inertia", ""},
    {"mass", "value", "", ""},
    {"inertia", "ixx ixy ixz iyy iyz izz", "", ""},
    {"collision", "name", "origin geometry", ""},
    {"geometry", "", "", ""},
    {"sphere", "radius", "", ""},
    {"box", "size", "", ""},
    {"cylinder", "radius length", "", ""},
    {"capsule", "radius length", "", ""},
    {"mesh", "filename scale", "", ""},
};

/// Looks through one file.
class UnreadFinder {
 public:
  std::string find(const XMLElement& robot) {
    for (const char* kind : {"link", "joint"}) {
      for (const XMLElement* e = robot.FirstChildElement(kind); e != nullptr; e = e->NextSiblingElement(kind)) {
        const char* name = e->Attribute("name");
        owner_ = name != nullptr ? name : "";
        look_at(*e, std::string(kind) + "s");
      }
    }
    std::vector<std::string> entries;
    for (const auto& [what, owners] : found_) entries.push_back(fmt::format("{} {}", what, list_some(owners)));
    return entries.empty() ? "" : fmt::format("not read: {}", fmt::join(entries, "; "));
  }

 private:
  void look_at(const XMLElement& element, const std::string& where) {
    const auto* known = std::ranges::find(kKnown, std::string_view(element.Name()), &Known::element);
    if (known == std::end(kKnown)) return;
    const auto attributes = words(known->attributes), once = words(known->once), often = words(known->often);
    for (const auto* a = element.FirstAttribute(); a != nullptr; a = a->Next()) {
      const std::string_view name = a->Name();
      if (!attributes.contains(name) && !name.starts_with("xmlns")) add(fmt::format("{} of {}", name, where));
    }
    const bool choice = known->element == "geometry";  // the first element is the shape
    std::set<std::string_view> seen;
    for (const XMLElement* child = element.FirstChildElement(); child != nullptr; child = child->NextSiblingElement()) {
      const std::string_view name = child->Name();
      const bool first = choice ? child == element.FirstChildElement() : often.contains(name) || seen.insert(name).second;
      if (!choice && !once.contains(name) && !often.contains(name))
        add(fmt::format("<{}> of {}", name, where));
      else if (!first)
        add(fmt::format("a second <{}> of {}", choice ? "shape" : name, where));
      else if (name != "visual")
        look_at(*child, fmt::format("<{}> of {}", name, where));
    }
  }

  void add(const std::string& what) {
    auto entry = std::ranges::find(found_, what, &std::pair<std::string, std::vector<std::string>>::first);
    if (entry == found_.end()) entry = found_.insert(entry, {what, {}});
    if (entry->second.empty() || entry->second.back() != owner_) entry->second.push_back(owner_);
  }

  std::string owner_{};
  std::vector<std::pair<std::string, std::vector<std::string>>> found_{};  ///< what is not read, and of which links or joints
};

}  // namespace

std::string find_unread(const XMLElement& robot) { return UnreadFinder().find(robot); }

}  // namespace stiction::world
