#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "stiction/planning/refine/command_follower.hpp"

namespace stiction::planning::refinement {

/// Weight γ of (E.6) without feedback.
inline constexpr double kNoFeedback = std::numeric_limits<double>::infinity();

/// The commands of a push with feedback, up to where it rests or not.
struct Way {
  std::vector<Segment> segments;
  Eigen::VectorXd q, u;
  bool known = false, good = false;  ///< simulated; it came to something
  bool counted = false;              ///< its work is in that of the trial
  Work work;
};

/// A push or a regrasp as it was simulated, and where that left everything.
struct Run {
  std::vector<Segment> segments;
  Cursor end;
  bool done = false;     ///< it came to something
  bool holds = false;    ///< at half sub-steps as well
  double whole = 0;      ///< missed at its end, in tolerances of the goal, at whole sub-steps
  double missed = 0;     ///< the worse of whole and half sub-steps, once finished
  double gamma = 0;      ///< of the feedback on a push
  Way* way = nullptr;    ///< of a push: shared by the runs that end at rest and those that do not
  bool rests = false;    ///< a push ends at rest
  double clearance = 0;  ///< of a regrasp that was planned anew [m]
  Work work;
};

/// Where runs start.
struct Start {
  const Problem& problem;
  const StepSizes& sizes;
  const Cursor& at;
  const Turn* turn;  ///< of the trial
};

/// From where the follower is. @returns false where it comes to nothing
using Simulate = std::function<bool(CommandFollower&, Run&)>;

/// The first run in a list that ends near enough to q_target, else the one that ends nearest. Half sub-steps are looked at
/// only of what may be it. Threads that are free try the next ones; what comes out, and the work that counts, are those of one thread.
/// @param enough  what is near enough, in tolerances of the goal
/// @param work    counts up
std::optional<Run> best_of(const Start& start, std::vector<Run> runs, const Eigen::VectorXd& q_target, double enough,
                           const Simulate& simulate, Crew& crew, Work& work);

/// Half sub-steps: `holds` is false where it penetrates there or pulls across a gap. The work counts as the run's.
void finish(const Start& start, const Eigen::VectorXd& q_target, Scratch& scratch, Run& run);

}  // namespace stiction::planning::refinement
