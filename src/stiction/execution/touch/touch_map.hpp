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

/// A place at which the arm was touched, estimated from torques.
struct TouchedPlace {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();   ///< [m]
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitX();  ///< unit normal out of the touched body: direction of the force on the arm
  double spread = 0;                               ///< standard deviation of the estimates of p [m], ≥ 0
};

/// The arm's knowledge of the world: the scene of a model, and a ball behind every touched place,
///     c = p − ρ n ,   of radius ρ + s ,                                                                                    (G.2)
/// whose surface is one deviation s beyond the place, towards the arm. ρ is a guess of the size of the obstacle: the length of the robots, halved until the
/// ball is outside of all places where the arm has been.
class TouchMap {
 public:
  /// Number of times that the first guess is halved: down to an eighth of it.
  static constexpr int kHalves = 3;

  explicit TouchMap(std::shared_ptr<const world::Model> known);

  /// Largest ρ (G.2) of a place for which the ball overlaps the arm by at most the spread in each of the `visited` postures (n_a); 0 if there is none.
  double find_radius(const TouchedPlace& place, std::span<const Eigen::VectorXd> visited) const;

  /// Adds a ball with this ρ [m], > 0.
  void add(const TouchedPlace& place, double radius);

  int size() const { return static_cast<int>(balls_.size()); }
  const world::Model& known() const { return *known_; }
  /// Makes the scene with the balls as fixed bodies touch_1, touch_2, …, each ρ multiplied by `share`.
  std::shared_ptr<const world::Model> make_model(double share) const;

 private:
  struct Ball {
    TouchedPlace place;
    double radius;
  };
  std::shared_ptr<const world::Model> known_;
  std::vector<Ball> balls_;
};

/// A path to a goal around the known obstacles.
struct Route {
  contact::PathOutcome outcome = contact::PathOutcome::NotFound;
  double share = 0;  ///< factor of the balls' radii with which it was found
  /// Postures back along the way that the arm came, until there is room; the first is the present one (n_a).
  std::vector<Eigen::VectorXd> retreat;
  std::vector<Eigen::VectorXd> postures;  ///< postures from there to the goal, both included
  double travel = 0;                      ///< travel along `postures`, (G.1) [m]
  std::shared_ptr<const world::Model> model;
};

/// Finds a path to the goal. If there is none with the guessed balls, their radii are halved, since only the touched places themselves are certain.
/// @param way  postures through which the arm came, at least one; the last is the present one (n_a)
/// @param control  can stop long searches
Route find_route(const TouchMap& map, std::span<const Eigen::VectorXd> way, const Eigen::VectorXd& goal, core::Random& random,
                 const core::RunControl& control);

/// Describes an outcome other than Found in words.
std::string describe(contact::PathOutcome outcome);

}  // namespace stiction::execution
