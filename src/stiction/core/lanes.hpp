#pragma once

#include <functional>

#include "stiction/core/parallel.hpp"

namespace stiction::core {

/// What goes on in a lane, in rounds: a turn takes in what came of the round before and draws the next one; items of a round do not see each other.
class LaneTask {
 public:
  virtual ~LaneTask() = default;
  virtual int turn(int worker) = 0;  ///< @returns items of the next round; 0: it has ended
  virtual void work(int item, int worker) = 0;
  virtual long cost() const = 0;  ///< of all rounds taken in so far, in a unit that is the same on every machine
};

/// Lets tasks go on side by side so that the outcome depends neither on the number of threads nor on their speed. The clock of a lane is what its
/// tasks have cost. Where tasks end, they are told of in the order of the clocks, of equal ones in that of the lanes: the end of one waits until the
/// other lanes have come as far. Threads help where the clock is behind; turns of one lane never overlap, nor a turn with items of its lane.
/// @param next  called one at a time: a task for the lane, at its clock; `ended` is the one before, nullptr at first. nullptr closes the lane, and all
///              of them the run
/// Tests: tests/core/lanes_test.cpp
void run_lanes(ThreadPool& pool, int lanes, const std::function<LaneTask*(int lane, LaneTask* ended, long clock)>& next);

}  // namespace stiction::core
