#pragma once

#include <array>
#include <string>
#include <string_view>

#include "stiction/planning/planner.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

inline constexpr std::array<std::string_view, 2> kFrictionLawNames = {"anitescu", "coulomb"};  // of dynamics::FrictionLaw

/// Reads the `planner` section of a task file: the rows of option_table() by their names.
/// A null counts as a missing key, so that a file may reset a choice of its base.
/// @param defaults  values of missing options  @param notes  receives a sentence for each obsolete option
/// @throws core::InvalidInput with file, line and field
planning::PlannerOptions read_planner_options(const world::YamlNode& node, const world::Model& model,
                                              const planning::PlannerOptions& defaults = {}, std::vector<std::string>* notes = nullptr);

enum class WhichOptions {
  OfPlan,  ///< the options listed in plan files
  All      ///< also seed and threads
};

/// The same options as one JSON object (which is YAML) in the same spelling.
std::string planner_options_json(const planning::PlannerOptions& options, const world::Model& model,
                                 WhichOptions which = WhichOptions::OfPlan);

/// JSON schema of the section, which tasks/schema/planner.schema.json and docs/options.md have (scripts/options.py).
std::string planner_schema_json();

}  // namespace stiction::tasks
