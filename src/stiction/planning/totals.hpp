#pragma once

#include "stiction/core/status.hpp"

namespace stiction::planning {

/// Number of dynamics steps that were computed.
struct Work {
  long steps = 0;         ///< exact steps
  long failed_steps = 0;  ///< steps whose solve did not end in Solved

  /// Counts n steps, the last of which ended with this status. @returns it was solved
  bool add(long n, core::Status last) {
    steps += n;
    failed_steps += last != core::Status::Solved;
    return last == core::Status::Solved;
  }
  Work& operator+=(const Work& o) {
    steps += o.steps;
    failed_steps += o.failed_steps;
    return *this;
  }
};

/// Number of regrasps that were tried, by outcome.
struct RegraspCounts {
  long tried = 0, accepted = 0;
  long no_sample = 0;     ///< no posture in contact was found
  long no_path = 0;       ///< no collision-free path
  long object_moved = 0;  ///< the object did not stay where it was
  long unstable = 0;      ///< of these: under tilted gravity, after branches had let go
  long failed_step = 0;   ///< a step was not solved

  RegraspCounts& operator+=(const RegraspCounts& o) {
    tried += o.tried;
    accepted += o.accepted;
    no_sample += o.no_sample;
    no_path += o.no_path;
    object_moved += o.object_moved;
    unstable += o.unstable;
    failed_step += o.failed_step;
    return *this;
  }
};

/// Amount of work and outcomes of a search.
struct Totals : Work {
  long linearisations = 0;  ///< smoothed steps with B
  long distrusted = 0;      ///< edges rejected because half the sub-step gave another result
  RegraspCounts regrasps;

  Totals& operator+=(const Totals& o) {
    Work::operator+=(o);
    linearisations += o.linearisations;
    distrusted += o.distrusted;
    regrasps += o.regrasps;
    return *this;
  }
};

}  // namespace stiction::planning
