#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "stiction/sensing/friction_cone.hpp"

namespace stiction::sensing {

/// Evidence of the torques for a contact with an unknown force in a friction cone. The prior of the force is a normal distribution with
/// standard deviation F in every direction, cut to the cone; if several F are given, they are equally likely. The evidence relative to no
/// contact is the mean over F of
///     B = ∫_K exp(bᵀf − ½ fᵀH f) df / ∫_K exp(−½ ‖f‖²/F²) df ,   H = A/σ² + 1/F² ,  b = a/σ²                          (Y.15)
/// with A and a of (Y.2). With H = L Lᵀ, y = Lᵀf and e = L⁻¹b/T, T = ‖L⁻¹b‖, the integrand depends on the direction w of y through t = T e·w alone. Its integral along
/// a ray is R(t) = d/dt S(t), S(t) = 1 + t √(2π) Φ(t) exp(t²/2), so that the integral over the cone of directions is one over its edges (Stokes):
///     |H|^{−1/2} Σ_edges ∫ [S(T) − S(t)]/T dψ ,   ψ the angle about e .                                               (Y.16)
/// If e is far outside the cone, S(T) is left out, because its terms sum to zero; if the cone contains −e, S(−T) replaces S(T).
/// Tests: tests/sensing/posterior_test.cpp (Monte Carlo; one ray; no torque). Source: docs/theory/sensing.md
class ConeEvidence {
 public:
  /// @param cone  polyhedral; an exact cone is replaced by 16 rays with the same cross-section area  @param forces  F, increasing [N], > 0
  ConeEvidence(const FrictionCone& cone, std::vector<double> forces);

  const std::vector<double>& forces() const { return forces_; }
  double friction() const { return friction_; }       ///< μ of the given cone
  bool is_exact() const { return is_exact_; }         ///< whether the given cone was exact
  const FrictionCone& cone() const { return cone_; }  ///< polyhedral

  /// ln B. @param precision  A/σ², symmetric, positive semidefinite, in the contact frame [1/N²]  @param b  [1/N]
  double log_evidence(const Eigen::Matrix3d& precision, const Eigen::Vector3d& b) const;

 private:
  double log_integral(const Eigen::Matrix3d& H, const Eigen::Vector3d& b) const;

  FrictionCone cone_;
  std::vector<double> forces_;
  double friction_;
  bool is_exact_;
  std::vector<double> log_priors_;  ///< logarithms of the denominators of (Y.15)
};

}  // namespace stiction::sensing
