#pragma once

#include <Eigen/Core>
#include <vector>

namespace stiction::sensing {

/// Friction cone: the forces that the environment may exert at a contact, in its frame C = (k, t₁, t₂) with k the inward normal of the
/// robot's surface: f = (f_k, f_t) with ‖f_t‖ ≤ μ f_k, or the polyhedral cone of n_d unit rays inside it (4.2)
///     v_i = (1, μ cos θ_i, μ sin θ_i) / √(1 + μ²) ,   θ_i = 2π i / n_d .
class FrictionCone {
 public:
  static constexpr int kMostRays = 64;

  /// @param friction  μ ≥ 0; 0: the normal alone
  /// @param rays      n_d, 3 to kMostRays; 0: the exact (Lorentz) cone
  /// @throws core::InvalidInput naming friction or rays
  explicit FrictionCone(double friction = 1, int rays = 4);

  double friction() const { return friction_; }
  int rays() const { return static_cast<int>(rays_.cols()); }
  bool is_lorentz() const { return lorentz_; }
  const Eigen::Matrix3Xd& ray_matrix() const { return rays_; }       ///< V_C (3 × n_d)
  const Eigen::Matrix3Xd& facet_normals() const { return facets_; }  ///< inward normals of the facets between rays i and i + 1 (3 × n_d)
  /// Facets: ray i in rows 0 to 2 and ray i + 1 in rows 3 to 5. The first columns are repeated up to a multiple of four (6 × …).
  const Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>& facet_rays() const { return facet_rays_; }
  bool contains(const Eigen::Vector3d& f_C, double slack = 0) const;  ///< slack [-]: allowed violation as a share of ‖f‖

 private:
  double friction_;
  bool lorentz_;
  Eigen::Matrix3Xd rays_, facets_;
  Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor> facet_rays_;
  void fill_facet_rays();
};

/// R_LC with columns k = −n, t₁ ∝ (k_y, −k_x, 0), t₂ = k × t₁; if k is along z, t₁ ∝ (0, k_z, −k_y).
Eigen::Matrix3d make_contact_frame(const Eigen::Vector3d& outward_normal);

}  // namespace stiction::sensing
