#pragma once

#include "stiction/planning/refine/crew.hpp"
#include "stiction/planning/refine/problem.hpp"

namespace stiction::planning::refinement {

/// Where a trial is, at whole sub-steps and at half of them.
struct Cursor {
  Eigen::VectorXd q, u;
  HalfSteps fine;
};

/// Follows commands with the exact dynamics, in the sub-steps of a trial, and stores them. What returns bool is false where a step is not solved, starts deeper
/// inside something than is allowed at half sub-steps, or nothing depends on it any more.
class CommandFollower {
 public:
  /// @param turn  of what is tried; may be nullptr
  CommandFollower(const Problem& problem, const StepSizes& sizes, const Eigen::VectorXd& q_start, const Eigen::VectorXd& u_start,
                  const Turn* turn, Scratch& scratch)
      : q(q_start), u(u_start), problem_(problem), sizes_(sizes), turn_(turn), scratch_(scratch) {}

  Eigen::VectorXd q, u;  ///< state and command reached
  Work work;

  const Problem& problem() const { return problem_; }
  const StepSizes& sizes() const { return sizes_; }
  Scratch& scratch() { return scratch_; }
  bool stop() const { return stops(problem_.control, turn_); }
  Eigen::VectorXd within_limits(const Eigen::VectorXd& command) const;

  /// One sub-step.
  bool advance(const Eigen::VectorXd& command, Segment& segment);
  /// In so many sub-steps or more, which keep the limits of the plan.
  bool advance_in_parts(const Eigen::VectorXd& command, Segment& segment, int least = 1);
  /// The commands of a segment, in steps that are sizes().cuts times as short.
  bool replay(const Segment& from, Segment& segment);
  /// The regularisation holds objects back in every sub-step (S.3); in the world nothing does for long.
  bool come_to_rest(Segment& push);

 private:
  /// One sub-step, not stored, with the command drawn back where the motors cannot follow it.
  bool step_within_efforts(Eigen::VectorXd& command);
  /// Moves the command in equal parts. Where a motor held its joint back the command follows by what a sub-step may, as in dynamics::rollout, and may end
  /// before it is there.
  bool ramp(const Eigen::VectorXd& command, int parts, Segment& segment);

  const Problem& problem_;
  const StepSizes& sizes_;
  const Turn* turn_;
  Scratch& scratch_;
};

}  // namespace stiction::planning::refinement
