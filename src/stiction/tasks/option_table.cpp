#include "stiction/tasks/option_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "stiction/tasks/option_rows.hpp"

namespace stiction::tasks {
namespace {

using enum OptionLevel;
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
OptionRow field(OptionLevel level, std::string_view key, T PlannerOptions::*member, std::string_view schema, Read read,
                std::string_view doc) {
  return {key,
          level,
          true,
          doc,
          std::string(schema),
          [member, read](const YamlNode& node, const Model&, PlannerOptions& out) { out.*member = read(node); },
          [member](const PlannerOptions& o, const Model&) { return Json(o.*member); }};
}

OptionRow positive(OptionLevel level, std::string_view key, double PlannerOptions::*member, std::string_view doc) {
  return field(
      level, key, member, kPositive, [](const YamlNode& node) { return node.positive(); }, doc);
}

OptionRow nonnegative(OptionLevel level, std::string_view key, double PlannerOptions::*member, std::string_view doc) {
  return field(
      level, key, member, kNonnegative, [](const YamlNode& node) { return node.nonnegative(); }, doc);
}

OptionRow count(OptionLevel level, std::string_view key, int PlannerOptions::*member, std::string_view doc) {
  return field(
      level, key, member, kCount, [](const YamlNode& node) { return node.positive_int(); }, doc);
}

OptionRow boolean(OptionLevel level, std::string_view key, bool PlannerOptions::*member, std::string_view doc) {
  return field(
      level, key, member, kBoolean, [](const YamlNode& node) { return node.boolean(); }, doc);
}

OptionRow chance(OptionLevel level, std::string_view key, double PlannerOptions::*member, std::string_view doc) {
  return field(level, key, member, kProbability, probability, doc);
}

OptionRow outside_plan(OptionRow row) {
  row.in_plan = false;
  return row;
}

std::vector<OptionRow> make_table() {
  using P = PlannerOptions;
  const auto seed = [](const YamlNode& node) {
    if (node.integer() < 0) node.fail("an integer ≥ 0");
    return static_cast<std::uint64_t>(node.integer());
  };
  return {
      outside_plan(field(User, "seed", &P::seed, kNumberOfThem, seed, "Of the search: the same seed gives the same plan.")),
      outside_plan(field(
          User, "threads", &P::threads, kNumberOfThem, [](const YamlNode& node) { return nonnegative_int(node, 1024); },
          "0: all cores; the plan does not depend on it.")),
      count(User, "max_iterations", &P::max_iterations, "Budget of extensions."),
      field(User, "tolerance_fraction", &P::tolerance_fraction, R"({"type": "number", "exclusiveMinimum": 0, "maximum": 1})", share,
            "The planner aims at this share of the goal's tolerances; what is left is for the execution."),
      sample_box_row(),
      friction_law_row(),
      margins_row(),
      boolean(User, "anytime", &P::anytime, "Go on after the first plan, for cheaper ones, until the budget is used up."),
      chance(User, "goal_bias", &P::goal_bias, "Probability that the subgoal is the goal (Alg. 2)."),
      chance(User, "grasp_probability", &P::grasp_probability,
             "Probability that a node gets a contact sample instead of an extension (Alg. 2)."),
      // The search.
      count(Advanced, "trees", &P::trees, "Trees that grow side by side; the plan does depend on it."),
      count(Advanced, "batch", &P::batch, "Extensions under way at once in each tree; the plan does depend on it."),
      boolean(Advanced, "stop_at_goal", &P::stop_at_goal, "false: all of max_iterations, to measure time."),
      outside_plan(boolean(Advanced, "record_tree", &P::record_tree, "Keep every node in the result (library and Python).")),
      positive(Advanced, "gamma", &P::gamma, "γ of the metric (3.5)."),
      length_row(),
      scheme_row(),
      smoothing_row(),
      randomized_row(),
      metric_row(),
      positive(Advanced, "goal_sharpening", &P::goal_sharpening, "κ grows up to this factor near the goal, ≥ 1."),
      cost_row(),
      sampler_row(),
      count(Advanced, "grasp_candidates", &P::grasp_candidates, "Postures drawn for a regrasp; the most promising is taken."),
      field(
          Advanced, "grasp_trials", &P::grasp_trials, kNumberOfThem, [](const YamlNode& node) { return nonnegative_int(node); },
          "So many of the most promising of these are simulated, and the best of them is taken."),
      // Steps.
      positive(Advanced, "h", &P::h, "Time step [s]."),
      regularisation_row(),
      substep_row(),
      single_step_row(),
      boolean(Advanced, "real_regrasps", &P::real_regrasps, "false: the robot jumps to its contact samples, as in the thesis."),
      positive(Advanced, "friction", &P::friction, "Every μ of the plan is that of the scene times this, in (0, 1]."),
      // What an edge must hold.
      positive(Advanced, "fidelity_edge", &P::fidelity_edge,
               "Half the sub-step leads to the same place, up to this share of the tolerances, on each edge …"),
      positive(Advanced, "fidelity_path", &P::fidelity_path, "… and up to this share on the whole path."),
      nonnegative(Advanced, "start_noise", &P::start_noise,
                  "Pushes do the same when they start with the objects off by up to this share of the tolerances …"),
      nonnegative(Advanced, "edge_tilt", &P::edge_tilt, "… with gravity this far aside, from each of four sides [rad] …"),
      nonnegative(Advanced, "friction_noise", &P::friction_noise, "… and with μ less by this share at half of what touches, in [0, 1)."),
      nonnegative(Advanced, "grip_force", &P::grip_force,
                  "Pushes start with the springs as strained as they are, up to this at the reach of a joint (P.11) [N]."),
      brace_force_row(),
      // What a regrasp must hold.
      positive(Advanced, "regrasp_friction", &P::regrasp_friction, "Regrasps hold with every μ times this, in (0, 1]."),
      positive(Advanced, "regrasp_clearance", &P::regrasp_clearance, "Moving branches keep this distance between their contacts [m]."),
      positive(Advanced, "regrasp_tol_position", &P::regrasp_tol_position, "An object may move this far while branches move [m] …"),
      positive(Advanced, "regrasp_tol_angle", &P::regrasp_tol_angle, "… and turn this far [rad]."),
      positive(Advanced, "release_tol_position", &P::release_tol_position, "It may settle this far when it is let go of [m] …"),
      positive(Advanced, "release_tol_angle", &P::release_tol_angle, "… and turn this far [rad]."),
      refined_fraction_row(),
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
