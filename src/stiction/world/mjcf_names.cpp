#include "stiction/world/mjcf_names.hpp"

#include <fmt/format.h>

#include <set>

namespace stiction::world {
namespace {

/// @param make  makes the name of an element without one
template <class Make>
std::vector<std::string> name_all(const mjModel& m, mjtObj type, int count, const Make& make) {
  std::vector<std::string> names;
  std::vector<int> changed;
  std::set<std::string> taken;
  for (int i = 0; i < count; ++i) {
    const char* text = mj_id2name(&m, type, i);
    const std::string given = text != nullptr ? text : "";
    names.push_back(given.empty() ? make(i) : usable(given));
    if (names.back() != given || !taken.insert(given).second) changed.push_back(i);
  }
  for (const int i : changed) {
    std::string& name = names[static_cast<std::size_t>(i)];
    const std::string first = name;
    for (int number = 2; !taken.insert(name).second; ++number) name = fmt::format("{}_{}", first, number);
  }
  return names;
}

}  // namespace

std::string usable(std::string name) {
  for (char& c : name) {
    if (c == '/' || c == '*' || (c >= 0 && c <= ' ')) c = '_';
  }
  return name;
}

MjcfNames::MjcfNames(const mjModel& m) : bodies_(name_all(m, mjOBJ_BODY, m.nbody, [](int i) { return fmt::format("body_{}", i); })) {
  joints_ = name_all(m, mjOBJ_JOINT, m.njnt, [&](int i) {
    const int body = m.jnt_bodyid[i];
    return fmt::format("{}_joint_{}", bodies_[static_cast<std::size_t>(body)], i - m.body_jntadr[body]);
  });
}

}  // namespace stiction::world
