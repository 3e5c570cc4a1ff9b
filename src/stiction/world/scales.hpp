#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace stiction::world {

class Model;

/// Size and force of one thing in a scene; every length and force that a threshold needs is a share of them (the shares are below).
struct Scale {
  double length = 0;  ///< L [m]
  double force = 0;   ///< F [N]
};

/// Thresholds are shares of L and F. Tasks of 0.1 m and 1 N get what was found by hand for them: a gap of 1 mm, κ = 1000/J, γ = 1e-4 m².
namespace share {
inline constexpr double kContact = 0.01;       ///< of L: a force acts across at most this gap; bodies overlap by at most this
inline constexpr double kSlide = 0.01;         ///< of L: μ·slip in a sub-step, the gap that Anitescu's law opens (2.3.4)
inline constexpr double kTravel = 0.05;        ///< of L: move of a sliding joint in a sub-step
inline constexpr double kMotionless = 1e-3;    ///< of L: motion that counts as none
inline constexpr double kClearance = 0.02;     ///< of L: between a moving branch and what it must not touch
inline constexpr double kRelease = 0.05;       ///< of L: an object may settle by this when it is let go …
inline constexpr double kReleaseAngle = 0.1;   ///< … and turn by this [rad]
inline constexpr double kActive = 3e-4;        ///< of F: a contact with a smaller force carries nothing
inline constexpr double kForce = 1e-3;         ///< of F: smaller forces are not looked at
inline constexpr double kPreload = 5;          ///< of F: strain of the springs that a push starts with
inline constexpr double kBrace = 5;            ///< of F: with which a robot may press on itself or on what does not move
inline constexpr double kLift = 0.03;          ///< of L: height at which the smoothed step holds an object
inline constexpr double kMetric = 0.01;        ///< of L²: γ of (3.5)
inline constexpr double kSpread = 0.4;         ///< of L: standard deviation of postures of sliding joints
inline constexpr double kSpringTravel = 0.01;  ///< of L: compression of the softest spring that gives F where gravity does not
}  // namespace share

/// The one place that says how large and how heavy things are.
///
/// L of an object: geometric mean of the edges of the box that has the second moments of its shapes at uniform density, (det 12C)^(1/6);
/// of an object that moves in a plane of the two edges in it, (det 12C₂)^(1/4). The edges of a box, 1.55 radii of a ball; the same in every
/// frame of the object. An object without shapes has that of its inertia.
/// F of an object: m|g| with the part g of gravity along its motion (of a hinge: across the axis) and all that hangs on it; without such
/// a part what the softest joint gives over 0.01 L, K_a/reach²·0.01 L; without robots m|g| of all of gravity; without gravity m L/s².
/// L of the robots: the least L of an object; without objects the largest ball around a shape that moves.
/// F of the robots: the least F of an object; without objects K_a/reach²·0.01 L.
///
/// Lengths times s, masses times m, gravity and time as they are (so forces and linear stiffness times m s and m, angular stiffness
/// times m s²): L is times s and F times m s, exact for powers of two (tests/world/scales_test.cpp).
class Scales {
 public:
  explicit Scales(const Model& model);

  const Scale& object(int i) const { return objects_[static_cast<std::size_t>(i)]; }
  const Scale& robots() const { return robots_; }
  /// Of the smaller thing: what a contact of the pair is measured by, the least L and the least F of the objects in it; robots() for a pair without.
  const Scale& pair(int i) const { return pairs_[static_cast<std::size_t>(i)]; }
  /// Largest gap across which a force of the pair acts, and depth by which its sides overlap, in a plan that is accepted [m].
  double contact_tolerance(int i) const { return share::kContact * pair(i).length; }
  /// What a move of a joint is large or small beside: 1 rad, or L of the robots for one that slides [rad or m].
  double joint(int j) const { return joints_[j]; }
  const Eigen::VectorXd& joints() const { return joints_; }  ///< (n_a)
  /// K_a/reach² of the softest joint [N/m]; 0 without robots.
  double softest_stiffness() const { return softest_; }

  /// Barrier weight κ [1/J] at which a contact holds F of the object at kLift·L: f φ = 2/κ (2.27).
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
