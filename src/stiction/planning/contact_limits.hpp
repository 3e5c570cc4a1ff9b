#pragma once

#include <span>

#include "stiction/contact/contact_sampler.hpp"
#include "stiction/dynamics/step.hpp"

namespace stiction::planning {

// Limits on penetrations and on gaps under force, as shares of world::Scales::contact_tolerance of their pair, which the checker allows.

/// Largest penetration that an edge may build up, and that a goal pose may have.
inline constexpr double kMostEdgePenetration = 0.5;
/// Largest penetration of an edge at half its sub-step.
inline constexpr double kMostFinePenetration = 0.95;
/// Limits of a refined plan at half its sub-step, unless the given plan exceeds them. Edges of the tree have the same limit on gaps.
inline constexpr double kMostPenetration = 0.9, kMostForceGap = 0.95;

/// Largest gap across which a force acts after a step, an effect of the relaxation (2.3.4). The gap is the distance of the pair, as the
/// checker measures it. Anitescu's linear gap φ + J_n δq is wrong where a contact slides over an edge of a mesh.
double calc_force_gap(const world::Model& model, const Eigen::VectorXd& q_next, std::span<const dynamics::ContactImpulse> contacts,
                      contact::GeometryWorkspace& work);

/// Deepest penetration at the start of a step, ≥ 0.
double calc_penetration(const world::Model& model, const dynamics::StepResult& step);
/// Deepest penetration at q, ≥ 0.
double calc_penetration(const world::Model& model, const Eigen::VectorXd& q, contact::GeometryWorkspace& work);

}  // namespace stiction::planning
