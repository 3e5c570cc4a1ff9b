#pragma once

#include <vector>

#include "stiction/contact/contact.hpp"

namespace stiction::contact {

/// Tells whether robots alone hold an object, so that it falls if they lose their grip.
/// Tests: tests/contact/carried_test.cpp
class Carried {
 public:
  explicit Carried(const world::Model& model);

  /// False if nothing in the scene can fall: no object has a weight, or all hang on hinges and sliders.
  bool possible() const { return !supports_.empty(); }
  /// True if an object that can fall is farther than the contact tolerance from everything that is not a robot's.
  bool any(const world::Kinematics& kinematics, Workspace& work) const;
  /// True if an object that can fall is within the contact tolerance of a part of a robot that no joint moves, such as the palm of a hand.
  bool lies_in_hand(const world::Kinematics& kinematics, Workspace& work) const;

 private:
  bool near(int pair, const world::Kinematics& kinematics, Workspace& work) const;

  const world::Model& model_;
  std::vector<std::vector<int>> supports_;  ///< for each object that can fall, its pairs with what no robot moves
  std::vector<int> palms_;                  ///< of these pairs those with parts of robots
};

}  // namespace stiction::contact
