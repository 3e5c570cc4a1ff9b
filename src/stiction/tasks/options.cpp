#include "stiction/tasks/options.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "stiction/core/faults.hpp"
#include "stiction/tasks/option_table.hpp"

namespace stiction::tasks {
namespace {

using planning::PlannerOptions;
using world::YamlNode;

/// The map that most options of the method stood in. It and they went in 0.3.0, and are refused from 0.4.0 on.
constexpr std::string_view kAdvanced = "advanced";
/// The planner sets them from the scene: they change nothing any more.
constexpr std::string_view kGone[] = {"trees",
                                      "batch",
                                      "record_tree",
                                      "stop_at_goal",
                                      "gamma",
                                      "length",
                                      "smoothing",
                                      "metric",
                                      "goal_sharpening",
                                      "cost",
                                      "sampler",
                                      "randomized",
                                      "grasp_probability",
                                      "grasp_candidates",
                                      "grasp_trials",
                                      "h",
                                      "regularisation",
                                      "substep",
                                      "fidelity_edge",
                                      "fidelity_path",
                                      "start_noise",
                                      "edge_tilt",
                                      "friction_noise",
                                      "grip_force",
                                      "brace_force",
                                      "regrasp_friction",
                                      "regrasp_clearance",
                                      "regrasp_tol_position",
                                      "regrasp_tol_angle",
                                      "release_tol_position",
                                      "release_tol_angle",
                                      "refined_fraction"};
/// Former options that switched to another algorithm, which the map `thesis` now selects.
constexpr std::string_view kOfTheThesis[] = {"single_step", "real_regrasps", "scheme"};

/// Handles removed options. @throws core::InvalidInput: a removed option that switched to another algorithm
void look_at_gone(const YamlNode& node, std::vector<std::string>* notes) {
  for (const std::string_view key : kOfTheThesis) {
    if (const auto value = given(node, key))
      value->fail("no such option: trees with the settings of the thesis have a map `thesis` (docs/options.md)");
  }
  for (const std::string_view key : kGone) {
    const auto value = given(node, key);
    if (value && notes != nullptr)
      notes->push_back(
          fmt::format("{}: no option any more, and ignored: the planner sets it from the scene (docs/options.md)", value->where()));
  }
}

void require_known_keys(const YamlNode& node, std::vector<std::string>* notes) {
  std::vector<std::string_view> gone(std::begin(kGone), std::end(kGone));
  gone.insert(gone.end(), std::begin(kOfTheThesis), std::end(kOfTheThesis));
  std::vector<std::string_view> silent = gone, known;
  silent.push_back(kAdvanced);
  for (const OptionRow& row : option_table()) known.push_back(row.key);
  YamlNode today = node;  // messages name no option of an earlier version
  for (const std::string_view key : silent) today = today.without(key);
  today.require_map(known);
  look_at_gone(node, notes);
  if (const auto advanced = given(node, kAdvanced)) {
    advanced->require_map(gone);
    look_at_gone(*advanced, notes);
  }
}

}  // namespace

PlannerOptions read_planner_options(const YamlNode& node, const world::Model& model, const PlannerOptions& defaults,
                                    std::vector<std::string>* notes) {
  node.require_map();
  require_known_keys(node, notes);
  PlannerOptions out = defaults;
  core::Faults faults;
  for (const OptionRow& row : option_table()) {
    faults.collect([&] {
      if (const auto value = given(node, row.key)) row.read(*value, model, out);
    });
  }
  faults.raise();
  try {
    out.validate(model);
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", node.where(), e.what()));
  }
  return out;
}

std::string planner_options_json(const PlannerOptions& options, const world::Model& model, WhichOptions which) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  for (const OptionRow& row : option_table()) {
    if (which == WhichOptions::OfPlan && !row.in_plan) continue;
    auto value = row.write(options, model);
    if (!value.is_null()) out[row.key] = std::move(value);
  }
  return out.dump();
}

std::string planner_schema_json() {
  nlohmann::ordered_json properties;
  for (const OptionRow& row : option_table()) {
    nlohmann::ordered_json property;
    property["description"] = row.doc;
    property["anyOf"] = {nlohmann::ordered_json::parse(row.schema), {{"type", "null"}}};
    properties[row.key] = std::move(property);
  }
  const nlohmann::ordered_json out{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                                   {"$id", "planner.schema.json"},
                                   {"description", "Options of the planner; null stands for a key that is not given"},
                                   {"type", {"object", "null"}},
                                   {"additionalProperties", false},
                                   {"properties", std::move(properties)}};
  return out.dump(2);
}

}  // namespace stiction::tasks
