#include "stiction/tasks/options.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "stiction/core/faults.hpp"
#include "stiction/tasks/option_table.hpp"

namespace stiction::tasks {
namespace {

using planning::PlannerOptions;
using world::YamlNode;

void require_known_keys(const YamlNode& node, const std::optional<YamlNode>& advanced) {
  std::vector<std::string_view> all{kAdvanced}, of_method;
  for (const OptionRow& row : option_table()) {
    all.push_back(row.key);
    if (row.level == OptionLevel::Advanced) of_method.push_back(row.key);
  }
  node.require_map(all);
  if (advanced) advanced->require_map(of_method);
}

/// Where an option is given. One of the method may stand beside the user's, as in files of earlier versions: there it goes before that of the map, which a
/// base may have.
std::optional<YamlNode> find_option(const YamlNode& node, const std::optional<YamlNode>& advanced, const OptionRow& row) {
  auto value = given(node, row.key);
  if (!value && advanced && row.level == OptionLevel::Advanced) value = given(*advanced, row.key);
  return value;
}

}  // namespace

PlannerOptions read_planner_options(const YamlNode& node, const world::Model& model, const PlannerOptions& defaults) {
  node.require_map();
  const auto advanced = given(node, kAdvanced);
  require_known_keys(node, advanced);
  const auto read_over = [&](PlannerOptions out) {
    core::Faults faults;
    for (const OptionRow& row : option_table()) {
      faults.collect([&] {
        if (const auto value = find_option(node, advanced, row)) row.read(*value, model, out);
      });
    }
    faults.raise();
    return out;
  };
  PlannerOptions out = read_over(defaults);
  if (out.thesis_edges())  // single steps or jumps: they start from the settings of the thesis
    out = read_over(PlannerOptions{});
  try {
    out.validate(model);
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", node.where(), e.what()));
  }
  return out;
}

std::string planner_options_json(const PlannerOptions& options, const world::Model& model, WhichOptions which) {
  nlohmann::ordered_json out, advanced;
  for (const OptionRow& row : option_table()) {
    if (which == WhichOptions::OfPlan && !row.in_plan) continue;
    auto value = row.write(options, model);
    if (!value.is_null()) (row.level == OptionLevel::User ? out : advanced)[row.key] = std::move(value);
  }
  out[kAdvanced] = std::move(advanced);
  return out.dump();
}

std::string planner_schema_json() {
  nlohmann::ordered_json user, advanced;
  for (const OptionRow& row : option_table()) {
    nlohmann::ordered_json property;
    property["description"] = row.doc;
    property["anyOf"] = {nlohmann::ordered_json::parse(row.schema), {{"type", "null"}}};
    (row.level == OptionLevel::User ? user : advanced)[row.key] = std::move(property);
  }
  const auto map = [](std::string_view doc, nlohmann::ordered_json properties) {
    return nlohmann::ordered_json{
        {"description", doc}, {"type", {"object", "null"}}, {"additionalProperties", false}, {"properties", std::move(properties)}};
  };
  user[kAdvanced] = map("Of the method, for experiments; defaults follow from the scene", std::move(advanced));
  nlohmann::ordered_json out{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"$id", "planner.schema.json"}};
  out.update(map("Options of the planner; null stands for a key that is not given", std::move(user)));
  return out.dump(2);
}

}  // namespace stiction::tasks
