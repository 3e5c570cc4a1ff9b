#pragma once

#include "stiction/contact/features.hpp"

// Internal to the layer: where two features of (6) are nearest. docs/theory/distance.md §5.

namespace stiction::contact::detail {

/// Normal at which the separation between two features is stationary and a maximum, starting from n; false if there is none near.
bool find_normal(const Feature& a, const Feature& b, Vector3d& n);

/// Points of the two features that lie on one line along n. False if they lie outside their features or are not unique.
bool find_points(const Feature& a, const Feature& b, const Vector3d& n, double scale, Vector3d& p_a, Vector3d& p_b);

/// A rim that is seen as a circle along n.
bool is_flat_rim(const Feature& f, const Vector3d& n);

/// Where the circle of a flat rim meets another flat rim, or the line along another feature, seen along n.
int find_starts(const Feature& rim, const Feature& other, const Vector3d& n, const Vector3d& towards, Vector3d out[2]);

/// A rim seen along its axis turns by any angle with a small turn of n, so that n is no coordinate there. The places on both curves
/// are, (6b): the line between them is square to both. False if Newton's method does not end in such a line near `start`.
bool find_crossing(const Feature& of_a, const Feature& of_b, const Vector3d& near, Vector3d& n, Vector3d& p_a, Vector3d& p_b);

}  // namespace stiction::contact::detail
