#include "stiction/tasks/sensing_scenario_file.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <variant>

#include "stiction/core/invalid_input.hpp"
#include "stiction/simulation/impedance.hpp"
#include "stiction/tasks/kind_of_file.hpp"
#include "stiction/world/cache_file.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::tasks {
namespace {

using sensing::BaseWrench;
using sensing::ContactPoint;
using sensing::FrictionCone;
using sensing::Poke;
using sensing::Scenario;
using sensing::SenseOptions;
using sensing::Sensor;
using sensing::SensorOptions;
using world::Model;
using world::YamlNode;

template <class T>
void read_into(const YamlNode& node, std::string_view key, T& out) {
  if (const auto value = node.find(key)) {
    if constexpr (std::is_same_v<T, int>) {
      out = value->positive_int();
    } else {
      out = value->positive();
    }
  }
}

/// Reads one number per joint: a list in the order of u, or a map by name, in which missing joints have the value `rest`.
Eigen::VectorXd read_joints(const YamlNode& node, const Model& model, const Eigen::VectorXd& rest) {
  if (node.is_sequence()) return node.vector(model.n_a());
  Eigen::VectorXd out = rest;
  node.require_map();
  for (const auto& [name, value] : node.entries()) {
    int joint = 0;
    try {
      joint = model.joint_index(name);
    } catch (const core::InvalidInput& e) {
      throw core::InvalidInput(fmt::format("{}: {}", value.where(), e.what()));
    }
    out[joint] = value.number();
  }
  return out;
}

sensing::Sampling read_sampling(const YamlNode& node) {
  const std::string name = node.one_of({"stratified", "uniform", "blue_noise"});
  if (name == "uniform") return sensing::Sampling::Uniform;
  return name == "blue_noise" ? sensing::Sampling::BlueNoise : sensing::Sampling::Stratified;
}

sensing::Method read_method(const YamlNode& node) {
  const std::string name = node.one_of({"gauss_newton", "rsgd", "rejection"});
  if (name == "rejection") return sensing::RejectionSampling{};
  if (name == "rsgd") return sensing::SteepestDescent{};
  return sensing::GaussNewton{};
}

void read_sensing(const YamlNode& node, SensorOptions& sensor, SenseOptions& options, int& max_contacts) {
  node.require_map({"links",  "samples",    "sampling",      "normals",         "seed",           "friction",
                    "rays",   "noise",      "threshold",     "accept",          "accept_share",   "tolerance",
                    "method", "merge",      "max_contacts",  "plausible_force", "friction_error", "rest",
                    "sign",   "unmeasured", "probabilities", "touch_prior"});
  if (const auto links = node.find("links"))
    for (const auto& link : links->items()) sensor.links.push_back(link.string());
  read_into(node, "samples", sensor.samples);
  if (const auto kind = node.find("sampling")) sensor.sampling = read_sampling(*kind);
  if (const auto kind = node.find("normals"))
    sensor.normals = kind->one_of({"flat", "smooth"}) == "smooth" ? sensing::Normals::Smooth : sensing::Normals::Flat;
  const std::int64_t seed = node.integer_or("seed", 0);
  if (seed < 0) node.at("seed").fail("an integer ≥ 0");
  sensor.seed = static_cast<std::uint64_t>(seed);
  const int rays = static_cast<int>(node.integer_or("rays", 4));
  const double friction = node.nonnegative_or("friction", 1);
  try {
    options.cone = FrictionCone(friction, rays);
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", node.where(), e.what()));
  }
  if (const auto noise = node.find("noise"); noise && noise->is_number()) options.noise = noise->positive();
  options.posterior = node.boolean_or("probabilities", true);
  if (const auto value = node.find("touch_prior")) {
    options.touch_prior = value->number();
    if (!(options.touch_prior > 0 && options.touch_prior < 1)) value->fail(value->describe(), "a number in (0, 1)");
  }
  if (const auto value = node.find("sign")) {
    options.torques.sign = static_cast<double>(value->integer());
    if (std::abs(options.torques.sign) != 1) value->fail(value->describe(), "1, or -1 of what the robot does to its surroundings");
  }
  if (const auto value = node.find("threshold")) options.threshold = value->positive();
  if (const auto value = node.find("accept")) options.accept = value->positive();
  read_into(node, "accept_share", options.accept_share);
  read_into(node, "tolerance", options.tolerance);
  read_into(node, "merge", options.merge);
  if (const auto value = node.find("plausible_force")) options.plausible_force = value->positive();
  if (const auto value = node.find("friction_error")) {
    options.friction_error = value->nonnegative();
    if (options.friction_error >= 1) value->fail(value->describe(), "a number in [0, 1)");
  }
  if (const auto value = node.find("method")) options.method = read_method(*value);
  if (const auto value = node.find("max_contacts")) {
    max_contacts = value->positive_int();
    if (max_contacts > sensing::kMostContacts) value->fail(fmt::format("an integer from 1 to {}", sensing::kMostContacts));
  }
}

/// The joints of sensing.unmeasured.
void read_unmeasured(const YamlNode& node, const Model& model, SenseOptions& options) {
  const auto joints = node.find("unmeasured");
  if (!joints) return;
  for (const auto& joint : joints->items()) {
    try {
      options.torques.unmeasured.push_back(model.joint_index(joint.string()));
    } catch (const core::InvalidInput& e) {
      throw core::InvalidInput(fmt::format("{}: {}", joint.where(), e.what()));
    }
  }
}

/// Moments of a series from which rest is taken: {rows: [first, last]}, {seconds: [from, to]}, both ends among them.
std::vector<Eigen::Index> read_rest_rows(const YamlNode& node, const sensing::Series& series) {
  node.require_map({"rows", "seconds"});
  const auto rows = node.find("rows"), seconds = node.find("seconds");
  if (rows.has_value() == seconds.has_value())
    node.fail(rows ? "both 'rows' and 'seconds'" : "neither 'rows' nor 'seconds'", "one of the two");
  const YamlNode& span = rows ? *rows : *seconds;
  const Eigen::VectorXd ends = span.vector(2);
  std::vector<Eigen::Index> out;
  for (Eigen::Index i = 0; i < series.tau.cols(); ++i) {
    const double at = rows ? static_cast<double>(i) : series.times[static_cast<std::size_t>(i)];
    if (at >= ends[0] && at <= ends[1]) out.push_back(i);
  }
  if (out.empty() && series.times.empty()) span.fail("no recorded series", "a scenario with 'series'");
  if (out.empty())
    span.fail(fmt::format("[{}, {}], which no moment is in", ends[0], ends[1]),
              rows ? fmt::format("rows from 0 to {}", series.tau.cols() - 1)
                   : fmt::format("seconds between {} and {}", series.times.front(), series.times.back()));
  return out;
}

/// Standard deviations of joints, by number or by name, or the rows of a covariance.
void read_noise(const YamlNode& node, const Model& model, SenseOptions& options) {
  std::variant<Eigen::VectorXd, Eigen::MatrixXd> noise;
  if (node.is_sequence() && !node.items().empty() && node.items()[0].is_sequence()) {
    const auto rows = node.items(static_cast<std::size_t>(model.n_a()));
    auto& covariance = noise.emplace<Eigen::MatrixXd>(model.n_a(), model.n_a());
    for (Eigen::Index i = 0; i < covariance.rows(); ++i)
      covariance.row(i) = rows[static_cast<std::size_t>(i)].vector(model.n_a()).transpose();
  } else {
    noise = read_joints(node, model, Eigen::VectorXd::Constant(model.n_a(), options.noise));
  }
  try {
    options.torques.covariance = std::visit([&](const auto& x) { return sensing::make_covariance(x, model.n_a(), options.noise); }, noise);
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", node.where(), e.what()));
  }
}

/// Rest and sign are those of a torque sensor.
void refuse_sensor_of_computed(const YamlNode& node, const Scenario& scenario) {
  if (!scenario.is_computed()) return;
  for (const char* key : {"rest", "sign"})
    if (const auto value = node.find(key); value && !(value->is_number() && value->number() == 1))
      value->fail(fmt::format("'{}' of torques that are computed from contacts", key), "measured torques, from 'torques' or 'series'");
}

/// Rest and noise, from numbers or from rows of the series.
void read_torque_model(const YamlNode& node, Scenario& out) {
  const Model& model = out.sensor->model();
  const auto rest = node.find("rest"), noise = node.find("noise");
  const bool from_rest = noise && noise->is_scalar() && !noise->is_number();
  if (from_rest) (void)noise->one_of({"rest"});
  if (noise && !noise->is_scalar()) read_noise(*noise, model, out.options);
  const bool has_rows = rest && rest->is_map() && (rest->has("rows") || rest->has("seconds"));
  if (from_rest && !has_rows) noise->fail("'rest' without rows of rest", "sensing.rest with 'rows' or 'seconds', or a number");
  if (rest && !has_rows) out.options.torques.rest = read_joints(*rest, model, Eigen::VectorXd::Zero(model.n_a()));
  if (has_rows) {
    try {
      sensing::set_rest(out, read_rest_rows(*rest, out.series), from_rest);
    } catch (const core::InvalidInput& e) {
      throw core::InvalidInput(std::string(e.what()).find(rest->where()) == 0 ? e.what() : fmt::format("{}: {}", rest->where(), e.what()));
    }
  }
  try {
    out.options.torques.validate(model.n_a());
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", node.where(), e.what()));
  }
}

/// A contact by its link, a point in its frame, moved to the nearest of its surface, and a force on the robot: a vector in W, or how hard
/// the surface is pushed along its normal.
ContactPoint read_contact(const YamlNode& node, const Sensor& sensor, const FrictionCone& cone, const Eigen::VectorXd& q) {
  ContactPoint out;
  const YamlNode link = node.at("link");
  try {
    out.link = sensor.link_index(link.string());
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", link.where(), e.what()));
  }
  const sensing::Surface& surface = sensor.links()[static_cast<std::size_t>(out.link)].surface;
  const sensing::TriangleTree::Closest closest = surface.tree.closest(node.at("point").vector3());
  out.p_L = closest.point;
  const Eigen::Vector3d n_L = surface.normal(closest.triangle, closest.point, sensor.options().normals);
  const YamlNode force = node.at("force");
  if (force.is_scalar()) {
    out.f_L = -force.positive() * n_L;
    return out;
  }
  world::KinematicsWorkspace work(sensor.model());
  world::Kinematics kinematics;
  world::calc_kinematics(sensor.model(), q, work, kinematics);
  const Eigen::Matrix3d& R_WL = kinematics.X_WB[static_cast<std::size_t>(surface.body)].R;
  out.f_L = R_WL.transpose() * force.vector3();
  constexpr double kRounding = 1e-9;
  if (!cone.contains(sensing::make_contact_frame(n_L).transpose() * out.f_L, kRounding)) {
    const Eigen::Vector3d n_W = R_WL * n_L;
    force.fail(fmt::format("{}, outside the friction cone about the inward normal ({:.3f}, {:.3f}, {:.3f})", force.describe(), -n_W.x(),
                           -n_W.y(), -n_W.z()),
               "a force inside it");
  }
  return out;
}

/// A wrench at the base: its noise, and where the torques are measured its force and moment.
BaseWrench read_base(const YamlNode& node, bool is_measured) {
  if (is_measured)
    node.require_map({"force", "moment", "force_noise", "moment_noise"});
  else
    node.require_map({"force_noise", "moment_noise"});
  BaseWrench out;
  if (is_measured) {
    out.force_W = node.at("force").vector3();
    out.moment_W = node.at("moment").vector3();
  }
  read_into(node, "force_noise", out.force_noise);
  read_into(node, "moment_noise", out.moment_noise);
  return out;
}

std::vector<ContactPoint> read_contacts(const YamlNode& top, const Sensor& sensor, const FrictionCone& cone, const Eigen::VectorXd& q) {
  std::vector<ContactPoint> out;
  const auto read = [&](const YamlNode& node) {
    node.require_map({"link", "point", "force"});
    out.push_back(read_contact(node, sensor, cone, q));
  };
  if (const auto contact = top.find("contact")) {
    read(*contact);
    return out;
  }
  const YamlNode contacts = top.at("contacts");
  for (const auto& contact : contacts.items()) read(contact);
  if (out.empty()) contacts.fail("at least one contact");
  return out;
}

void read_pushes(const YamlNode& poke, Scenario& out) {
  const Model& model = out.sensor->model();
  const Eigen::VectorXd q = sensing::place_robots(model, out.poke->start);
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  for (const auto& push : poke.at("pushes").items()) {
    push.require_map({"link", "point", "force", "begin", "duration"});
    out.contacts.push_back(read_contact(push, *out.sensor, out.options.cone, q));
    const double begin = push.at("begin").nonnegative(), duration = push.at("duration").positive();
    const auto acting = 1 + std::count_if(out.poke->pushes.begin(), out.poke->pushes.end(), [&](const Poke::Push& other) {
                          return begin < other.begin + other.duration && other.begin < begin + duration;
                        });
    if (acting > out.max_contacts)
      push.at("begin").fail(fmt::format("{} s, when {} pushes act", begin, acting),
                            fmt::format("at most sensing.max_contacts at the same time, {}", out.max_contacts));
    const int body = out.sensor->links()[static_cast<std::size_t>(out.contacts.back().link)].surface.body;
    const Eigen::Vector3d force_W = kinematics.X_WB[static_cast<std::size_t>(body)].R * out.contacts.back().f_L;
    out.poke->pushes.push_back({static_cast<int>(out.contacts.size()) - 1, begin, duration, force_W});
  }
}

/// Reads a simulated robot that is pushed.
void read_poke(const YamlNode& top, const YamlNode& node, Scenario& out) {
  for (const char* key : {"torques", "contact", "contacts", "series"})
    if (top.has(key)) top.at(key).fail(fmt::format("'{}' beside 'poke'", key), "one of the two");
  node.require_map({"end", "duration", "period", "pushes", "observer"});
  const Model& model = out.sensor->model();
  const Eigen::VectorXd rest = model.neutral().tail(model.n_a());
  Poke& poke = out.poke.emplace();
  poke.start = poke.end = read_joints(top.at("joints"), model, rest);
  if (const auto end = node.find("end")) poke.end = read_joints(*end, model, poke.start);
  poke.duration = node.at("duration").positive();
  read_into(node, "period", poke.period);
  constexpr double kMostMoments = 1e6;  // each is sensed
  const double least = simulation::ImpedanceOptions{}.period;
  if (poke.period < least) node.at("period").fail(fmt::format("at least {} s", least));
  if (poke.duration > kMostMoments * poke.period)
    node.at("duration").fail(fmt::format("at most {:g} times the period, {} s", kMostMoments, poke.period));
  read_pushes(node, out);
  if (const auto base = top.find("base_wrench")) out.base = read_base(*base, false);
  const auto observer = node.find("observer");
  if (!observer) return;
  observer->require_map({"time_constant", "noise", "bias", "bias_reach", "inertia_error", "seed"});
  read_into(*observer, "time_constant", poke.time_constant);
  poke.noise = observer->nonnegative_or("noise", poke.noise);
  poke.bias = observer->nonnegative_or("bias", poke.bias);
  poke.bias_reach = observer->nonnegative_or("bias_reach", poke.bias_reach);
  if (const auto error = observer->find("inertia_error")) poke.inertia_error = error->number();
  const std::int64_t seed = observer->integer_or("seed", 0);
  if (seed < 0) observer->at("seed").fail("an integer ≥ 0");
  poke.seed = static_cast<std::uint64_t>(seed);
}

void read_series(const YamlNode& top, const YamlNode& series, Scenario& out) {
  for (const char* key : {"joints", "torques", "contact", "contacts", "base_wrench"})
    if (top.has(key)) top.at(key).fail(fmt::format("'{}' beside 'series'", key), "one of the two");
  out.series = sensing::load_series(top.file().parent_path() / series.string(), out.sensor->model(), out.options.torques.unmeasured);
}

void read_measurement(const YamlNode& top, Scenario& out) {
  if (const auto poke = top.find("poke")) return read_poke(top, *poke, out);
  if (const auto series = top.find("series")) return read_series(top, *series, out);
  const Model& model = out.sensor->model();
  const Eigen::VectorXd rest = model.neutral().tail(model.n_a()), zero = Eigen::VectorXd::Zero(model.n_a());
  const Eigen::VectorXd joints = read_joints(top.at("joints"), model, rest);
  const auto torques = top.find("torques"), base = top.find("base_wrench");
  if (top.has("contact") && top.has("contacts")) top.at("contacts").fail("'contacts' beside 'contact'", "one of the two");
  const bool is_known = top.has("contact") || top.has("contacts");
  if (torques.has_value() == is_known)
    top.fail(is_known ? "both 'torques' and 'contact'" : "neither 'torques' nor 'contact'", "one of the two");
  if (base) out.base = read_base(*base, torques.has_value());
  Eigen::VectorXd tau;
  if (torques) {
    tau = read_joints(*torques, model, zero);
  } else {
    const Eigen::VectorXd q = sensing::place_robots(model, joints);
    out.contacts = read_contacts(top, *out.sensor, out.options.cone, q);
    BaseWrench computed;
    sensing::calc_known_rows(*out.sensor, q, out.contacts, tau, out.base ? *out.base : computed);
  }
  out.series = {{0.0}, joints, tau};
}

/// @param field  prefix of an option's field in messages
Scenario read_scenario(const YamlNode& top, const std::string& field, const std::string& name,
                       std::span<const std::filesystem::path> package_dirs) {
  refuse_other_kind(top, FileKind::Sensing);
  top.require_map({"name", "description", "scene", "sensing", "joints", "torques", "contact", "contacts", "base_wrench", "series", "poke"});
  Scenario out;
  out.name = top.string_or("name", name);
  out.description = top.string_or("description", "");
  out.file = top.file();
  SensorOptions sensor_options;
  sensor_options.surface.cache_dir = world::default_cache_dir();
  const auto options = top.find("sensing");
  if (options) read_sensing(*options, sensor_options, out.options, out.max_contacts);
  const auto model = Model::make(world::read_scene(top.at("scene"), package_dirs));
  try {
    out.sensor = Sensor::make(model, sensor_options);
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(field + e.what());
  }
  if (options) read_unmeasured(*options, *model, out.options);
  read_measurement(top, out);
  if (options) refuse_sensor_of_computed(*options, out);
  if (options) read_torque_model(*options, out);
  return out;
}

}  // namespace

sensing::Scenario load_sensing_scenario(const std::filesystem::path& file, std::span<const std::filesystem::path> package_dirs) {
  Scenario out = read_scenario(world::load_yaml_with_base(file), file.string() + ": sensing.", file.stem().string(), package_dirs);
  out.file = file;
  return out;
}

sensing::Scenario parse_sensing_scenario(const std::string& text, const std::filesystem::path& folder,
                                         std::span<const std::filesystem::path> package_dirs) {
  return read_scenario(world::parse_yaml_with_base(text, folder), "sensing.", "scenario", package_dirs);
}

}  // namespace stiction::tasks
