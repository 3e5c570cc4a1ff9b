#include "stiction/tasks/optimize_options.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"

namespace stiction::tasks {
namespace {

using Eigen::VectorXd;
using world::YamlNode;

/// One number for all, or one for each.
VectorXd numbers(const YamlNode& node, int size) {
  return node.is_sequence() ? node.vector(size) : VectorXd(VectorXd::Constant(1, node.number()));
}

VectorXd spread(const VectorXd& values, int size) { return values.size() == size ? values : VectorXd::Constant(size, values[0]); }

void read_object_weights(const YamlNode& node, const world::Model& model, VectorXd& out) {
  std::vector<std::string> known;
  for (const auto& object : model.objects()) known.push_back(object.name);
  for (const auto& [name, value] : node.entries()) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) value.fail_unknown("object", name, known);
    const auto& object = model.objects()[static_cast<std::size_t>(found - known.begin())];
    out.segment(object.v_begin, object.n_v) = spread(numbers(value, object.n_v), object.n_v);
  }
}

trajopt::Weights read_weights(const YamlNode& node, const world::Model& model) {
  node.require_map({"objects", "objects_final", "robots", "robots_final", "input"});
  trajopt::Weights out;
  out.Q.setZero(model.n_v()), out.Qd.setZero(model.n_v());
  read_object_weights(node.at("objects"), model, out.Q);
  read_object_weights(node.at("objects_final"), model, out.Qd);
  if (const auto v = node.find("robots")) out.Q.tail(model.n_a()) = spread(numbers(*v, model.n_a()), model.n_a());
  if (const auto v = node.find("robots_final")) out.Qd.tail(model.n_a()) = spread(numbers(*v, model.n_a()), model.n_a());
  out.R = numbers(node.at("input"), model.n_a());
  return out;
}

trajopt::ForceTrustRegion read_forces(const YamlNode& node) {
  node.require_map({"max_distance", "rays", "friction"});
  trajopt::ForceTrustRegion out;
  out.max_distance = node.positive_or("max_distance", out.max_distance);
  out.friction = node.positive_or("friction", out.friction);
  if (const auto v = node.find("rays")) out.rays = v->positive_int();
  return out;
}

void read_analytic(const YamlNode& node, OptimizeSetup& out) {
  node.require_map({"kappa", "growth", "self_sharpness", "limit_sharpness"});
  out.analytic.kappa = node.positive_or("kappa", out.analytic.kappa);
  out.analytic.self_sharpness = node.positive_or("self_sharpness", out.analytic.self_sharpness);
  out.analytic.limit_sharpness = node.positive_or("limit_sharpness", out.analytic.limit_sharpness);
  out.options.kappa_growth = node.positive_or("growth", out.options.kappa_growth);
}

dynamics::Regularisation read_regularisation(const YamlNode& node) {
  node.require_map({"ratio", "epsilon"});
  const auto ratio = node.find("ratio"), epsilon = node.find("epsilon");
  if (ratio.has_value() == epsilon.has_value()) node.fail("either 'ratio' or 'epsilon'");
  if (ratio) return dynamics::ByRule{ratio->positive()};
  return dynamics::FixedEpsilon{epsilon->positive()};
}

nlohmann::ordered_json list(const VectorXd& values) { return std::vector<double>(values.begin(), values.end()); }

/// A number that is meant for all coordinates is written as one, for a list has one for each.
nlohmann::ordered_json one_or_list(const VectorXd& values) { return values.size() == 1 ? nlohmann::ordered_json(values[0]) : list(values); }

nlohmann::ordered_json to_json(const dynamics::Sampling& s) {
  return {{"std_u", one_or_list(s.std_u)}, {"std_q", one_or_list(s.std_q)}, {"samples", s.samples}};
}

}  // namespace

void read_sampling(const YamlNode& node, const world::Model& model, dynamics::Sampling& out) {
  node.require_map({"std_u", "std_q", "samples"});
  if (const auto v = node.find("std_u")) out.std_u = numbers(*v, model.n_a());
  if (const auto v = node.find("std_q")) out.std_q = numbers(*v, model.n_v());
  if (const auto v = node.find("samples")) out.samples = v->positive_int();
}

std::string sampling_json(const dynamics::Sampling& sampling) { return to_json(sampling).dump(); }

Scheme parse_scheme(std::string_view field, std::string_view name) {
  for (std::size_t i = 0; i < std::size(kSchemeNames); ++i) {
    if (kSchemeNames[i] == name) return static_cast<Scheme>(i);
  }
  core::throw_invalid(field, fmt::format("'{}'", name), "exact, analytic, randomized-first or randomized-zeroth");
}

trajopt::InnerSolver parse_solver(std::string_view field, std::string_view name) {
  if (name == "sweep") return trajopt::SweepSolver{};
  if (name == "receding") return trajopt::RecedingSolver{};
  core::throw_invalid(field, fmt::format("'{}'", name), "sweep or receding");
}

void OptimizeSetup::choose(Scheme chosen) {
  scheme = chosen;
  options.use_A = use_A && !(chosen == Scheme::RandomizedZeroth && randomized_zeroth.std_q.isZero(0));
  switch (chosen) {
    case Scheme::Exact:
      options.scheme = dynamics::Exact{};
      break;
    case Scheme::Analytic:
      options.scheme = analytic;
      break;
    case Scheme::RandomizedFirst:
      options.scheme = randomized_first;
      break;
    case Scheme::RandomizedZeroth:
      options.scheme = randomized_zeroth;
      break;
  }
}

void OptimizeSetup::set_seed(std::uint64_t seed) {
  randomized_first.seed = randomized_zeroth.seed = seed;
  choose(scheme);
}

OptimizeSetup read_optimize_setup(const YamlNode& node, const world::Model& model) {
  node.require_map({"horizon", "iterations", "tolerance", "h", "regularisation", "scheme", "analytic", "randomized_first",
                    "randomized_zeroth", "decay", "seed", "use_A", "solver", "weights", "input_bound", "joints_reference", "forces"});
  OptimizeSetup out;
  out.options.step.effort_limits = true;
  out.horizon = node.at("horizon").positive_int();
  if (const auto v = node.find("iterations")) out.options.iterations = v->positive_int();
  out.options.tolerance = node.nonnegative_or("tolerance", out.options.tolerance);
  out.options.step.h = node.positive_or("h", out.options.step.h);
  if (const auto v = node.find("regularisation")) out.options.step.regularisation = read_regularisation(*v);
  if (const auto v = node.find("analytic")) read_analytic(*v, out);
  if (const auto v = node.find("randomized_first")) read_sampling(*v, model, out.randomized_first);
  if (const auto v = node.find("randomized_zeroth")) read_sampling(*v, model, out.randomized_zeroth);
  out.options.std_decay = node.nonnegative_or("decay", out.options.std_decay);
  if (const auto v = node.find("use_A")) out.use_A = v->boolean();
  if (const auto v = node.find("solver")) out.options.solver = parse_solver("optimize.solver", v->string());
  if (const auto v = node.find("forces"); v && v->kind() != YamlNode::Kind::Null) out.options.forces = read_forces(*v);
  out.options.weights = read_weights(node.at("weights"), model);
  out.options.input_bound = numbers(node.at("input_bound"), model.n_a());
  if (const auto v = node.find("joints_reference")) out.joints_reference = v->vector(model.n_a());
  try {
    out.choose(parse_scheme("scheme", node.string_or("scheme", "analytic")));
    if (const auto v = node.find("seed")) {
      if (v->integer() < 0) v->fail("an integer ≥ 0");
      out.set_seed(static_cast<std::uint64_t>(v->integer()));
    }
    out.options.validate(model);
  } catch (const core::InvalidInput& e) {
    throw core::InvalidInput(fmt::format("{}: {}", node.where(), e.what()));
  }
  return out;
}

std::string optimize_setup_json(const OptimizeSetup& s) {
  const trajopt::OptimizeOptions& o = s.options;
  nlohmann::ordered_json out;
  out["horizon"] = s.horizon;
  out["iterations"] = o.iterations;
  out["tolerance"] = o.tolerance;
  out["h"] = o.step.h;
  std::visit(core::Overloaded{[&](const dynamics::ByRule& r) { out["regularisation"]["ratio"] = r.ratio; },
                              [&](const dynamics::FixedEpsilon& r) { out["regularisation"]["epsilon"] = r.epsilon; }},
             o.step.regularisation);
  out["scheme"] = kSchemeNames[static_cast<std::size_t>(s.scheme)];
  out["analytic"] = {{"kappa", s.analytic.kappa},
                     {"growth", o.kappa_growth},
                     {"self_sharpness", s.analytic.self_sharpness},
                     {"limit_sharpness", s.analytic.limit_sharpness}};
  out["randomized_first"] = to_json(s.randomized_first);
  out["randomized_zeroth"] = to_json(s.randomized_zeroth);
  out["decay"] = o.std_decay;
  out["seed"] = s.randomized_first.seed;
  out["use_A"] = o.use_A;
  out["solver"] = std::holds_alternative<trajopt::SweepSolver>(o.solver) ? "sweep" : "receding";
  out["weights"] = {{"Q", list(o.weights.Q)}, {"Qd", list(o.weights.Qd)}, {"R", list(o.weights.R)}};
  out["input_bound"] = list(o.input_bound);
  if (o.forces) out["forces"] = {{"max_distance", o.forces->max_distance}, {"rays", o.forces->rays}, {"friction", o.forces->friction}};
  if (s.joints_reference.size() > 0) out["joints_reference"] = list(s.joints_reference);
  return out.dump();
}

}  // namespace stiction::tasks
