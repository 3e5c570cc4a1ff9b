#pragma once

#include <span>

#include "stiction/contact/contact_sampler.hpp"
#include "stiction/dynamics/step.hpp"

namespace stiction::planning {

// Penetrations, and gaps across which a force acts, as shares of world::Scales::contact_tolerance of their pair, all of which the checker allows.

/// Largest penetration that an edge may build up, and that a goal may have.
inline constexpr double kMostEdgePenetration = 0.5;
/// Of an edge at half its sub-step.
inline constexpr double kMostFinePenetration = 0.95;
/// Of a refined plan at half its sub-step, unless the given one has more. An edge of the tree has the same gap.
inline constexpr double kMostPenetration = 0.9, kMostForceGap = 0.95;

/// Largest gap across which a force acts after a step, which is the relaxation's (2.3.4) and not the world's: the distance of the pair itself, as the
/// checker measures it. Anitescu's linear gap φ + J_n δq says nothing of it where a contact slides over an edge of a mesh.
double calc_force_gap(const world::Model& model, const Eigen::VectorXd& q_next, std::span<const dynamics::ContactImpulse> contacts,
                      contact::GeometryWorkspace& work);

/// Deepest penetration at the start of a step, ≥ 0.
double calc_penetration(const world::Model& model, const dynamics::StepResult& step);
/// The same at q itself.
double calc_penetration(const world::Model& model, const Eigen::VectorXd& q, contact::GeometryWorkspace& work);

}  // namespace stiction::planning
