#pragma once

#include "stiction/contact/features.hpp"

// Internal to the layer: the nearest points of two features (6). docs/theory/distance.md §5.

namespace stiction::contact::detail {

/// Finds the normal that maximises the separation of two features, starting from n. @returns false if there is no maximum near n
bool find_normal(const Feature& a, const Feature& b, Vector3d& n);

/// Finds the points of the two features that lie on one line along n. @returns false if the points lie outside their features or are not
/// unique
bool find_points(const Feature& a, const Feature& b, const Vector3d& n, double scale, Vector3d& p_a, Vector3d& p_b);

/// Whether the feature is a rim that looks like a circle when seen along n.
bool is_flat_rim(const Feature& f, const Vector3d& n);

/// Finds where the circle of a flat rim crosses another flat rim, or the line along another feature, as seen along n.
int find_starts(const Feature& rim, const Feature& other, const Vector3d& n, const Vector3d& towards, Vector3d out[2]);

/// Finds the nearest points of two curves, one of which is a rim seen nearly along its axis. A small turn of n moves the support point of
/// such a rim by any angle, so the unknowns are the positions on both curves instead of n (6b): the line between the points is
/// perpendicular to both.
/// @returns false if Newton's method does not converge to such a line near `near`
bool find_crossing(const Feature& of_a, const Feature& of_b, const Vector3d& near, Vector3d& n, Vector3d& p_a, Vector3d& p_b);

}  // namespace stiction::contact::detail
