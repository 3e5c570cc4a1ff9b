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

/// A planner option as it appears in files and in Python. The reader, the writer, the JSON schema, docs/options.md and the Python names all
/// follow the table of these options.
struct OptionRow {
  std::string_view key;
  bool in_plan;          ///< plan files list it among their options; others are stored elsewhere or not at all
  std::string_view doc;  ///< description with unit
  std::string schema;    ///< JSON schema of the value; null, which resets an option, is allowed besides
  std::function<void(const world::YamlNode&, const world::Model&, planning::PlannerOptions&)> read;
  std::function<nlohmann::ordered_json(const planning::PlannerOptions&, const world::Model&)> write;  ///< null: not written
};

/// Value of a key; nullopt if the key is missing or null.
std::optional<world::YamlNode> given(const world::YamlNode& map, std::string_view key);

/// All options in reading order; a later option may override values set by an earlier one.
const std::vector<OptionRow>& option_table();

}  // namespace stiction::tasks
