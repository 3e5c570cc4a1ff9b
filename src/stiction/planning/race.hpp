#pragma once

#include <vector>

namespace stiction::planning {

/// Which of many trees grows next, and how far (P.10): asynchronous successive halving (Li et al. 2020). On rung k a tree has `first` · 2ᵏ extensions; of those
/// that came to a rung the half that is nearest the goal may go on to the next one. The highest rung with such a tree comes first; where there is none, a
/// new tree starts.
/// Tests: tests/planning/race_test.cpp
class Race {
 public:
  explicit Race(long first) : first_(first) {}  ///< extensions of a new tree, ≥ 1

  int next();                   ///< number of a tree, a new one where it is that of the trees so far; it then is under way
  long budget(int tree) const;  ///< extensions in all that a tree under way may grow to
  /// A tree under way used up its budget, or has stalled: then it never goes on. Others may be under way meanwhile.
  /// @param distance  of the objects from the goal; smaller is better
  void reached(int tree, double distance, bool stalled);

 private:
  struct Place {
    int tree;
    double distance;
    bool went_on;
  };
  long first_;
  std::vector<int> rung_of_;               ///< per tree, −1: none yet
  std::vector<std::vector<Place>> rungs_;  ///< each from the nearest to the farthest
};

}  // namespace stiction::planning
