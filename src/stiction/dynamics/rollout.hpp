#pragma once

#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/dynamics/step.hpp"

namespace stiction::dynamics {

/// How far one sub-step may go. A single large step lets friction act across the gap of Anitescu's relaxation (2.3.4) and freezes
/// the contact geometry, so long moves are cut.
struct SubstepLimits {
  double joint_angle = 0.03;   ///< largest move of a revolute command [rad], > 0
  double joint_travel = 0.01;  ///< largest move of a prismatic command [m], > 0
  double slide = 1e-3;         ///< largest μ·slip at an active contact, the gap that Anitescu's relaxation opens there (2.3.4) [m], > 0
  int max_substeps = 400;      ///< per call, ≥ 1
  void validate() const;
};

/// State after one sub-step.
struct Knot {
  Eigen::VectorXd u;                     ///< command (n_a)
  Eigen::VectorXd q;                     ///< configuration reached (n_q)
  std::vector<ContactImpulse> contacts;  ///< the active ones
};

struct RolloutResult {
  core::Status status = core::Status::NumericalFailure;
  std::vector<Knot> knots;  ///< up to and including the last good sub-step
  int steps = 0;            ///< steps computed, including those redone with a shorter command
  double max_slide = 0;     ///< [m] largest μ·slip of an active contact in one accepted sub-step
  double penetration = 0;   ///< deepest after the first sub-step, as a share of world::Scales::contact_tolerance of its pair, ≥ 0
  double min_phi = 0;       ///< [m] deepest signed distance met after the first sub-step, ≤ 0
};

/// What happens at a sub-step that slides too far however short it is.
enum class Overrun {
  Accept,  ///< it is taken, and shows in max_slide
  Stop     ///< the rollout ends before it
};

/// A step for which no motor is asked for more than it bears: where one gives all it has, u becomes as far ahead of the joint as that takes, q⁺ ± effort/K_a. That
/// is the same step in theory; it is computed anew, so that `out` follows from the u that is kept alone.
/// @param u  command (n_a), changed where options.effort_limits has motors saturate
/// @param steps  counts the steps computed
/// @returns the status of the last of them; NumericalFailure where no command is found, since with Coulomb's law every one leads to another solution
core::Status step_within_efforts(const world::Model& model, VectorRef q, Eigen::VectorXd& u, const StepOptions& options,
                                 StepWorkspace& work, StepResult& out, int& steps);

/// Number of equal parts into which the command must be cut so that no joint moves farther than the limits, ≥ 1.
int count_substeps(const world::Model& model, VectorRef u_start, VectorRef u_end, const SubstepLimits& limits);

/// Moves the command from u_start to u_end in equal parts small enough for the limits, with the dynamics of options.
/// A sub-step in which μ times the slip of an active contact exceeds limits.slide is redone with half the command increment, four times at most;
/// with Coulomb's law also one in which a force acts across more than world::Scales::contact_tolerance.
/// With options.effort_limits knots come from step_within_efforts; a joint whose motor held it back catches up by sub-steps within the limits, and may end
/// before u_end. One that is pushed back farther than a sub-step may go ends the rollout before that.
/// @param control  looked at before every sub-step; null: it is never stopped
/// @returns Solved: u_end reached; MaxIterations: max_substeps or the time used up, or stopped before a slide or a recoil; Cancelled; otherwise the status of the step
///          that failed
core::Status rollout(const world::Model& model, VectorRef q, VectorRef u_start, VectorRef u_end, const StepOptions& options,
                     const SubstepLimits& limits, StepWorkspace& work, RolloutResult& out, Overrun overrun = Overrun::Accept,
                     const core::RunControl* control = nullptr);

}  // namespace stiction::dynamics
