#pragma once

#include <span>
#include <vector>

#include "stiction/sensing/cone_evidence.hpp"
#include "stiction/sensing/sensor.hpp"

namespace stiction::sensing {

/// A place on the surface of a link, given by one of the samples of Sensor::links().
struct TouchedPlace {
  int link = -1, sample = -1;
  double probability = 0;
};

/// Where the robot is touched, as probabilities. A priori nothing touches it with probability 1 − p; otherwise one contact acts anywhere on
/// the surface, uniformly by area, with a force as in ConeEvidence. Two contacts at once are not considered.
struct Posterior {
  double nothing = 1;
  std::vector<double> links;         ///< probability of a contact on each sensed link; together with `nothing` they sum to 1
  std::vector<int> credible;         ///< the fewest links with 95 % of the probability of a touch, the likeliest first
  std::vector<TouchedPlace> places;  ///< places with a probability worth keeping, the likeliest first
};

/// ln B (Y.15) of a patch of the surface about a sample. Torques that differ within the patch count as noise: with d the spacing of samples and D = J_wᵀ [·]× (t₁, t₂) f̂
/// the change of torques along the surface, Σ grows by D Dᵀ d²/6, the variance between two points of a cell of side d. This is why few
/// samples suffice.
struct PatchEvidence {
  Eigen::Matrix3d precision;  ///< A/σ²
  Eigen::Vector3d b;
  double constant = 0;  ///< term of ln B that depends on the patch only
  double bound = 0;     ///< largest exponent over the cone, an approximation of log_evidence()
};

/// @param link  has prior 0  @param noise  σ of each torque [N·m]  @param spacing  d [m]; 0: evidence of the point alone
PatchEvidence calc_patch_evidence(const LinkTorque& link, const Eigen::Vector3d& p_L, const Eigen::Matrix3d& R_LC, const ConeEvidence& cone,
                                  double noise, double spacing);

/// Scratch of calc_posterior().
struct PosteriorWorkspace {
  std::vector<TouchedPlace> kept;      ///< places under evaluation
  std::vector<PatchEvidence> patches;  ///< patches of `kept`
  std::vector<double> shares;          ///< number of samples that each place represents
  std::vector<double> evidence, weights;
  std::vector<int> counts, seen;  ///< by link
};

/// Computes the posterior from the samples that may carry weight; all other samples get none. On a link with many such samples the evidence
/// is broad, so a selection of them represents the others.
/// @param places  link and sample of each place, ordered by residual  @param touch_prior  p, in (0, 1)
/// No heap use once work and out have held as many places.
void calc_posterior(const Sensor& sensor, std::span<const LinkTorque> torques, std::span<const TouchedPlace> places,
                    const ConeEvidence& cone, double noise, double touch_prior, PosteriorWorkspace& work, Posterior& out);

/// Computes the posterior from given logarithms of the evidence of every place, relative to no contact. @param shares  number of samples
/// that each place represents
void normalize(const Sensor& sensor, std::span<const TouchedPlace> places, std::span<const double> shares,
               std::span<const double> log_evidence, double touch_prior, PosteriorWorkspace& work, Posterior& out);

}  // namespace stiction::sensing
