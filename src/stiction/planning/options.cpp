#include "stiction/planning/planner.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"

namespace stiction::planning {
namespace {

using world::Model;

/// Of steps of Coulomb's law [J·s], which also says how far their shifts are followed (docs/theory/cone.md, eq. 18).
constexpr double kCoulombComplementarity = 1e-8;
/// Keeps the samples of local models apart from the draws of the search.
constexpr std::uint64_t kSampleSeed = 0x5ca1ab1e0ddba11;

/// Margins of pushes (docs/decisions/0013-plans-that-hold.md).
constexpr double kStartNoise = 0.2, kEdgeTilt = 0.05, kFrictionNoise = 0.3;

}  // namespace

void PlannerOptions::set_margins(bool on) {
  start_noise = on ? kStartNoise : 0;
  edge_tilt = on ? kEdgeTilt : 0;
  friction_noise = on ? kFrictionNoise : 0;
}

dynamics::LocalModelScheme PlannerOptions::local_model_scheme(std::uint64_t stream, double sharpening) const {
  if (scheme == Scheme::Exact) return dynamics::Exact{};
  if (scheme == Scheme::Analytic) {
    dynamics::Analytic analytic = smoothing;
    analytic.kappa *= sharpening;
    return analytic;
  }
  dynamics::Sampling sampling = randomized;
  sampling.seed = core::Random(seed ^ kSampleSeed, stream).bits();
  sampling.std_u /= sharpening;  // disturbances reach as far as forces at a distance do, 1/κ
  sampling.std_q /= sharpening;
  if (scheme == Scheme::RandomizedFirst) return dynamics::RandomizedFirstOrder{sampling};
  return dynamics::RandomizedZerothOrder{sampling};
}

dynamics::StepOptions PlannerOptions::step_options() const {
  dynamics::StepOptions step{.h = h,
                             .regularisation = regularisation,
                             .friction_law = friction_law,
                             .friction_scale = friction,
                             .effort_limits = true,
                             .contacts_within_reach = true};
  if (friction_law == dynamics::FrictionLaw::Coulomb) step.tol_complementarity = kCoulombComplementarity;
  return step;
}

void PlannerOptions::validate(const Model& model) const {
  const auto probability = [](std::string_view field, double value) {
    if (!(value >= 0 && value <= 1)) core::throw_invalid(field, fmt::format("{}", value), "a probability in [0, 1]");
  };
  if (threads < 0) core::throw_invalid("planner.threads", std::to_string(threads), "0 (all cores) or more");
  if (batch < 1) core::throw_invalid("planner.batch", std::to_string(batch), "at least 1");
  if (trees < 1) core::throw_invalid("planner.trees", std::to_string(trees), "at least 1");
  if (friction_law == dynamics::FrictionLaw::Coulomb && model.planar_axis())
    core::throw_invalid("planner.friction_law", "coulomb", "anitescu for a planar model");
  if (max_iterations < 1) core::throw_invalid("planner.max_iterations", std::to_string(max_iterations), "at least 1");
  probability("planner.goal_bias", goal_bias);
  cost.validate();
  if (anytime && !stop_at_goal) core::throw_invalid("planner.anytime", "true, with stop_at_goal: false", "stop_at_goal: true");
  probability("planner.grasp_probability", grasp_probability);
  core::require_positive("planner.gamma", gamma);
  core::require_positive("planner.h", h);
  core::require_positive("planner.length", std::visit([](const auto& rule) { return rule.length; }, length));
  core::require_positive("planner.smoothing.kappa", smoothing.kappa);
  dynamics::validate(model, local_model_scheme(0), false);
  if (const auto* global = std::get_if<GlobalMetric>(&metric)) {
    core::require_positive("planner.metric.global.position", global->position);
    core::require_positive("planner.metric.global.angle", global->angle);
  }
  if (!(std::isfinite(goal_sharpening) && goal_sharpening >= 1))
    core::throw_invalid("planner.goal_sharpening", fmt::format("{}", goal_sharpening), "a finite number ≥ 1");
  core::require_positive("planner.fidelity_edge", fidelity_edge);
  core::require_positive("planner.fidelity_path", fidelity_path);
  if (substep) substep->validate();
  if (!(regrasp_friction > 0 && regrasp_friction <= 1))
    core::throw_invalid("planner.regrasp_friction", fmt::format("{}", regrasp_friction), "a number in (0, 1]");
  core::require_nonnegative("planner.start_noise", start_noise);
  if (!(edge_tilt >= 0 && edge_tilt < std::numbers::pi / 2))
    core::throw_invalid("planner.edge_tilt", fmt::format("{}", edge_tilt), "an angle in [0, π/2) [rad]");
  if (!(friction_noise >= 0 && friction_noise < 1))
    core::throw_invalid("planner.friction_noise", fmt::format("{}", friction_noise), "a share in [0, 1)");
  if (!(friction > 0 && friction <= 1)) core::throw_invalid("planner.friction", fmt::format("{}", friction), "a number in (0, 1]");
  core::require_nonnegative("planner.grip_force", grip_force);
  if (!(brace_force > 0)) core::throw_invalid("planner.brace_force", fmt::format("{:g}", brace_force), "a number > 0");
  core::require_positive("planner.regrasp_clearance", regrasp_clearance);
  core::require_positive("planner.regrasp_tol_position", regrasp_tol_position);
  core::require_positive("planner.regrasp_tol_angle", regrasp_tol_angle);
  core::require_positive("planner.release_tol_position", release_tol_position);
  core::require_positive("planner.release_tol_angle", release_tol_angle);
  probability("planner.sampler.whole_probability", sampler.whole_probability);
  probability("planner.sampler.near_probability", sampler.near_probability);
  core::require_positive("planner.sampler.near_std", sampler.near_std);
  if (sampler.tries < 1) core::throw_invalid("planner.sampler.tries", std::to_string(sampler.tries), "at least 1");
  if (grasp_trials < 0) core::throw_invalid("planner.grasp_trials", std::to_string(grasp_trials), "0 or more");
  if (grasp_candidates < 1) core::throw_invalid("planner.grasp_candidates", std::to_string(grasp_candidates), "at least 1");
  if (!(tolerance_fraction > 0 && tolerance_fraction <= 1))
    core::throw_invalid("planner.tolerance_fraction", fmt::format("{}", tolerance_fraction), "a number in (0, 1]");
  if (refined_fraction && !(*refined_fraction >= tolerance_fraction && *refined_fraction <= 1))
    core::throw_invalid("planner.refined_fraction", fmt::format("{}", *refined_fraction),
                        fmt::format("a number in [{}, 1]: tolerance_fraction or more", tolerance_fraction));
  for (const auto& box : sample_boxes) {
    if (box.object < 0 || box.object >= static_cast<int>(model.objects().size()))
      core::throw_invalid("planner.sample_box", std::to_string(box.object), "the index of an object");
    const auto& object = model.objects()[static_cast<std::size_t>(box.object)];
    core::require_size("planner.sample_box.lower", box.lower.size(), object.n_v);
    core::require_size("planner.sample_box.upper", box.upper.size(), object.n_v);
    if (!(box.lower.array() <= box.upper.array()).all())
      core::throw_invalid("planner.sample_box", "a lower end above its upper end", "lower ≤ upper");
  }
}

}  // namespace stiction::planning
