#pragma once

#include "stiction/tasks/option_table.hpp"

namespace stiction::tasks {

inline constexpr std::string_view kPositive = R"({"$ref": "task.schema.json#/$defs/positive"})",
                                  kNonnegative = R"({"$ref": "task.schema.json#/$defs/nonnegative"})",
                                  kProbability = R"({"$ref": "task.schema.json#/$defs/probability"})",
                                  kCount = R"({"type": "integer", "minimum": 1})", kNumberOfThem = R"({"type": "integer", "minimum": 0})",
                                  kBoolean = R"({"type": "boolean"})";

double probability(const world::YamlNode& node);  ///< in [0, 1]
double share(const world::YamlNode& node);        ///< in (0, 1]

// Rows of options that are more than a number.
OptionRow sample_box_row();
OptionRow friction_law_row();
OptionRow thesis_row();  ///< map of the settings of published runs

}  // namespace stiction::tasks
