#pragma once

#include <span>
#include <vector>

#include "stiction/sensing/cone_evidence.hpp"
#include "stiction/sensing/sensor.hpp"

namespace stiction::sensing {

/// A place on the surface of a link, by one of the samples of Sensor::links().
struct TouchedPlace {
  int link = -1, sample = -1;
  double probability = 0;
};

/// Where the robot is touched, as probabilities. Before torques are seen, nothing touches it with probability 1 − p, and else one contact acts anywhere on what can be
/// touched, uniformly by area, with a force as in ConeEvidence. Two contacts at once are not among what is compared.
struct Posterior {
  double nothing = 1;
  std::vector<double> links;         ///< of a contact on each sensed link; with `nothing` they sum to 1
  std::vector<int> credible;         ///< the fewest links that hold 95 % of what is not `nothing`, the likeliest first
  std::vector<TouchedPlace> places;  ///< that carry weight, the likeliest first
};

/// ln B (Y.15) of a patch of the surface about a sample. Torques that differ within the patch count as noise: with d the spacing of samples and D = J_wᵀ [·]× (t₁, t₂) f̂
/// the change of torques along the surface, Σ grows by D Dᵀ d²/6, the variance between two points of a cell of side d. So few samples do.
struct PatchEvidence {
  Eigen::Matrix3d precision;  ///< A/σ²
  Eigen::Vector3d b;
  double constant = 0;  ///< of the patch alone
  double bound = 0;     ///< largest exponent over the cone: what log_evidence() is near to
};

/// @param link  whose prior is 0  @param noise  σ of each of its torques [N·m]  @param spacing  d [m]; 0: of the point alone
PatchEvidence calc_patch_evidence(const LinkTorque& link, const Eigen::Vector3d& p_L, const Eigen::Matrix3d& R_LC, const ConeEvidence& cone,
                                  double noise, double spacing);

/// Scratch of calc_posterior().
struct PosteriorWorkspace {
  std::vector<TouchedPlace> kept;      ///< places that are looked at
  std::vector<PatchEvidence> patches;  ///< of these
  std::vector<double> shares;          ///< samples that each stands for
  std::vector<double> evidence, weights;
  std::vector<int> counts, seen;  ///< by link
};

/// Posterior by the samples that may carry weight; all others have none. Where a link has many of them, evidence is broad, and every so manyth stands for the others.
/// @param places  link and sample of each, by residual  @param touch_prior  p, in (0, 1)
/// No heap use once work and out have met as many places.
void calc_posterior(const Sensor& sensor, std::span<const LinkTorque> torques, std::span<const TouchedPlace> places,
                    const ConeEvidence& cone, double noise, double touch_prior, PosteriorWorkspace& work, Posterior& out);

/// Posterior from the logarithm of the evidence of every place (relative to nothing), whatever made it. @param shares  samples that each place stands for
void normalize(const Sensor& sensor, std::span<const TouchedPlace> places, std::span<const double> shares,
               std::span<const double> log_evidence, double touch_prior, PosteriorWorkspace& work, Posterior& out);

}  // namespace stiction::sensing
