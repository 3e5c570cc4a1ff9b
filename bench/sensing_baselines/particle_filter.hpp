#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "stiction/sensing/descent.hpp"

namespace stiction::bench {

using sensing::ContactPoint;
using sensing::FrictionCone;
using sensing::LinkTorque;
using sensing::Sensor;
using sensing::VectorRef;

/// Settings of the research code; lengths are shares of the size of a link, as 1 mm and 1 cm are of a link of the iiwa.
struct ParticleFilterOptions {
  FrictionCone cone{1, 4};
  double noise = 0.1;   ///< σ of each torque [N·m], > 0
  int particles = 50;   ///< ≥ 1
  double walk = 0.004;  ///< standard deviation of each coordinate of a step, of the size of the link [-], > 0
  double give_up = 5;   ///< where no particle has l < give_up σ², all are drawn anew; > 0
  double agree = 0.04;  ///< mean of the deviations of coordinates below which the particles agree, of the size of the link [-], > 0
  int steady = 5;       ///< measurements after which they may be asked, ≥ 1
  std::uint64_t seed = 0;
  void validate() const;  ///< @throws core::InvalidInput naming the field
};

/// What the particles say.
struct ParticleEstimate {
  bool agrees = false;   ///< most particles are on one link, near each other
  ContactPoint point;    ///< nearest of the surface to their mean, on the link that has most of them
  int share = 0;         ///< particles on that link
  double deviation = 0;  ///< mean of the standard deviations of their coordinates [m]
  int resets = 0;        ///< since the start
};

/// Baseline: the contact particle filter (Manuelli and Tedrake, IROS 2016) of one contact, as sections 4.2 and 4.4.3 of the thesis describe it. Particles are points
/// of the surface, uniform by area at first. With every measurement each takes a step x + N(0, s²), back to the nearest point of its link, has the weight
///     w = exp(−l(x)/σ²) ,                                                                                                     (Y.13)
/// and as many are drawn anew by their weights: only that moves particles from link to link. Belongs to one thread.
/// Tests: tests/sensing/baselines_test.cpp
class ParticleFilter {
 public:
  /// @throws core::InvalidInput: options
  ParticleFilter(std::shared_ptr<const Sensor> sensor, const ParticleFilterOptions& options);

  /// One measurement. @param q  (n_q)  @param tau  (n_a) [N·m; N]  @throws core::InvalidInput: sizes, numbers that are not finite
  const ParticleEstimate& update(VectorRef q, VectorRef tau);

  /// Draws all particles anew.
  void reset();
  const std::vector<ContactPoint>& particles() const { return particles_; }

 private:
  void walk(const std::vector<LinkTorque>& torques);
  bool resample();
  void summarize(const std::vector<LinkTorque>& torques);

  std::shared_ptr<const Sensor> sensor_;
  ParticleFilterOptions options_;
  core::Random random_;
  std::vector<double> areas_below_;  ///< of links
  std::vector<ContactPoint> particles_, drawn_;
  std::vector<double> weights_below_;
  int measurements_ = 0;
  ParticleEstimate estimate_;
};

/// A point uniform by area over several links. @param areas_below  area of links 0 … i [m²]
ContactPoint draw_surface_point(const Sensor& sensor, const std::vector<double>& areas_below, core::Random& random);

}  // namespace stiction::bench
