#pragma once

#include <cstdint>
#include <vector>

#include "stiction/sensing/descent.hpp"

namespace stiction::bench {

using sensing::ContactPoint;
using sensing::FrictionCone;
using sensing::Sensor;
using sensing::VectorRef;

struct MetropolisOptions {
  FrictionCone cone{1, 4};
  double noise = 0.1;      ///< σ of each torque [N·m], > 0
  int chains = 10;         ///< ≥ 1
  int steps = 500;         ///< of each chain, ≥ 1
  double walk = 0.02;      ///< standard deviation of a step along the surface, of the size of the link [-], > 0
  std::uint64_t seed = 0;  ///< chain i uses its own numbers
  void validate() const;   ///< @throws core::InvalidInput naming the field
};

/// Baseline: random walks on the surface (Metropolis) with the likelihood exp(−l/2σ²) of a point, from points uniform by area over all links; a proposal is a step in the tangent
/// plane, back to the nearest point of the link. A walk does not leave its link, and seldom a minimum of l: the weakness that section 4.5 of the thesis names.
/// @returns of every chain the best point, by residual     @param q  (n_q)  @param tau  (n_a) [N·m; N]
/// @throws core::InvalidInput: options, sizes, numbers that are not finite
/// Tests: tests/sensing/baselines_test.cpp
std::vector<ContactPoint> walk_metropolis(const Sensor& sensor, VectorRef q, VectorRef tau, const MetropolisOptions& options);

}  // namespace stiction::bench
