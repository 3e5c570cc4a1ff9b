#pragma once

#include "stiction/dynamics/rollout.hpp"
#include "stiction/planning/contact_sampler.hpp"

namespace stiction::planning {

// Penetrations, and gaps across which a force acts, as shares of world::Scales::contact_tolerance of their pair, all of which the checker allows.

/// Largest penetration that an edge may build up, and that a goal may have.
inline constexpr double kMostEdgePenetration = 0.5;
/// Of an edge at half its sub-step.
inline constexpr double kMostFinePenetration = 0.95;
/// Of a refined plan at half its sub-step, unless the given one has more. An edge of the tree has the same gap.
inline constexpr double kMostPenetration = 0.9, kMostForceGap = 0.95;

/// Largest gap across which a force acts after a step, which is the relaxation's (2.3.4) and not the world's: the distance of the pair itself, as the
/// checker measures it. Over steps that turn things that is more than Anitescu's linear gap φ + J_n δq, by a fifth of the tolerance at most; gaps below 0.4 of
/// it are taken from that, unless an object moved by more than 0.2 L or 0.02 rad or a contact slid by more than 3 tolerances.
double calc_force_gap(const world::Model& model, const dynamics::StepResult& step, GeometryWorkspace& work);
double calc_force_gap(const world::Model& model, const dynamics::Knot& knot, GeometryWorkspace& work);  ///< … but for how the object moved

/// Deepest penetration at the start of a step, ≥ 0.
double calc_penetration(const world::Model& model, const dynamics::StepResult& step);
/// The same at q itself.
double calc_penetration(const world::Model& model, const Eigen::VectorXd& q, GeometryWorkspace& work);

}  // namespace stiction::planning
