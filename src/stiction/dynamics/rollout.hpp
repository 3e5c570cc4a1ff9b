#pragma once

#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/dynamics/step.hpp"

namespace stiction::dynamics {

/// Limits on the length of one sub-step. A single large step lets friction act across the gap of Anitescu's relaxation (2.3.4) and freezes
/// the contact geometry, so the rollout cuts long moves into sub-steps.
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
  double max_slide = 0;     ///< largest μ·slip of an active contact in one accepted sub-step [m]
  double penetration = 0;  ///< deepest penetration after the first sub-step, as a share of the pair's world::Scales::contact_tolerance, ≥ 0
  double min_phi = 0;      ///< smallest signed distance after the first sub-step [m], ≤ 0
};

/// Reaction to a sub-step that slides too far even after its command was shortened.
enum class Overrun {
  Accept,  ///< the rollout accepts the sub-step and reports its slip in max_slide
  Stop     ///< the rollout ends before the sub-step
};

/// Takes a step whose command asks no motor for more than its effort. If a motor saturates, its command u becomes q⁺ ± effort/K_a, which
/// loads the spring with exactly the effort. In theory the step stays the same. It is computed again, so that `out` depends on the returned
/// u alone.
/// @param u      command (n_a), changed for motors that saturate under options.effort_limits
/// @param steps  incremented by the number of steps computed
/// @returns the status of the last step; NumericalFailure if no command is found, because with Coulomb's law each new command may lead to
///          another solution
core::Status step_within_efforts(const world::Model& model, VectorRef q, Eigen::VectorXd& u, const StepOptions& options,
                                 StepWorkspace& work, StepResult& out, int& steps);

/// Number of equal parts into which the command must be cut so that no joint moves farther than the limits, ≥ 1.
int count_substeps(const world::Model& model, VectorRef u_start, VectorRef u_end, const SubstepLimits& limits);

/// Moves the command from u_start to u_end in equal parts small enough for the limits, with the dynamics of options.
///
/// A sub-step in which μ times the slip of an active contact exceeds limits.slide is repeated with half the command increment, at most four
/// times. With Coulomb's law, a sub-step with a force across a gap above world::Scales::contact_tolerance is repeated too.
/// With options.effort_limits each knot comes from step_within_efforts(). A joint held back by a saturated motor catches up in sub-steps
/// within the limits, and may end before u_end. The rollout ends before a joint is pushed back farther than one sub-step allows.
/// @param control  checked before every sub-step; null: the rollout is never stopped
/// @returns Solved: u_end reached; MaxIterations: max_substeps or the time used up, or stopped before a slide or a recoil; Cancelled;
///          otherwise the status of the step that failed
core::Status rollout(const world::Model& model, VectorRef q, VectorRef u_start, VectorRef u_end, const StepOptions& options,
                     const SubstepLimits& limits, StepWorkspace& work, RolloutResult& out, Overrun overrun = Overrun::Accept,
                     const core::RunControl* control = nullptr);

}  // namespace stiction::dynamics
