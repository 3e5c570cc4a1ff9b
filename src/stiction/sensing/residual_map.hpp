#pragma once

#include "stiction/sensing/sensor.hpp"
#include "stiction/sensing/torque_noise.hpp"

namespace stiction::sensing {

/// What torques say of a force on each link, in the order of Sensor::links(): for what is evaluated once, not at a rate.
/// @param whitened  in whose coordinates they are (Y.17), in place of `tau`; nullptr: those of the joints
/// @throws core::InvalidInput: q or tau of the wrong size or not finite
std::vector<LinkTorque> make_link_torques(const Sensor& sensor, VectorRef q, VectorRef tau, const WhitenedTorques* whitened = nullptr);

/// The residual (4.5) at every sample of every link, for pictures: what sense() accepts samples by.
/// @param q  (n_q)  @param tau  (n_a) [N·m; N]
/// @returns one vector a link, in the order of Sensor::links() [(N·m)²]
/// @throws core::InvalidInput: q or tau of the wrong size or not finite
/// Tests: tests/sensing/sense_test.cpp
std::vector<Eigen::VectorXd> calc_residual_map(const Sensor& sensor, VectorRef q, VectorRef tau, const FrictionCone& cone,
                                               const WhitenedTorques* whitened = nullptr);

}  // namespace stiction::sensing
