#include "stiction/tasks/arm_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/read.hpp"

namespace stiction::tasks {

using execution::ContactSource;
using execution::ControlScenario;
using world::YamlNode;

namespace {

std::vector<std::string> link_names(const world::Model& model) {
  std::vector<std::string> out;
  for (const auto& body : model.bodies())
    if (body.kind == world::BodyKind::Robot) out.push_back(body.name);
  return out;
}

control::Law read_law(const YamlNode& node) {
  const std::string name = node.one_of({"contact_aware", "unconstrained", "null_space", "force_equality"});
  return name == "contact_aware"   ? control::Law::ContactAware
         : name == "unconstrained" ? control::Law::Unconstrained
         : name == "null_space"    ? control::Law::NullSpace
                                   : control::Law::ForceEquality;
}

void read_damping(const YamlNode& node, control::ForceDampingOptions& out) {
  node.require_map({"largest", "force_scale", "forget_rate", "printed"});
  out.largest = node.nonnegative_or("largest", out.largest);
  out.force_scale = node.positive_or("force_scale", out.force_scale);
  out.forget_rate = node.positive_or("forget_rate", out.forget_rate);
  out.printed = node.boolean_or("printed", out.printed);
}

void read_controller(const YamlNode& node, ControlScenario& out) {
  node.require_map({"period", "law", "cost", "lambda_max", "force_threshold", "force_time_constant", "release_time", "max_contacts",
                    "revolute_speed", "prismatic_speed", "torque", "tool_length", "unilateral", "contact_compliance", "posture_weight",
                    "posture_time_constant", "damping"});
  control::ControllerOptions& c = out.controller;
  out.period = node.positive_or("period", out.period);
  if (const auto law = node.find("law")) c.law = read_law(*law);
  if (const auto cost = node.find("cost"))
    c.qp.cost = cost->one_of({"command", "equilibrium"}) == "command" ? control::TrackingCost::Command : control::TrackingCost::Equilibrium;
  c.lambda_max = node.positive_or("lambda_max", c.lambda_max);
  c.force_threshold = node.nonnegative_or("force_threshold", std::min(c.force_threshold, c.lambda_max / 3));
  c.force_time_constant = node.nonnegative_or("force_time_constant", c.force_time_constant);
  c.release_time = node.positive_or("release_time", c.release_time);
  if (const auto room = node.find("max_contacts")) c.max_contacts = room->positive_int();
  c.revolute_speed = node.positive_or("revolute_speed", c.revolute_speed);
  c.prismatic_speed = node.positive_or("prismatic_speed", c.prismatic_speed);
  if (const auto torque = node.find("torque")) c.torque = torque->vector(out.model->n_a());
  c.tool_length = node.positive_or("tool_length", c.tool_length);
  c.qp.unilateral = node.boolean_or("unilateral", c.qp.unilateral);
  c.qp.contact_compliance = node.positive_or("contact_compliance", c.qp.contact_compliance);
  c.qp.posture_weight = node.positive_or("posture_weight", c.qp.posture_weight);
  c.posture_time_constant = node.nonnegative_or("posture_time_constant", c.posture_time_constant);
  if (const auto damping = node.find("damping")) read_damping(*damping, c.damping);
}

void read_plant(const YamlNode& node, ControlScenario& out) {
  node.require_map({"timestep", "armature", "friction_scale", "contact_time_constant", "impedance", "joint_friction"});
  out.plant.joint_friction = node.boolean_or("joint_friction", out.plant.joint_friction);
  out.plant.timestep = node.positive_or("timestep", out.plant.timestep);
  out.plant.armature = node.nonnegative_or("armature", out.plant.armature);
  out.plant.contact.friction_scale = node.nonnegative_or("friction_scale", out.plant.contact.friction_scale);
  out.plant.contact.time_constant = node.positive_or("contact_time_constant", out.plant.contact.time_constant);
  if (const auto impedance = node.find("impedance")) {
    impedance->require_map({"period", "damping_ratio", "velocity_cutoff", "gain_cutoff"});
    out.impedance.period = impedance->positive_or("period", out.impedance.period);
    out.impedance.damping_ratio = impedance->nonnegative_or("damping_ratio", out.impedance.damping_ratio);
    out.impedance.velocity_cutoff = impedance->positive_or("velocity_cutoff", out.impedance.velocity_cutoff);
    out.impedance.gain_cutoff = impedance->positive_or("gain_cutoff", out.impedance.gain_cutoff);
  }
}

constexpr int kRays = 4;  // rays of an estimator's friction cone

/// Cone of four rays that encloses the exact friction cone of the robot's surface. Touched bodies are assumed to be no rougher than the
/// robot.
sensing::FrictionCone make_cone(const world::Model& model) {
  double friction = 0;
  for (const auto& geometry : model.geometries())
    if (model.bodies()[static_cast<std::size_t>(geometry.body)].kind == world::BodyKind::Robot)
      friction = std::max(friction, geometry.friction);
  return sensing::FrictionCone(std::sqrt(2.0) * friction, kRays);
}

/// One number for all joints or one for each. An estimator that has one number takes the largest.
void read_noise(const YamlNode& node, int n_a, simulation::ObserverOptions& out) {
  if (!node.is_sequence()) {
    out.noise = node.positive();
    return;
  }
  out.joint_noise = node.vector(n_a);
  if (!(out.joint_noise.minCoeff() > 0)) node.fail("numbers > 0, one for each joint");
  out.noise = out.joint_noise.maxCoeff();
}

/// Reads `true` for the standard sensor, or a map of the values that differ from it.
std::optional<execution::BaseSensorOptions> read_base_sensor(const YamlNode& node) {
  execution::BaseSensorOptions out;
  if (!node.is_map()) return node.boolean() ? std::optional(out) : std::nullopt;
  node.require_map({"force_noise", "moment_noise", "force_offset", "moment_offset"});
  out.force_noise = node.positive_or("force_noise", out.force_noise);
  out.moment_noise = node.positive_or("moment_noise", out.moment_noise);
  out.force_offset = node.nonnegative_or("force_offset", out.force_offset);
  out.moment_offset = node.nonnegative_or("moment_offset", out.moment_offset);
  return out;
}

void read_estimator(const YamlNode& node, ControlScenario& out) {
  node.require_map({"contacts",       "delay",         "time_constant",   "noise",        "rest",       "drift",   "bias",     "bias_reach",
                    "offsets",        "inertia_error", "friction_error",  "seed",         "links",      "samples", "friction", "threshold",
                    "max_candidates", "max_contacts",  "plausible_force", "max_descents", "base_wrench"});
  if (const auto contacts = node.find("contacts"))
    out.contacts = contacts->one_of({"true", "estimated"}) == "true" ? ContactSource::True : ContactSource::Estimated;
  out.delay = node.nonnegative_or("delay", out.delay);
  simulation::ObserverOptions& o = out.observer;
  o.time_constant = node.positive_or("time_constant", o.time_constant);
  if (const auto noise = node.find("noise")) read_noise(*noise, out.model->n_a(), o);
  if (const auto rest = node.find("rest")) o.rest = rest->vector(out.model->n_a());
  if (const auto drift = node.find("drift")) o.drift = drift->vector(out.model->n_a());
  o.bias = node.nonnegative_or("bias", o.bias);
  o.bias_reach = node.nonnegative_or("bias_reach", o.bias_reach);
  if (const auto error = node.find("inertia_error")) o.inertia_error = error->number();
  if (const auto error = node.find("friction_error")) o.friction_error = error->number();
  const std::int64_t seed = node.integer_or("seed", 0);
  if (seed < 0) node.at("seed").fail("an integer ≥ 0");
  o.seed = static_cast<std::uint64_t>(seed);
  execution::ContactEstimatorOptions& e = out.estimator;
  e.bias = node.nonnegative_or("offsets", o.bias);
  if (const auto links = node.find("links"))
    for (const auto& link : links->items()) {
      const std::string pattern = e.sensor.links.emplace_back(link.string());
      const std::vector<std::string> names = link_names(*out.model);
      if (std::none_of(names.begin(), names.end(), [&](const auto& name) { return world::matches_pattern(pattern, name); }))
        link.fail_unknown("link", pattern, names);
    }
  if (const auto samples = node.find("samples")) e.sensor.samples = samples->positive_int();
  if (const auto friction = node.find("friction")) e.sense.cone = sensing::FrictionCone(friction->nonnegative(), kRays);
  if (const auto threshold = node.find("threshold")) e.sense.threshold = threshold->positive();
  if (const auto most = node.find("max_descents")) e.sense.max_descents = most->positive_int();
  if (const auto force = node.find("plausible_force")) out.plausible_force = force->positive();
  if (const auto base = node.find("base_wrench")) e.base = read_base_sensor(*base);
  if (const auto most = node.find("max_contacts")) e.max_contacts = most->positive_int();
  if (const auto room = node.find("max_candidates")) e.max_candidates = room->positive_int();
}

}  // namespace

int find_link(const world::Model& model, const YamlNode& node) {
  const std::string name = node.string();
  for (std::size_t b = 0; b < model.bodies().size(); ++b)
    if (model.bodies()[b].name == name && model.bodies()[b].kind == world::BodyKind::Robot) return static_cast<int>(b);
  node.fail_unknown("link", name, link_names(model));
}

Eigen::VectorXd read_posture(const YamlNode& node, const world::Model& model) {
  const Eigen::VectorXd q = node.vector(model.n_a());
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    if (q[j] >= model.lower()[j] && q[j] <= model.upper()[j]) continue;
    const auto& name = model.dofs()[static_cast<std::size_t>(model.n_vu() + j)].name;
    node.fail(fmt::format("{} for '{}'", q[j], name),
              fmt::format("a position within its limits [{}, {}]", model.lower()[j], model.upper()[j]));
  }
  return q;
}

void read_arm(const YamlNode& top, std::span<const std::filesystem::path> package_dirs, ControlScenario& out) {
  if (top.file().has_filename()) out.file = top.file();  // a text in memory has a folder
  out.name = out.file.empty() ? top.string_or("name", "scenario") : top.at("name").string();
  out.description = top.string_or("description", "");
  if (!out.model) {
    out.model = world::Model::make(world::read_scene(top.at("scene"), package_dirs));
    if (out.model->n_a() == 0) top.at("scene").fail("a scene without a robot", "one with a robot");
    out.start = read_posture(top.at("start"), *out.model);
  }
  out.plant.damping_ratio = 0;
  if (const auto plant = top.find("plant")) read_plant(*plant, out);
  if (const auto controller = top.find("controller")) read_controller(*controller, out);
  out.estimator.sense.cone = make_cone(*out.model);
  if (const auto estimator = top.find("estimator")) read_estimator(*estimator, out);
  try {
    out.observer.validate();
    make_estimator_options(out).validate();
    out.controller.validate();
    out.impedance.validate();
    out.plant.validate();
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(out.file.empty() ? e.what() : fmt::format("{}: {}", out.file.string(), e.what()));
  }
}

}  // namespace stiction::tasks
