#include <cmath>
#include <string>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/trajopt/optimize.hpp"

namespace stiction::trajopt {
namespace {

void validate_sampling(const world::Model& model, const dynamics::Sampling& s, const char* scheme) {
  const std::string field = std::string("scheme.") + scheme;
  if (s.samples < 1) core::throw_invalid(field + ".samples", std::to_string(s.samples), "at least 1");
  if (s.std_u.size() != 1) core::require_size(field + ".std_u", s.std_u.size(), model.n_a());
  if (s.std_q.size() != 1) core::require_size(field + ".std_q", s.std_q.size(), model.n_v());
  for (const double x : s.std_u) core::require_nonnegative(field + ".std_u", x);
  for (const double x : s.std_q) core::require_nonnegative(field + ".std_q", x);
  if (s.std_u.maxCoeff() == 0 && s.std_q.maxCoeff() == 0) core::throw_invalid(field + ".std_u", "0, and std_q too", "a disturbance");
}

void validate_zeroth(const world::Model& model, const dynamics::Sampling& s, bool use_A) {
  validate_sampling(model, s, "randomized_zeroth");
  if (use_A && !(s.std_q.minCoeff() > 0)) {
    core::throw_invalid("scheme.randomized_zeroth.std_q", "0", "greater than 0 for A by least squares, or use_A = false");
  }
}

void validate_forces(const OptimizeOptions& o) {
  core::require_positive("forces.max_distance", o.forces->max_distance);
  core::require_positive("forces.friction", o.forces->friction);
  if (o.forces->rays < 4 || o.forces->rays > 64)
    core::throw_invalid("forces.rays", std::to_string(o.forces->rays), "an integer in [4, 64]");
  if (!std::holds_alternative<dynamics::Analytic>(o.scheme)) core::throw_invalid("forces", "another scheme", "the analytic scheme");
  if (!std::holds_alternative<SweepSolver>(o.solver)) core::throw_invalid("forces", "the receding solver", "the sweep solver");
  if (!o.use_A) core::throw_invalid("forces", "use_A = false", "use_A = true");
}

}  // namespace

void OptimizeOptions::validate(const world::Model& model) const {
  step.validate();
  std::visit(core::Overloaded{[](const dynamics::Exact&) {},
                              [](const dynamics::Analytic& s) {
                                core::require_positive("scheme.analytic.kappa", s.kappa);
                                core::require_positive("scheme.analytic.self_sharpness", s.self_sharpness);
                                core::require_positive("scheme.analytic.limit_sharpness", s.limit_sharpness);
                              },
                              [&](const dynamics::RandomizedFirstOrder& s) { validate_sampling(model, s, "randomized_first"); },
                              [&](const dynamics::RandomizedZerothOrder& s) { validate_zeroth(model, s, use_A); }},
             scheme);
  core::require_positive("kappa_growth", kappa_growth);
  core::require_nonnegative("std_decay", std_decay);
  weights.validate(model);
  if (input_bound.size() != 1) core::require_size("input_bound", input_bound.size(), model.n_a());
  for (const double x : input_bound) core::require_positive("input_bound", x);
  if (iterations < 1) core::throw_invalid("iterations", std::to_string(iterations), "at least 1");
  core::require_nonnegative("tolerance", tolerance);
  core::require_positive("qp_tolerance", qp_tolerance);
  if (const auto* sweep = std::get_if<SweepSolver>(&solver); sweep != nullptr && sweep->max_halvings < 0) {
    core::throw_invalid("solver.max_halvings", std::to_string(sweep->max_halvings), "at least 0");
  }
  if (forces) validate_forces(*this);
  if (threads < 0) core::throw_invalid("threads", std::to_string(threads), "at least 0");
}

}  // namespace stiction::trajopt
