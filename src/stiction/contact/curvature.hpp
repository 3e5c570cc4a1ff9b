#pragma once

#include <Eigen/Core>

#include "stiction/contact/contact.hpp"
#include "stiction/contact/shape_data.hpp"

// Internal to the layer: how witness points and normal move with the bodies. docs/theory/contact.md §8.

namespace stiction::contact::detail {

/// A surface near its witness point, to second order: radii in [0, ∞] along two directions perpendicular to the normal and to each other.
/// A vertex has 0, 0; an edge ∞ along itself and 0 across; a plane or face ∞, ∞; a sphere r, r.
struct Surface {
  double radius_along = 0;    ///< [m]
  double radius_across = 0;   ///< [m]
  Vector3d along_W{0, 0, 0};  ///< first direction; zero if the radii are equal. Its component along the normal is ignored
};

/// Surface of a shape at the point p with outward normal m. The position of p alone selects the features: p lies on the plane, side or cap
/// for which its height is largest, and on those for which it is less than 1e-8 of the bounding radius lower (docs/theory/contact.md §8).
/// @param p_W  witness point, on the surface to within 1e-9 of the bounding radius
Surface calc_surface(const ShapeData& shape, const Pose& X_WG, const Vector3d& p_W, const Vector3d& m_W);

/// Matrix of the rolling of two surfaces on each other across a gap (D.3). ω are the angular velocities, v the velocities of the material
/// points at the witness points, and all components are (t1, t2):
///
///     (ν_B; s_A; s_B) = D · ([(ω_A − ω_B) × n]_t; φ [ω_B × n]_t − (v_A − v_B)_t)
///
/// where the normal moves by ω_B × n + ν_B and the witness points by v_A + s_A and v_B + s_B.
using Rolling = Eigen::Matrix<double, 6, 4>;

/// @param length  length of the order of the shapes [m], finite and > 0; scales the system
Rolling calc_rolling(const Surface& a, const Surface& b, const Contact& contact, double length);

/// Spin of the contact frame about its normal: n·(angular velocity of the frame) = result · (dn·t1, dn·t2). (D.5)
Eigen::Vector2d calc_frame_spin(const Contact& contact, const std::optional<int>& planar_axis);

}  // namespace stiction::contact::detail
