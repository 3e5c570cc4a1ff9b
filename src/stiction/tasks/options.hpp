#pragma once

#include <array>
#include <string>
#include <string_view>

#include "stiction/planning/planner.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {

inline constexpr std::array<std::string_view, 2> kFrictionLawNames = {"anitescu", "coulomb"};  // of dynamics::FrictionLaw

/// Reads the `planner` section of a task file. Every field of PlannerOptions by its name; in addition
///   single_step: true                       one step per extension (substep = nullopt), whatever `substep` says
///   length: {capped: L} | {fixed: L}        regularisation: {ratio: r} | {epsilon: ε}
///   sample_box: {OBJECT: {lower: […], upper: […]}}
///   sampler: {generic: {whole_probability, near_probability, near_std, tries}}
/// A null stands for a key that is not given, so that a file may take back a choice of its base.
/// @param defaults  of what is not given; single steps and jumps are those of the thesis, and start from PlannerOptions{}
/// @throws core::InvalidInput with file, line and field
planning::PlannerOptions read_planner_options(const world::YamlNode& node, const world::Model& model,
                                              const planning::PlannerOptions& defaults = {});

/// The same options as one JSON object (which is YAML) in the same spelling, without seed and threads.
std::string planner_options_json(const planning::PlannerOptions& options, const world::Model& model);

}  // namespace stiction::tasks
