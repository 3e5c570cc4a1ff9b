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
OptionRow length_row();
OptionRow smoothing_row();
OptionRow scheme_row();
OptionRow randomized_row();
OptionRow metric_row();
OptionRow cost_row();
OptionRow regularisation_row();
OptionRow substep_row();
OptionRow single_step_row();
OptionRow sampler_row();
OptionRow sample_box_row();
OptionRow friction_law_row();
OptionRow margins_row();
OptionRow brace_force_row();
OptionRow refined_fraction_row();

}  // namespace stiction::tasks
