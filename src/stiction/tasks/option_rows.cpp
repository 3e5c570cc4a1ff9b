#include "stiction/tasks/option_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "stiction/tasks/optimize_options.hpp"
#include "stiction/tasks/options.hpp"

namespace stiction::tasks {

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

namespace {

using planning::thesis::Settings;

void read_smoothing(const YamlNode& node, dynamics::Analytic& out) {
  node.require_map({"kappa", "self_sharpness", "limit_sharpness"});
  out.kappa = node.positive_or("kappa", out.kappa);
  out.self_sharpness = node.positive_or("self_sharpness", out.self_sharpness);
  out.limit_sharpness = node.positive_or("limit_sharpness", out.limit_sharpness);
}

std::optional<planning::thesis::GlobalMetric> read_metric(const YamlNode& node) {
  if (!node.is_map()) {
    if (node.string() != "local") node.fail("'local', or 'global' with its weights");
    return std::nullopt;
  }
  node.require_map({"global"});
  const YamlNode weights = node.at("global");
  weights.require_map({"position", "angle"});
  planning::thesis::GlobalMetric metric;
  metric.position = weights.positive_or("position", metric.position);
  metric.angle = weights.positive_or("angle", metric.angle);
  return metric;
}

dynamics::Regularisation read_regularisation_of(const YamlNode& node) {
  const auto [by_rule, value] = one_of_two(node, "ratio", "epsilon");
  if (by_rule) return dynamics::ByRule{value};
  return dynamics::FixedEpsilon{value};
}

void read_thesis(const YamlNode& node, const Model& model, Settings& out) {
  node.require_map(
      {"grasp_probability", "length", "gamma", "scheme", "smoothing", "randomized", "metric", "h", "regularisation", "stop_at_goal"});
  if (const auto v = given(node, "grasp_probability")) out.grasp_probability = probability(*v);
  out.length = node.positive_or("length", out.length);
  out.gamma = node.positive_or("gamma", out.gamma);
  out.h = node.positive_or("h", out.h);
  if (const auto v = given(node, "scheme")) out.scheme = parse_scheme("planner.thesis.scheme", v->string());
  if (const auto v = given(node, "smoothing")) read_smoothing(*v, out.smoothing);
  if (const auto v = given(node, "randomized")) read_sampling(*v, model, out.randomized);
  if (const auto v = given(node, "metric")) out.metric = read_metric(*v);
  if (const auto v = given(node, "regularisation")) out.regularisation = read_regularisation_of(*v);
  if (const auto v = given(node, "stop_at_goal")) out.stop_at_goal = v->boolean();
}

Json thesis_json(const Settings& s) {
  using planning::thesis::Scheme;
  const Json sampling = Json::parse(sampling_json(s.randomized));
  Json out{
      {"grasp_probability", s.grasp_probability},
      {"length", s.length},
      {"gamma", s.gamma},
      {"scheme", kSchemeNames[static_cast<std::size_t>(s.scheme)]},
      {"smoothing",
       {{"kappa", s.smoothing.kappa}, {"self_sharpness", s.smoothing.self_sharpness}, {"limit_sharpness", s.smoothing.limit_sharpness}}}};
  // Another scheme may be chosen later, with the samples that the task gives.
  if (s.scheme == Scheme::RandomizedFirst || s.scheme == Scheme::RandomizedZeroth || sampling != Json::parse(sampling_json({})))
    out["randomized"] = sampling;
  out["metric"] = s.metric ? Json{{"global", {{"position", s.metric->position}, {"angle", s.metric->angle}}}} : Json("local");
  out["h"] = s.h;
  const auto* rule = std::get_if<dynamics::ByRule>(&s.regularisation);
  out["regularisation"] =
      rule != nullptr ? Json{{"ratio", rule->ratio}} : Json{{"epsilon", std::get<dynamics::FixedEpsilon>(s.regularisation).epsilon}};
  out["stop_at_goal"] = s.stop_at_goal;
  return out;
}

std::string thesis_schema() {
  const std::string metric = fmt::format(
      R"({{"oneOf": [{{"const": "local"}}, {{"type": "object", "additionalProperties": false, "required": ["global"], "properties": {{"global": {}}}}}]}})",
      map_schema({{"position", kPositive}, {"angle", kPositive}}));
  const std::string smoothing = map_schema({{"kappa", kPositive}, {"self_sharpness", kPositive}, {"limit_sharpness", kPositive}});
  const std::string regularisation = one_of_two_schema("ratio", "epsilon");
  return map_schema({{"grasp_probability", kProbability},
                     {"length", kPositive},
                     {"gamma", kPositive},
                     {"scheme", R"({"enum": ["exact", "analytic", "randomized-first", "randomized-zeroth"]})"},
                     {"smoothing", smoothing},
                     {"randomized", R"({"$ref": "task.schema.json#/$defs/sampling"})"},
                     {"metric", metric},
                     {"h", kPositive},
                     {"regularisation", regularisation},
                     {"stop_at_goal", kBoolean}});
}

}  // namespace

OptionRow thesis_row() {
  return {"thesis",
          true,
          "Algorithm 2 as printed, with single steps and jumps to contacts, for the tables and figures of the thesis. Keys: "
          "`grasp_probability`, "
          "`length` of extensions [rad or m], `gamma` of the metric (3.5), `scheme` of local models (2.4.1) with its `smoothing` (κ in "
          "1/J, 2.27) "
          "or samples `randomized` (2.22, 2.23), `metric` of Nearest, time step `h` [s], `regularisation` (ε in 2.6c), `stop_at_goal` "
          "(false to "
          "measure time).",
          thesis_schema(),
          [](const YamlNode& node, const Model& model, PlannerOptions& out) {
            if (!out.thesis) out.thesis.emplace();
            read_thesis(node, model, *out.thesis);
          },
          [](const PlannerOptions& o, const Model&) { return o.thesis ? thesis_json(*o.thesis) : Json(); }};
}

OptionRow sample_box_row() {
  return {
      "sample_box",
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
          true,
          "What a sliding contact does in exact steps: anitescu, it opens by μ times its slip (2.3.4); coulomb, it stays closed. Default: "
          "coulomb in space.",
          R"({"enum": ["anitescu", "coulomb"]})",
          [](const YamlNode& node, const Model&, PlannerOptions& out) {
            out.friction_law =
                node.one_of(kFrictionLawNames) == kFrictionLawNames[1] ? dynamics::FrictionLaw::Coulomb : dynamics::FrictionLaw::Anitescu;
          },
          [](const PlannerOptions& o, const Model&) {
            return o.friction_law ? Json(kFrictionLawNames[static_cast<std::size_t>(*o.friction_law)]) : Json();
          }};
}

}  // namespace stiction::tasks
