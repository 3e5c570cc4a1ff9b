#include <fmt/format.h>

#include "stiction/core/invalid_input.hpp"
#include "stiction/planning/planner.hpp"
#include "stiction/planning/thresholds.hpp"

namespace stiction::planning {
namespace {

/// Complementarity of steps by Coulomb's law [J·s]. It also limits how far shifts of the law are followed (docs/theory/cone.md, eq. 18).
constexpr double kCoulombComplementarity = 1e-8;

void require_probability(std::string_view field, double value) {
  if (!(value >= 0 && value <= 1)) core::throw_invalid(field, fmt::format("{}", value), "a probability in [0, 1]");
}

void require_share(std::string_view field, double value) {
  if (!(value > 0 && value <= 1)) core::throw_invalid(field, fmt::format("{}", value), "a number in (0, 1]");
}

void require_box(const world::Model& model, const world::SampleBox& box) {
  if (box.object < 0 || box.object >= static_cast<int>(model.objects().size()))
    core::throw_invalid("planner.sample_box", std::to_string(box.object), "the index of an object");
  const auto& object = model.objects()[static_cast<std::size_t>(box.object)];
  core::require_size("planner.sample_box.lower", box.lower.size(), object.n_v);
  core::require_size("planner.sample_box.upper", box.upper.size(), object.n_v);
  if (!(box.lower.array() <= box.upper.array()).all())
    core::throw_invalid("planner.sample_box", "a lower end above its upper end", "lower ≤ upper");
}

}  // namespace

dynamics::StepOptions PlannerOptions::step_options(const world::Model& model) const {
  using dynamics::FrictionLaw;
  // By Coulomb's law a sliding object stays in contact, as in the world. In a plane, the cone is two half-lines, which cannot be shifted.
  const FrictionLaw law = friction_law.value_or(model.planar_axis() || thesis ? FrictionLaw::Anitescu : FrictionLaw::Coulomb);
  dynamics::StepOptions step{
      .h = threshold::kStep, .friction_law = law, .friction_scale = friction, .effort_limits = true, .contacts_within_reach = true};
  if (thesis) {
    step.h = thesis->h;
    step.regularisation = thesis->regularisation;
  }
  if (law == FrictionLaw::Coulomb) step.tol_complementarity = kCoulombComplementarity;
  return step;
}

void PlannerOptions::validate(const world::Model& model) const {
  if (threads < 0) core::throw_invalid("planner.threads", std::to_string(threads), "0 (all cores) or more");
  if (max_iterations < 1) core::throw_invalid("planner.max_iterations", std::to_string(max_iterations), "at least 1");
  require_probability("planner.goal_bias", goal_bias);
  require_share("planner.tolerance_fraction", tolerance_fraction);
  require_share("planner.friction", friction);
  if (friction_law == dynamics::FrictionLaw::Coulomb && model.planar_axis())
    core::throw_invalid("planner.friction_law", "coulomb", "anitescu for a planar model");
  if (anytime && thesis) core::throw_invalid("planner.anytime", "true, with thesis", "false: trees of the thesis end at their first path");
  for (const auto& box : sample_boxes) require_box(model, box);
  if (thesis) thesis->validate(model);
}

}  // namespace stiction::planning
