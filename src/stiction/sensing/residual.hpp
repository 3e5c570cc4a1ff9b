#pragma once

#include <Eigen/Core>

#include "stiction/sensing/friction_cone.hpp"
#include "stiction/sensing/link_torque.hpp"

namespace stiction::sensing {

/// Part of the cone in whose relative interior the best force lies.
enum class ConeFace {
  Apex,     ///< f = 0
  Edge,     ///< one ray
  Facet,    ///< between two neighbouring rays; for the Lorentz cone its boundary
  Interior  ///< the cone is not active
};

struct Residual {
  double value = 0;                                   ///< l (4.5) [(N·m)²]
  Eigen::Vector3d force_C = Eigen::Vector3d::Zero();  ///< in the contact frame [N]
  ConeFace face = ConeFace::Apex;
  int ray = -1;  ///< first ray of the edge or facet
};

/// The residual (4.5) of a contact point
///     l(p) = min_{f ∈ K} ‖J_Cᵀ f − τ‖² + ρ ‖f‖² = τᵀτ + min_{f ∈ K} (fᵀ A f − 2 aᵀ f) ,   A = J_C J_Cᵀ + ρ 1 ,  a = J_C τ        (Y.2)
/// in closed form. For a polyhedral cone: each face (apex, edges, facets, interior) has a minimiser on its span; the result is the least
/// value among the minimisers that lie in their face. If A is singular on the span of a face, the face is left out: a cone with an apex
/// contains no line, so the same value is attained on the boundary of the face. For the Lorentz cone see minimize_lorentz.
///
/// @param link  LinkTorque of the touched link at q and τ   @param p_L  contact point   @param R_LC  make_contact_frame of its normal
/// The force is not unique if rank J_C < 3 and ρ = 0; one of the minimisers is then returned.
/// Tests: tests/sensing/residual_test.cpp (ProxQP; KKT). Source: docs/theory/sensing.md
Residual calc_residual(const LinkTorque& link, const Eigen::Vector3d& p_L, const Eigen::Matrix3d& R_LC, const FrictionCone& cone);

/// min_{f ∈ K} fᵀ A f − 2 aᵀ f in the contact frame; `value` is the minimum, ≤ 0. @param a  in the range of A, which is ⪰ 0
Residual minimize_polyhedral(const Eigen::Matrix3d& A, const Eigen::Vector3d& a, const FrictionCone& cone);

/// The same for the exact cone, as a root of one variable. With h(s) = min over ‖f_t‖ ≤ μ s of the objective at f_k = s, which is convex,
/// s ≥ 0 is where h′(s) = 0; the tangential part is a trust-region problem in the plane, solved in its principal axes.
Residual minimize_lorentz(const Eigen::Matrix3d& A, const Eigen::Vector3d& a, double friction);

/// ∇_p l (4.12) [(N·m)²/m] by the envelope theorem, with normal and cone held: 2 f × (J_w r), r = J_Cᵀ f − τ.  (Y.3)
/// @param f_L  a minimiser of (4.5) at p_L
inline Eigen::Vector3d calc_gradient(const LinkTorque& link, const Eigen::Vector3d& p_L, const Eigen::Vector3d& f_L) {
  return 2 * f_L.cross(link.w_residual(p_L, f_L));
}

/// Points and contact frames of many samples, structure of arrays: rows x, y, z of p_L, then the columns k, t₁, t₂ of R_LC.
struct SampleBatch {
  Eigen::Matrix<double, 12, Eigen::Dynamic, Eigen::RowMajor> rows;  ///< columns: samples, padded to a multiple of four
  Eigen::Index size = 0;                                            ///< without the padding

  void resize(Eigen::Index samples);  ///< set() of the last sample also fills the padding
  void set(Eigen::Index i, const Eigen::Vector3d& p_L, const Eigen::Matrix3d& R_LC);
  Eigen::Vector3d p_L(Eigen::Index i) const { return rows.col(i).head<3>(); }
  Eigen::Matrix3d R_LC(Eigen::Index i) const;
};

/// Computes calc_residual(…).value of every sample, four at a time. @param out (≥ the number of columns of batch.rows)
void calc_residuals(const LinkTorque& link, const SampleBatch& batch, const FrictionCone& cone, Eigen::Ref<Eigen::VectorXd> out);

}  // namespace stiction::sensing
