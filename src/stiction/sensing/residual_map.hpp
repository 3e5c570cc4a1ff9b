#pragma once

#include "stiction/sensing/sensor.hpp"
#include "stiction/sensing/torque_noise.hpp"

namespace stiction::sensing {

/// Makes the LinkTorque of each link, in the order of Sensor::links(). Uses the heap, so it is for single evaluations, not for control
/// loops.
/// @param whitened  replaces `tau` by whitened torques (Y.17); nullptr: joint torques
/// @throws core::InvalidInput: q or tau of the wrong size or not finite
std::vector<LinkTorque> make_link_torques(const Sensor& sensor, VectorRef q, VectorRef tau, const WhitenedTorques* whitened = nullptr);

/// The residual (4.5) at every sample of every link, by which sense() accepts samples; for pictures.
/// @param q  (n_q)  @param tau  (n_a) [N·m; N]
/// @returns one vector per link, in the order of Sensor::links() [(N·m)²]
/// @throws core::InvalidInput: q or tau of the wrong size or not finite
/// Tests: tests/sensing/sense_test.cpp
std::vector<Eigen::VectorXd> calc_residual_map(const Sensor& sensor, VectorRef q, VectorRef tau, const FrictionCone& cone,
                                               const WhitenedTorques* whitened = nullptr);

}  // namespace stiction::sensing
