#include "stiction/tasks/options.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "stiction/core/invalid_input.hpp"
#include "stiction/tasks/optimize_options.hpp"

namespace stiction::tasks {
namespace {

using planning::PlannerOptions;
using world::YamlNode;

/// The value of a key, nullopt when it is missing or null.
std::optional<YamlNode> given(const YamlNode& map, std::string_view key) {
  auto value = map.find(key);
  if (value && value->kind() == YamlNode::Kind::Null) return std::nullopt;
  return value;
}

double probability(const YamlNode& node) {
  const double value = node.number();
  if (value < 0 || value > 1) node.fail("a probability in [0, 1]");
  return value;
}

int nonnegative_int(const YamlNode& node) {
  const auto value = node.integer();
  if (value < 0 || value > std::numeric_limits<int>::max()) node.fail("an integer ≥ 0");
  return static_cast<int>(value);
}

/// One of two keys, each with a positive number.
std::pair<bool, double> one_of_two(const YamlNode& node, std::string_view first, std::string_view second) {
  node.require_map({first, second});
  const auto a = given(node, first);
  const auto b = given(node, second);
  if (a.has_value() == b.has_value()) node.fail(fmt::format("either '{}' or '{}'", first, second));
  return {a.has_value(), (a ? *a : *b).positive()};
}

dynamics::SubstepLimits read_substep(const YamlNode& node, dynamics::SubstepLimits out) {
  node.require_map({"joint_angle", "joint_travel", "slide", "max_substeps"});
  out.joint_angle = node.positive_or("joint_angle", out.joint_angle);
  out.joint_travel = node.positive_or("joint_travel", out.joint_travel);
  out.slide = node.positive_or("slide", out.slide);
  if (const auto value = node.find("max_substeps")) out.max_substeps = value->positive_int();
  return out;
}

dynamics::Analytic read_smoothing(const YamlNode& node, dynamics::Analytic out) {
  node.require_map({"kappa", "self_sharpness", "limit_sharpness"});
  out.kappa = node.positive_or("kappa", out.kappa);
  out.self_sharpness = node.positive_or("self_sharpness", out.self_sharpness);
  out.limit_sharpness = node.positive_or("limit_sharpness", out.limit_sharpness);
  return out;
}

planning::PathCost read_cost(const YamlNode& node) {
  node.require_map({"joint_speed", "travel_speed", "regrasp"});
  planning::PathCost out;
  out.joint_speed = node.positive_or("joint_speed", out.joint_speed);
  out.travel_speed = node.positive_or("travel_speed", out.travel_speed);
  out.regrasp = node.nonnegative_or("regrasp", out.regrasp);
  return out;
}

planning::Metric read_metric(const YamlNode& node) {
  if (!node.is_map()) {
    if (node.string() != "local") node.fail("'local', or 'global' with its weights");
    return planning::LocalMetric{};
  }
  node.require_map({"global"});
  const YamlNode weights = node.at("global");
  weights.require_map({"position", "angle"});
  planning::GlobalMetric out;
  out.position = weights.positive_or("position", out.position);
  out.angle = weights.positive_or("angle", out.angle);
  return out;
}

planning::GenericSampler read_generic(const YamlNode& node) {
  planning::GenericSampler out;
  if (node.kind() == YamlNode::Kind::Null) return out;
  node.require_map({"whole_probability", "near_probability", "near_std", "tries"});
  if (const auto v = given(node, "whole_probability")) out.whole_probability = probability(*v);
  if (const auto v = given(node, "near_probability")) out.near_probability = probability(*v);
  if (const auto v = given(node, "near_std")) out.near_std = v->positive();
  if (const auto v = given(node, "tries")) out.tries = v->positive_int();
  return out;
}

planning::GenericSampler read_sampler(const YamlNode& node) {
  node.require_map({"generic"});
  return read_generic(node.at("generic"));
}

nlohmann::ordered_json to_json(const Eigen::VectorXd& values) { return std::vector<double>(values.begin(), values.end()); }

nlohmann::ordered_json sampler_json(const planning::GenericSampler& sampler) {
  nlohmann::ordered_json out;
  auto& entry = out["generic"];
  entry["whole_probability"] = sampler.whole_probability;
  entry["near_probability"] = sampler.near_probability;
  entry["near_std"] = sampler.near_std;
  entry["tries"] = sampler.tries;
  return out;
}

std::vector<planning::SampleBox> read_sample_boxes(const YamlNode& node, const world::Model& model) {
  std::vector<planning::SampleBox> out;
  std::vector<std::string> known;
  for (const auto& object : model.objects()) known.push_back(object.name);
  for (const auto& [name, value] : node.entries()) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) value.fail_unknown("object", name, known);
    planning::SampleBox box;
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

PlannerOptions read_planner_options(const YamlNode& node, const world::Model& model, const PlannerOptions& defaults) {
  node.require_map({"seed",
                    "threads",
                    "trees",
                    "batch",
                    "max_iterations",
                    "stop_at_goal",
                    "goal_bias",
                    "grasp_probability",
                    "gamma",
                    "length",
                    "smoothing",
                    "scheme",
                    "randomized",
                    "metric",
                    "record_tree",
                    "anytime",
                    "cost",
                    "goal_sharpening",
                    "h",
                    "regularisation",
                    "substep",
                    "single_step",
                    "real_regrasps",
                    "friction_law",
                    "friction",
                    "edge_friction",
                    "edge_tilt",
                    "friction_noise",
                    "rest_time",
                    "start_noise",
                    "squeeze",
                    "grip_force",
                    "brace_force",
                    "regrasp_friction",
                    "regrasp_clearance",
                    "regrasp_tol_position",
                    "regrasp_tol_angle",
                    "release_tol_position",
                    "release_tol_angle",
                    "grasp_candidates",
                    "grasp_trials",
                    "sampler",
                    "sample_box",
                    "fidelity_edge",
                    "fidelity_path",
                    "tolerance_fraction",
                    "refined_fraction"});
  const auto single = given(node, "single_step"), real = given(node, "real_regrasps");
  const bool thesis = (single && single->boolean()) || (real && !real->boolean());
  PlannerOptions out = thesis ? PlannerOptions{} : defaults;
  if (const auto v = given(node, "seed")) {
    if (v->integer() < 0) v->fail("an integer ≥ 0");
    out.seed = static_cast<std::uint64_t>(v->integer());
  }
  if (const auto v = given(node, "threads")) {
    if (v->integer() < 0 || v->integer() > 1024) v->fail("an integer in [0, 1024]");
    out.threads = static_cast<int>(v->integer());
  }
  if (const auto v = given(node, "trees")) out.trees = v->positive_int();
  if (const auto v = given(node, "batch")) out.batch = v->positive_int();
  if (const auto v = given(node, "max_iterations")) out.max_iterations = v->positive_int();
  if (const auto v = given(node, "stop_at_goal")) out.stop_at_goal = v->boolean();
  if (const auto v = given(node, "goal_bias")) out.goal_bias = probability(*v);
  if (const auto v = given(node, "grasp_probability")) out.grasp_probability = probability(*v);
  if (const auto v = given(node, "gamma")) out.gamma = v->positive();
  if (const auto v = given(node, "length")) {
    const auto [capped, length] = one_of_two(*v, "capped", "fixed");
    if (capped) {
      out.length = planning::CappedLength{length};
    } else {
      out.length = planning::FixedLength{length};
    }
  }
  if (const auto v = given(node, "smoothing")) out.smoothing = read_smoothing(*v, out.smoothing);
  if (const auto v = given(node, "scheme")) out.scheme = parse_scheme("planner.scheme", v->string());
  if (const auto v = given(node, "randomized")) read_sampling(*v, model, out.randomized);
  if (const auto v = given(node, "metric")) out.metric = read_metric(*v);
  if (const auto v = given(node, "anytime")) out.anytime = v->boolean();
  if (const auto v = given(node, "cost")) out.cost = read_cost(*v);
  if (const auto v = given(node, "record_tree")) out.record_tree = v->boolean();
  if (const auto v = given(node, "goal_sharpening")) out.goal_sharpening = v->positive();
  if (const auto v = given(node, "h")) out.h = v->positive();
  if (const auto v = given(node, "regularisation")) {
    const auto [by_rule, value] = one_of_two(*v, "ratio", "epsilon");
    if (by_rule) {
      out.regularisation = dynamics::ByRule{value};
    } else {
      out.regularisation = dynamics::FixedEpsilon{value};
    }
  }
  if (const auto v = given(node, "substep")) out.substep = read_substep(*v, out.substep.value_or(dynamics::SubstepLimits{}));
  if (single && single->boolean()) out.substep.reset();
  if (real) out.real_regrasps = real->boolean();
  if (const auto v = given(node, "friction_law"))
    out.friction_law =
        v->one_of(kFrictionLawNames) == kFrictionLawNames[1] ? dynamics::FrictionLaw::Coulomb : dynamics::FrictionLaw::Anitescu;
  if (const auto v = given(node, "friction")) out.friction = v->positive();
  if (const auto v = given(node, "edge_friction")) out.edge_friction = v->positive();
  if (const auto v = given(node, "edge_tilt")) out.edge_tilt = v->nonnegative();
  if (const auto v = given(node, "friction_noise")) out.friction_noise = v->nonnegative();
  if (const auto v = given(node, "rest_time")) out.rest_time = v->positive();
  if (const auto v = given(node, "start_noise")) out.start_noise = v->nonnegative();
  if (const auto v = given(node, "squeeze")) out.squeeze = v->nonnegative();
  if (const auto v = given(node, "grip_force")) out.grip_force = v->nonnegative();
  if (const auto v = given(node, "brace_force")) out.brace_force = v->positive();
  if (const auto v = given(node, "regrasp_friction")) out.regrasp_friction = v->positive();
  if (const auto v = given(node, "regrasp_clearance")) out.regrasp_clearance = v->positive();
  if (const auto v = given(node, "regrasp_tol_position")) out.regrasp_tol_position = v->positive();
  if (const auto v = given(node, "regrasp_tol_angle")) out.regrasp_tol_angle = v->positive();
  if (const auto v = given(node, "release_tol_position")) out.release_tol_position = v->positive();
  if (const auto v = given(node, "release_tol_angle")) out.release_tol_angle = v->positive();
  if (const auto v = given(node, "grasp_candidates")) out.grasp_candidates = v->positive_int();
  if (const auto v = given(node, "grasp_trials")) out.grasp_trials = nonnegative_int(*v);
  if (const auto v = given(node, "sampler")) out.sampler = read_sampler(*v);
  if (const auto v = given(node, "sample_box")) out.sample_boxes = read_sample_boxes(*v, model);
  if (const auto v = given(node, "fidelity_edge")) out.fidelity_edge = v->positive();
  if (const auto v = given(node, "fidelity_path")) out.fidelity_path = v->positive();
  if (const auto v = given(node, "tolerance_fraction")) {
    out.tolerance_fraction = v->positive();
    if (out.tolerance_fraction > 1) v->fail("a number in (0, 1]");
  }
  if (const auto v = given(node, "refined_fraction")) out.refined_fraction = v->positive();
  try {
    out.validate(model);
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", node.where(), e.what()));
  }
  return out;
}

std::string planner_options_json(const PlannerOptions& o, const world::Model& model) {
  nlohmann::ordered_json out;
  out["trees"] = o.trees;
  out["batch"] = o.batch;
  out["max_iterations"] = o.max_iterations;
  out["stop_at_goal"] = o.stop_at_goal;
  out["goal_bias"] = o.goal_bias;
  out["grasp_probability"] = o.grasp_probability;
  out["gamma"] = o.gamma;
  if (const auto* capped = std::get_if<planning::CappedLength>(&o.length)) {
    out["length"]["capped"] = capped->length;
  } else {
    out["length"]["fixed"] = std::get<planning::FixedLength>(o.length).length;
  }
  out["smoothing"]["kappa"] = o.smoothing.kappa;
  out["smoothing"]["self_sharpness"] = o.smoothing.self_sharpness;
  out["smoothing"]["limit_sharpness"] = o.smoothing.limit_sharpness;
  out["scheme"] = kSchemeNames[static_cast<std::size_t>(o.scheme)];
  if (o.scheme == planning::Scheme::RandomizedFirst || o.scheme == planning::Scheme::RandomizedZeroth)
    out["randomized"] = nlohmann::ordered_json::parse(sampling_json(o.randomized));
  if (const auto* global = std::get_if<planning::GlobalMetric>(&o.metric)) {
    out["metric"]["global"] = {{"position", global->position}, {"angle", global->angle}};
  } else {
    out["metric"] = "local";
  }
  out["anytime"] = o.anytime;
  out["cost"] = {{"joint_speed", o.cost.joint_speed}, {"travel_speed", o.cost.travel_speed}, {"regrasp", o.cost.regrasp}};
  out["goal_sharpening"] = o.goal_sharpening;
  out["h"] = o.h;
  if (const auto* rule = std::get_if<dynamics::ByRule>(&o.regularisation)) {
    out["regularisation"]["ratio"] = rule->ratio;
  } else {
    out["regularisation"]["epsilon"] = std::get<dynamics::FixedEpsilon>(o.regularisation).epsilon;
  }
  if (o.substep) {
    auto& substep = out["substep"];
    substep["joint_angle"] = o.substep->joint_angle;
    substep["joint_travel"] = o.substep->joint_travel;
    substep["slide"] = o.substep->slide;
    substep["max_substeps"] = o.substep->max_substeps;
  } else {
    out["single_step"] = true;
  }
  out["real_regrasps"] = o.real_regrasps;
  out["friction_law"] = kFrictionLawNames[static_cast<std::size_t>(o.friction_law)];
  out["friction"] = o.friction;
  out["edge_friction"] = o.edge_friction;
  out["edge_tilt"] = o.edge_tilt;
  out["friction_noise"] = o.friction_noise;
  out["rest_time"] = o.rest_time;
  out["start_noise"] = o.start_noise;
  out["squeeze"] = o.squeeze;
  if (o.grip_force > 0) out["grip_force"] = o.grip_force;
  if (std::isfinite(o.brace_force)) out["brace_force"] = o.brace_force;
  out["regrasp_friction"] = o.regrasp_friction;
  out["regrasp_clearance"] = o.regrasp_clearance;
  out["regrasp_tol_position"] = o.regrasp_tol_position;
  out["regrasp_tol_angle"] = o.regrasp_tol_angle;
  out["release_tol_position"] = o.release_tol_position;
  out["release_tol_angle"] = o.release_tol_angle;
  out["grasp_candidates"] = o.grasp_candidates;
  out["grasp_trials"] = o.grasp_trials;
  out["sampler"] = sampler_json(o.sampler);
  out["sample_box"] = nlohmann::ordered_json::object();
  for (const auto& box : o.sample_boxes) {
    auto& entry = out["sample_box"][model.objects()[static_cast<std::size_t>(box.object)].name];
    entry["lower"] = to_json(box.lower);
    entry["upper"] = to_json(box.upper);
  }
  out["fidelity_edge"] = o.fidelity_edge;
  out["fidelity_path"] = o.fidelity_path;
  out["tolerance_fraction"] = o.tolerance_fraction;
  if (o.refined_fraction) out["refined_fraction"] = *o.refined_fraction;
  return out.dump();
}

}  // namespace stiction::tasks
