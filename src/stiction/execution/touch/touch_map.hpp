#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stiction/contact/free_path.hpp"
#include "stiction/core/random.hpp"
#include "stiction/core/run_control.hpp"
#include "stiction/world/model.hpp"

namespace stiction::execution {

/// A place at which the arm was touched, as far as torques tell.
struct TouchedPlace {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();   ///< [m]
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitX();  ///< unit, out of what was touched: the direction of the force on the arm
  double spread = 0;                               ///< deviation of the estimates of p [m], ≥ 0
};

/// What is known of the world: the scene of a model, and a ball behind every place that was touched,
///     c = p − ρ n ,   of radius ρ + s ,                                                                                    (G.2)
/// that goes to the deepest estimate of the surface. ρ is a guess of how far the obstacle reaches: the length of the robots, or as many halves of it as the ball needs
/// to be outside of where the arm has been.
class TouchMap {
 public:
  /// Halves of the first guess that are tried: to an eighth of it.
  static constexpr int kHalves = 3;

  explicit TouchMap(std::shared_ptr<const world::Model> known);

  /// The largest ρ (G.2) of a place whose ball is outside of the arm in each of `visited` postures (n_a), up to the spread; 0: none is.
  double find_radius(const TouchedPlace& place, std::span<const Eigen::VectorXd> visited) const;

  /// A ball of this ρ [m], > 0.
  void add(const TouchedPlace& place, double radius);

  int size() const { return static_cast<int>(balls_.size()); }
  const world::Model& known() const { return *known_; }
  /// The scene with the balls as fixed bodies touch_1, touch_2, …, each ρ times `share`.
  std::shared_ptr<const world::Model> make_model(double share) const;

 private:
  struct Ball {
    TouchedPlace place;
    double radius;
  };
  std::shared_ptr<const world::Model> known_;
  std::vector<Ball> balls_;
};

/// A way to a goal among what is known.
struct Route {
  contact::PathOutcome outcome = contact::PathOutcome::NotFound;
  double share = 0;                       ///< of the radii of the balls at which it was found
  std::vector<Eigen::VectorXd> retreat;   ///< back along the way that the arm came, until there is room; the first is where it is (n_a)
  std::vector<Eigen::VectorXd> postures;  ///< from there to the goal, both included
  double travel = 0;                      ///< of `postures`, (G.1) [m]
  std::shared_ptr<const world::Model> model;
};

/// Where there is no way with the balls as they are guessed, they are halved: only the places themselves are known.
/// @param way  postures through which the arm came, the last is where it is (n_a), at least one
/// @param control  of long searches
Route find_route(const TouchMap& map, std::span<const Eigen::VectorXd> way, const Eigen::VectorXd& goal, core::Random& random,
                 const core::RunControl& control);

/// In words, of an outcome that is not Found.
std::string describe(contact::PathOutcome outcome);

}  // namespace stiction::execution
