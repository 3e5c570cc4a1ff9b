#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/planning/planner.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

/// An option of the planner as files and Python have it. The table of them drives the reader, the writer, the JSON schema, docs/options.md and the
/// names in Python.
struct OptionRow {
  std::string_view key;
  bool in_plan;          ///< a plan file has it among its options; the others it has elsewhere or not at all
  std::string_view doc;  ///< what it is, with its unit
  std::string schema;    ///< JSON schema of the value; null, which takes an option back, besides
  std::function<void(const world::YamlNode&, const world::Model&, planning::PlannerOptions&)> read;
  std::function<nlohmann::ordered_json(const planning::PlannerOptions&, const world::Model&)> write;  ///< null: not written
};

/// The value of a key, nullopt when it is missing or null.
std::optional<world::YamlNode> given(const world::YamlNode& map, std::string_view key);

/// In the order in which they are read: a later one may undo what an earlier one set.
const std::vector<OptionRow>& option_table();

}  // namespace stiction::tasks
