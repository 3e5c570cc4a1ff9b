#pragma once

#include <string_view>
#include <vector>

#include "stiction/sensing/descent.hpp"

namespace stiction::bench {

using sensing::ContactPoint;
using sensing::Sensor;
using sensing::VectorRef;

/// How the line of action of a force ended.
enum class LineVerdict {
  BelowThreshold,  ///< no torque is above it
  OtherLink,       ///< the last joint with torque moves no sensed link
  RankDeficient,   ///< fewer than six joints before the link, or a singular posture: the wrench is not unique
  NoForce,         ///< a moment without a force
  Misses,          ///< the line meets no triangle that the force pushes on
  Found
};
std::string_view to_string(LineVerdict verdict) noexcept;

struct LineOfAction {
  LineVerdict verdict = LineVerdict::BelowThreshold;
  std::vector<ContactPoint> points;  ///< where the line enters the link; more than one on links that are not convex
};

/// The baseline of Haddadin, De Luca and Albu-Schäffer (IEEE T-RO 33, 2017), as the thesis describes it in 4.2: contact is on the link after the last joint whose torque
/// shows, i = max {j : |τ_j| > ε}; its wrench (m, f) about the link's origin follows from
///     J_wᵀ m + J_vᵀ f = τ ,    and with no moment at the contact    m = p × f :  p(s) = (f × m + s f) / ‖f‖² .                          (Y.8)
/// Contacts are where this line meets the surface and f pushes, fᵀn < 0.
/// @param tau  (n_a) [N m; N]    @param epsilon  of each torque, > 0
/// @throws core::InvalidInput: sizes, numbers that are not finite, ε
/// Tests: tests/sensing/line_of_action_test.cpp
LineOfAction find_line_of_action(const Sensor& sensor, VectorRef q, VectorRef tau, double epsilon);

}  // namespace stiction::bench
