#include "stiction/tasks/option_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "stiction/tasks/optimize_options.hpp"
#include "stiction/tasks/options.hpp"

namespace stiction::tasks {

using enum OptionLevel;
using planning::PlannerOptions;
using world::Model;
using world::YamlNode;
using Json = nlohmann::ordered_json;

double probability(const YamlNode& node) {
  const double value = node.number();
  if (value < 0 || value > 1) node.fail("a probability in [0, 1]");
  return value;
}

double share(const YamlNode& node) {
  const double value = node.positive();
  if (value > 1) node.fail("a number in (0, 1]");
  return value;
}

namespace {

/// One of two keys, each with a positive number.
std::pair<bool, double> one_of_two(const YamlNode& node, std::string_view first, std::string_view second) {
  node.require_map({first, second});
  const auto a = given(node, first);
  const auto b = given(node, second);
  if (a.has_value() == b.has_value()) node.fail(fmt::format("either '{}' or '{}'", first, second));
  return {a.has_value(), (a ? *a : *b).positive()};
}

std::string one_of_two_schema(std::string_view first, std::string_view second) {
  constexpr std::string_view value = R"({"type": ["number", "null"], "exclusiveMinimum": 0})";
  return fmt::format(R"({{"type": "object", "additionalProperties": false, "properties": {{"{}": {}, "{}": {}}}}})", first, value, second,
                     value);
}

/// Schema of a map of optional values.
std::string map_schema(std::initializer_list<std::pair<std::string_view, std::string_view>> properties) {
  std::string out = R"({"type": "object", "additionalProperties": false, "properties": {)";
  for (const auto& [key, schema] : properties) out += fmt::format(R"({}"{}": {})", out.back() == '{' ? "" : ", ", key, schema);
  return out + "}}";
}

std::vector<world::SampleBox> read_sample_boxes(const YamlNode& node, const Model& model) {
  std::vector<world::SampleBox> out;
  std::vector<std::string> known;
  for (const auto& object : model.objects()) known.push_back(object.name);
  for (const auto& [name, value] : node.entries()) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) value.fail_unknown("object", name, known);
    world::SampleBox box;
    box.object = static_cast<int>(found - known.begin());
    const int n = model.objects()[static_cast<std::size_t>(box.object)].n_v;
    value.require_map({"lower", "upper"});
    box.lower = value.at("lower").vector(n);
    box.upper = value.at("upper").vector(n);
    for (int i = 0; i < n; ++i) {
      if (box.lower[i] > box.upper[i])
        value.fail(fmt::format("lower[{0}] = {1} above upper[{0}] = {2}", i, box.lower[i], box.upper[i]), "lower ≤ upper");
    }
    out.push_back(std::move(box));
  }
  return out;
}

}  // namespace

OptionRow length_row() {
  return {"length",
          Advanced,
          true,
          "Length rule of Extend (Alg. 3): ‖δu‖ at most, or always, this [rad or m].",
          one_of_two_schema("capped", "fixed"),
          [](const YamlNode& node, const Model&, PlannerOptions& out) {
            const auto [capped, length] = one_of_two(node, "capped", "fixed");
            out.length = capped ? planning::LengthRule(planning::CappedLength{length}) : planning::FixedLength{length};
          },
          [](const PlannerOptions& o, const Model&) {
            if (const auto* capped = std::get_if<planning::CappedLength>(&o.length)) return Json{{"capped", capped->length}};
            return Json{{"fixed", std::get<planning::FixedLength>(o.length).length}};
          }};
}

OptionRow smoothing_row() {
  return {"smoothing",
          Advanced,
          true,
          "Log barrier of local models (2.27): its weight κ [1/J], and what it is times for contacts of the robot with itself and for "
          "joint limits.",
          map_schema({{"kappa", kPositive}, {"self_sharpness", kPositive}, {"limit_sharpness", kPositive}}),
          [](const YamlNode& node, const Model&, PlannerOptions& options) {
            dynamics::Analytic& out = options.smoothing;
            node.require_map({"kappa", "self_sharpness", "limit_sharpness"});
            out.kappa = node.positive_or("kappa", out.kappa);
            out.self_sharpness = node.positive_or("self_sharpness", out.self_sharpness);
            out.limit_sharpness = node.positive_or("limit_sharpness", out.limit_sharpness);
          },
          [](const PlannerOptions& o, const Model&) {
            return Json{{"kappa", o.smoothing.kappa},
                        {"self_sharpness", o.smoothing.self_sharpness},
                        {"limit_sharpness", o.smoothing.limit_sharpness}};
          }};
}

OptionRow scheme_row() {
  return {
      "scheme",
      Advanced,
      true,
      "Way to the local models of nodes (2.4.1).",
      R"({"enum": ["exact", "analytic", "randomized-first", "randomized-zeroth"]})",
      [](const YamlNode& node, const Model&, PlannerOptions& out) { out.scheme = parse_scheme("planner.advanced.scheme", node.string()); },
      [](const PlannerOptions& o, const Model&) { return Json(kSchemeNames[static_cast<std::size_t>(o.scheme)]); }};
}

OptionRow randomized_row() {
  return {"randomized",
          Advanced,
          true,
          "Samples of the two randomised schemes (2.22), (2.23).",
          R"({"$ref": "task.schema.json#/$defs/sampling"})",
          [](const YamlNode& node, const Model& model, PlannerOptions& out) { read_sampling(node, model, out.randomized); },
          [](const PlannerOptions& o, const Model&) {
            const bool used = o.scheme == planning::Scheme::RandomizedFirst || o.scheme == planning::Scheme::RandomizedZeroth;
            return used ? Json::parse(sampling_json(o.randomized)) : Json();
          }};
}

OptionRow metric_row() {
  return {
      "metric",
      Advanced,
      true,
      "Metric of Nearest: that of every node (3.5), or weighted squares that are the same everywhere [1/m², 1/rad²].",
      fmt::format(
          R"({{"oneOf": [{{"const": "local"}}, {{"type": "object", "additionalProperties": false, "required": ["global"], "properties": {{"global": {}}}}}]}})",
          map_schema({{"position", kPositive}, {"angle", kPositive}})),
      [](const YamlNode& node, const Model&, PlannerOptions& out) {
        if (!node.is_map()) {
          if (node.string() != "local") node.fail("'local', or 'global' with its weights");
          out.metric = planning::LocalMetric{};
          return;
        }
        node.require_map({"global"});
        const YamlNode weights = node.at("global");
        weights.require_map({"position", "angle"});
        planning::GlobalMetric metric;
        metric.position = weights.positive_or("position", metric.position);
        metric.angle = weights.positive_or("angle", metric.angle);
        out.metric = metric;
      },
      [](const PlannerOptions& o, const Model&) {
        const auto* global = std::get_if<planning::GlobalMetric>(&o.metric);
        return global != nullptr ? Json{{"global", {{"position", global->position}, {"angle", global->angle}}}} : Json("local");
      }};
}

OptionRow cost_row() {
  return {"cost",
          Advanced,
          true,
          "Of a path [s]: the time of its commands at these speeds [rad/s, m/s], and a price per regrasp [s].",
          map_schema({{"joint_speed", kPositive}, {"travel_speed", kPositive}, {"regrasp", kNonnegative}}),
          [](const YamlNode& node, const Model&, PlannerOptions& options) {
            node.require_map({"joint_speed", "travel_speed", "regrasp"});
            planning::PathCost& out = options.cost;
            out.joint_speed = node.positive_or("joint_speed", out.joint_speed);
            out.travel_speed = node.positive_or("travel_speed", out.travel_speed);
            out.regrasp = node.nonnegative_or("regrasp", out.regrasp);
          },
          [](const PlannerOptions& o, const Model&) {
            return Json{{"joint_speed", o.cost.joint_speed}, {"travel_speed", o.cost.travel_speed}, {"regrasp", o.cost.regrasp}};
          }};
}

OptionRow regularisation_row() {
  return {"regularisation",
          Advanced,
          true,
          "ε of the objects in (2.6c): by the rule with this ratio, or given.",
          one_of_two_schema("ratio", "epsilon"),
          [](const YamlNode& node, const Model&, PlannerOptions& out) {
            const auto [by_rule, value] = one_of_two(node, "ratio", "epsilon");
            out.regularisation = by_rule ? dynamics::Regularisation(dynamics::ByRule{value}) : dynamics::FixedEpsilon{value};
          },
          [](const PlannerOptions& o, const Model&) {
            if (const auto* rule = std::get_if<dynamics::ByRule>(&o.regularisation)) return Json{{"ratio", rule->ratio}};
            return Json{{"epsilon", std::get<dynamics::FixedEpsilon>(o.regularisation).epsilon}};
          }};
}

OptionRow substep_row() {
  return {"substep",
          Advanced,
          true,
          "Limits of one sub-step: motion of a joint [rad, m], slip of a contact times its μ [m], and their number.",
          map_schema({{"joint_angle", kPositive}, {"joint_travel", kPositive}, {"slide", kPositive}, {"max_substeps", kCount}}),
          [](const YamlNode& node, const Model&, PlannerOptions& options) {
            node.require_map({"joint_angle", "joint_travel", "slide", "max_substeps"});
            dynamics::SubstepLimits out = options.substep.value_or(dynamics::SubstepLimits{});
            out.joint_angle = node.positive_or("joint_angle", out.joint_angle);
            out.joint_travel = node.positive_or("joint_travel", out.joint_travel);
            out.slide = node.positive_or("slide", out.slide);
            if (const auto value = node.find("max_substeps")) out.max_substeps = value->positive_int();
            options.substep = out;
          },
          [](const PlannerOptions& o, const Model&) {
            if (!o.substep) return Json();
            return Json{{"joint_angle", o.substep->joint_angle},
                        {"joint_travel", o.substep->joint_travel},
                        {"slide", o.substep->slide},
                        {"max_substeps", o.substep->max_substeps}};
          }};
}

OptionRow single_step_row() {
  return {"single_step",
          Advanced,
          true,
          "One step per extension, as in the thesis, whatever `substep` says.",
          std::string(kBoolean),
          [](const YamlNode& node, const Model&, PlannerOptions& out) {
            if (node.boolean()) out.substep.reset();
          },
          [](const PlannerOptions& o, const Model&) { return o.substep ? Json() : Json(true); }};
}

OptionRow sampler_row() {
  return {"sampler",
          Advanced,
          true,
          "Contact sampler: the chance that all branches move, and that one is drawn near its posture, with what spread [rad or m], in so "
          "many draws.",
          map_schema({{"whole_probability", kProbability}, {"near_probability", kProbability}, {"near_std", kPositive}, {"tries", kCount}}),
          [](const YamlNode& node, const Model&, PlannerOptions& options) {
            node.require_map({"whole_probability", "near_probability", "near_std", "tries"});
            contact::GenericSampler& out = options.sampler;
            if (const auto v = given(node, "whole_probability")) out.whole_probability = probability(*v);
            if (const auto v = given(node, "near_probability")) out.near_probability = probability(*v);
            if (const auto v = given(node, "near_std")) out.near_std = v->positive();
            if (const auto v = given(node, "tries")) out.tries = v->positive_int();
          },
          [](const PlannerOptions& o, const Model&) {
            return Json{{"whole_probability", o.sampler.whole_probability},
                        {"near_probability", o.sampler.near_probability},
                        {"near_std", o.sampler.near_std},
                        {"tries", o.sampler.tries}};
          }};
}

OptionRow sample_box_row() {
  return {
      "sample_box",
      User,
      true,
      "Where objects may go on their way: x y z roll pitch yaw of a free object, coordinates of others [m, rad]; default: around start and "
      "goal.",
      R"({"type": "object", "additionalProperties": {"type": "object", "additionalProperties": false, "required": ["lower", "upper"], "properties": {"lower": {"$ref": "task.schema.json#/$defs/numbers"}, "upper": {"$ref": "task.schema.json#/$defs/numbers"}}}})",
      [](const YamlNode& node, const Model& model, PlannerOptions& out) { out.sample_boxes = read_sample_boxes(node, model); },
      [](const PlannerOptions& o, const Model& model) {
        const auto list = [](const Eigen::VectorXd& values) { return std::vector<double>(values.begin(), values.end()); };
        Json out = Json::object();
        for (const auto& box : o.sample_boxes)
          out[model.objects()[static_cast<std::size_t>(box.object)].name] = {{"lower", list(box.lower)}, {"upper", list(box.upper)}};
        return out;
      }};
}

OptionRow friction_law_row() {
  return {"friction_law",
          User,
          true,
          "What a sliding contact does in exact steps: anitescu, it opens by μ times its slip (2.3.4); coulomb, it stays closed. Default: "
          "coulomb in space.",
          R"({"enum": ["anitescu", "coulomb"]})",
          [](const YamlNode& node, const Model&, PlannerOptions& out) {
            out.friction_law =
                node.one_of(kFrictionLawNames) == kFrictionLawNames[1] ? dynamics::FrictionLaw::Coulomb : dynamics::FrictionLaw::Anitescu;
          },
          [](const PlannerOptions& o, const Model&) { return Json(kFrictionLawNames[static_cast<std::size_t>(o.friction_law)]); }};
}

OptionRow margins_row() {
  return {
      "margins",
      User,
      true,
      "Pushes must hold with the objects a little off, gravity a little aside and less friction at half of what touches; default: false.",
      std::string(kBoolean),
      [](const YamlNode& node, const Model&, PlannerOptions& out) { out.set_margins(node.boolean()); },
      [](const PlannerOptions& o, const Model&) { return Json(o.margins()); }};
}

OptionRow brace_force_row() {
  return {"brace_force",
          Advanced,
          true,
          "Pushes end before the robot presses on itself or on what does not move with more than this [N]; without it they do not.",
          std::string(kPositive),
          [](const YamlNode& node, const Model&, PlannerOptions& out) { out.brace_force = node.positive(); },
          [](const PlannerOptions& o, const Model&) { return std::isfinite(o.brace_force) ? Json(o.brace_force) : Json(); }};
}

OptionRow refined_fraction_row() {
  return {"refined_fraction",
          Advanced,
          true,
          "Refined plans may end at this share of the tolerances, tolerance_fraction or more; without it at that.",
          R"({"type": "number", "exclusiveMinimum": 0, "maximum": 1})",
          [](const YamlNode& node, const Model&, PlannerOptions& out) { out.refined_fraction = share(node); },
          [](const PlannerOptions& o, const Model&) { return o.refined_fraction ? Json(*o.refined_fraction) : Json(); }};
}

}  // namespace stiction::tasks
