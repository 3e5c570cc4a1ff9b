#include "stiction/tasks/option_table.hpp"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "stiction/core/parallel.hpp"
#include "stiction/tasks/option_rows.hpp"

namespace stiction::tasks {
namespace {

using planning::PlannerOptions;
using world::Model;
using world::YamlNode;
using Json = nlohmann::ordered_json;

int nonnegative_int(const YamlNode& node, int most = std::numeric_limits<int>::max()) {
  const auto value = node.integer();
  if (value < 0 || value > most)
    node.fail(most < std::numeric_limits<int>::max() ? fmt::format("an integer in [0, {}]", most) : "an integer ≥ 0");
  return static_cast<int>(value);
}

/// A field that is read and written as it is.
template <class T, class Read>
OptionRow field(std::string_view key, T PlannerOptions::*member, std::string_view schema, Read read, std::string_view doc) {
  return {key,
          true,
          doc,
          std::string(schema),
          [member, read](const YamlNode& node, const Model&, PlannerOptions& out) { out.*member = read(node); },
          [member](const PlannerOptions& o, const Model&) { return Json(o.*member); }};
}

OptionRow boolean(std::string_view key, bool PlannerOptions::*member, std::string_view doc) {
  return field(
      key, member, kBoolean, [](const YamlNode& node) { return node.boolean(); }, doc);
}

OptionRow outside_plan(OptionRow row) {
  row.in_plan = false;
  return row;
}

std::vector<OptionRow> make_table() {
  using P = PlannerOptions;
  constexpr std::string_view kShare = R"({"type": "number", "exclusiveMinimum": 0, "maximum": 1})";
  const auto seed = [](const YamlNode& node) {
    if (node.integer() < 0) node.fail("an integer ≥ 0");
    return static_cast<std::uint64_t>(node.integer());
  };
  const auto threads = [](const YamlNode& node) { return nonnegative_int(node, core::kMostThreads); };
  const auto count = [](const YamlNode& node) { return node.positive_int(); };
  return {
      outside_plan(field("seed", &P::seed, kNumberOfThem, seed, "Seed of the search. The same seed gives the same plan.")),
      outside_plan(
          field("threads", &P::threads, kNumberOfThem, threads, "Number of threads; 0 takes all cores. The plan does not depend on it.")),
      field("max_iterations", &P::max_iterations, kCount, count, "Budget of extensions of the search trees."),
      field("tolerance_fraction", &P::tolerance_fraction, kShare, share,
            "The planner aims at this share of the goal's tolerances. The rest is left for the execution."),
      sample_box_row(),
      friction_law_row(),
      field("friction", &P::friction, kShare, share, "Every friction coefficient of the plan is that of the scene times this."),
      boolean("margins", &P::margins,
              "Pushes must also hold with the objects a little off, gravity a little aside, and less friction at half of the contacts. "
              "The search takes up to three times as long, and finds few plans for hands. Default: false."),
      boolean("anytime", &P::anytime, "Go on after the first plan, for cheaper plans, until the budget is used up."),
      field("goal_bias", &P::goal_bias, kProbability, probability, "Probability that the subgoal is the goal (Alg. 2)."),
      thesis_row(),
  };
}

}  // namespace

std::optional<YamlNode> given(const YamlNode& map, std::string_view key) {
  auto value = map.find(key);
  if (value && value->kind() == YamlNode::Kind::Null) return std::nullopt;
  return value;
}

const std::vector<OptionRow>& option_table() {
  static const std::vector<OptionRow> table = make_table();
  return table;
}

}  // namespace stiction::tasks
