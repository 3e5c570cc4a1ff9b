#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: which rows of (2.6) are in the program. Those left out hold with room at the solution, or are added (add_violated).

namespace stiction::dynamics::detail {

/// No point of an object, or of any body, travels farther than this under δq, first order [m].
double object_travel(const world::Model& model, const StepWorkspace::Impl& work, std::size_t object, const Eigen::VectorXd& delta);
double motion_bound(const world::Model& model, const StepWorkspace::Impl& work, const Eigen::VectorXd& delta);

/// J_c δq [m].
Eigen::Vector3d displacement(const world::Model& model, std::size_t i, const Eigen::VectorXd& delta, const StepWorkspace::Impl& work);

/// Slack of the rows of a contact that is displaced by v, J_c δq.
double slack(const StepWorkspace::Impl& work, double phi, double mu, const Eigen::Vector3d& v);

/// Rows of a smoothed step: self-contacts enter where they push as hard as a contact with an object does where it enters, σ/φ is the same.
/// @param least_share  of σ that the point of a rim has (S.17)
void include_smoothed(const world::Model& model, const StepInput& in, const StepOptions& options, double self_sharpness, double least_share,
                      StepWorkspace::Impl& work);

/// Contacts that the last solution met on its way have their rows in the program.
void include_met(StepWorkspace::Impl& work);

/// Rows that an exact step looks at first. @param closed  contacts may slide without opening (Coulomb)
void include_within_reach(const world::Model& model, const StepInput& in, const StepOptions& options, bool closed,
                          StepWorkspace::Impl& work);

/// The same where δq is known roughly.
void include_near(const world::Model& model, const StepInput& in, const StepOptions& options, const Eigen::VectorXd& guess,
                  StepWorkspace::Impl& work);

void include_all(const StepOptions& options, StepWorkspace::Impl& work);

/// Joints whose spring pulls with more than its effort at the solution saturate on that side in the next round, and on no other; true when there are any. The program of a
/// round bounds the energy (S.15) from above and is equal to it at the last solution, so that its minimum falls from round to round and none comes twice.
bool saturate_motors(const world::Model& model, const StepInput& in, StepWorkspace::Impl& work);

/// Puts rows that the solution violates into the problem of the next round; true when there are any.
/// @param closed  they may slide without opening (Coulomb)
bool add_violated(const world::Model& model, const StepInput& in, const StepOptions& options, bool closed, StepWorkspace::Impl& work);

}  // namespace stiction::dynamics::detail
