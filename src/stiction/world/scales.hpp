#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace stiction::world {

class Model;

/// Length and force of one object, pair or robot in a scene. Every threshold on a length or force is a share of them (shares below).
struct Scale {
  double length = 0;  ///< L [m]
  double force = 0;   ///< F [N]
};

/// Thresholds as shares of L and F. For tasks of 0.1 m and 1 N they are near the values found by hand: a gap of 1 mm, κ = 1000/J, γ = 1e-4 m².
namespace share {
inline constexpr double kContact = 0.01;       ///< of L: a force acts across at most this gap; bodies overlap by at most this
inline constexpr double kSlide = 0.01;         ///< of L: μ·slip in a sub-step, the gap that Anitescu's law opens (2.3.4)
inline constexpr double kTravel = 0.05;        ///< of L: motion of a sliding joint in a sub-step
inline constexpr double kMotionless = 1e-3;    ///< of L: motion that counts as none
inline constexpr double kClearance = 0.02;     ///< of L: distance between a moving branch and the bodies that it must not touch
inline constexpr double kRelease = 0.05;       ///< of L: largest displacement of an object when it is released
inline constexpr double kReleaseAngle = 0.1;   ///< largest rotation of an object when it is released [rad]
inline constexpr double kActive = 3e-4;        ///< of F: a contact with a smaller force counts as inactive
inline constexpr double kForce = 1e-3;         ///< of F: smaller forces are ignored
inline constexpr double kPreload = 5;          ///< of F: strain of the springs, as a force, at the start of a push
inline constexpr double kBrace = 5;            ///< of F: largest force of a robot on itself or on fixed bodies
inline constexpr double kLift = 0.03;          ///< of L: gap at which the smoothed step holds an object
inline constexpr double kMetric = 0.01;        ///< of L²: γ of (3.5)
inline constexpr double kSpread = 0.4;         ///< of L: standard deviation of postures of sliding joints
inline constexpr double kSpringTravel = 0.01;  ///< of L: compression of the softest spring that defines F if gravity does not (L.3)
}  // namespace share

/// Lengths L and forces F of the objects, pairs and robots of a scene; all thresholds derive from them (docs/theory/scales.md).
///
/// L of an object: geometric mean of the edges of the box with the same second moments as its shapes at uniform density, (det 12C)^(1/6).
///   For an object that moves in a plane, only the two edges in that plane count, (det 12C₂)^(1/4) (L.1). A cube has its edge, a ball 1.55 radii.
///   L is the same in every frame of the object. For an object without shapes, its inertia gives L.
/// F of an object: m|g| (L.2), where g is the part of gravity along its motion (for a hinge: across the axis) and m includes all objects
///   that hang on it; or its dry friction, if larger. If both are 0, F is the force of the softest joint over 0.01 L, K_a/reach²·0.01 L (L.3).
///   Without robots, F is m|g| with all of gravity; without gravity, F is m L/s².
/// L of the robots: the least L of an object; without objects, the diameter of the largest ball around a moving shape.
/// F of the robots: the least F of an object; without objects, K_a/reach²·0.01 L.
///
/// Units: multiply lengths by s and masses by m, and keep gravity and time. Then forces grow by m s, linear stiffness by m and angular
/// stiffness by m s². L grows by s and F by m s, exactly for powers of two (tests/world/scales_test.cpp).
class Scales {
 public:
  explicit Scales(const Model& model);

  const Scale& object(int i) const { return objects_[static_cast<std::size_t>(i)]; }
  const Scale& robots() const { return robots_; }
  /// Scale of a contact of pair i: the least L and the least F of the objects in the pair; robots() for a pair without objects.
  const Scale& pair(int i) const { return pairs_[static_cast<std::size_t>(i)]; }
  /// Largest gap across which a force of pair i may act, and largest overlap of its two sides, in an accepted plan [m].
  double contact_tolerance(int i) const { return share::kContact * pair(i).length; }
  /// Unit in which the motion of joint j is measured: 1 rad, or L of the robots for a sliding joint [rad or m].
  double joint(int j) const { return joints_[j]; }
  const Eigen::VectorXd& joints() const { return joints_; }  ///< (n_a)
  /// K_a/reach² of the softest joint [N/m]; 0 without robots.
  double softest_stiffness() const { return softest_; }

  /// Barrier weight κ [1/J] at which a smoothed contact carries F of the object at the gap kLift·L: f φ = 2/κ (2.27), (L.4).
  double kappa(int object) const;
  /// γ of (3.5) [m²].
  double gamma(int object) const;

 private:
  std::vector<Scale> objects_, pairs_;
  Eigen::VectorXd joints_;
  Scale robots_;
  double softest_ = 0;
};

}  // namespace stiction::world
