#include "stiction/tasks/options.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "stiction/core/faults.hpp"
#include "stiction/tasks/option_table.hpp"

namespace stiction::tasks {
namespace {

using planning::PlannerOptions;
using world::YamlNode;

/// Options of the method, which went in 0.3.0.
constexpr std::string_view kAdvanced = "advanced";

void require_known_keys(const YamlNode& node) {
  if (const auto advanced = given(node, kAdvanced))
    advanced->fail(
        "no such map: the planner sets what stood there from the scene (docs/options.md). Take it out; settings of published runs are in "
        "`thesis`");
  std::vector<std::string_view> all{kAdvanced};
  for (const OptionRow& row : option_table()) all.push_back(row.key);
  node.require_map(all);
}

}  // namespace

PlannerOptions read_planner_options(const YamlNode& node, const world::Model& model, const PlannerOptions& defaults) {
  node.require_map();
  require_known_keys(node);
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
