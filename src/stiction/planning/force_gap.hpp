#pragma once

#include "stiction/dynamics/rollout.hpp"
#include "stiction/planning/contact_sampler.hpp"

namespace stiction::planning {

/// Largest penetration that an edge may build up, and that a goal may have [m].
inline constexpr double kMostEdgePenetration = 5e-4;
/// Penetration and distance across which a force acts that a refined plan may have at half its sub-step, unless the given one has more [m]; the checker
/// allows 1 mm. An edge of the tree has the same distance.
inline constexpr double kMostPenetration = 0.9e-3, kMostForceGap = 0.95e-3;

/// Largest distance across which a force acts after a step [m], which is the relaxation's (2.3.4) and not the world's: the distance of the pair itself,
/// as the checker measures it. Over steps that turn things it is up to 0.2 mm more than Anitescu's linear gap φ + J_n δq; gaps below 0.4 mm are taken
/// from that, unless an object moved by more than 20 mm or 0.02 rad or a contact slid by more than 3 mm.
double calc_force_gap(const world::Model& model, const dynamics::StepResult& step, GeometryWorkspace& work);
double calc_force_gap(const world::Model& model, const dynamics::Knot& knot, GeometryWorkspace& work);  ///< … but for how the object moved

/// Deepest penetration at the start of a step [m], ≥ 0.
double calc_penetration(const dynamics::StepResult& step);
/// The same at q itself.
double calc_penetration(const world::Model& model, const Eigen::VectorXd& q, GeometryWorkspace& work);

}  // namespace stiction::planning
