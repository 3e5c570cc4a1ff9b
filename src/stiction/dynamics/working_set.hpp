#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: which rows of (2.6) are in the program. The solution satisfies all other rows, or add_violated() adds them.

namespace stiction::dynamics::detail {

/// First-order bound on the motion of any point of an object (object_travel) or of any body (motion_bound) under δq [m].
double object_travel(const world::Model& model, const StepWorkspace::Impl& work, std::size_t object, const Eigen::VectorXd& delta);
double motion_bound(const world::Model& model, const StepWorkspace::Impl& work, const Eigen::VectorXd& delta);

/// J_c δq [m].
Eigen::Vector3d displacement(const world::Model& model, std::size_t i, const Eigen::VectorXd& delta, const StepWorkspace::Impl& work);

/// Slack of the rows of a contact with displacement v = J_c δq.
double slack(const StepWorkspace::Impl& work, double phi, double mu, const Eigen::Vector3d& v);

/// Selects the rows of a smoothed step. A self-contact enters at the gap where it pushes as hard as a contact with an object at its entry
/// distance, that is with the same σ/φ.
/// @param least_share  smallest share of σ of a rim point (S.17)
void include_smoothed(const world::Model& model, const StepInput& in, const StepOptions& options, double self_sharpness, double least_share,
                      StepWorkspace::Impl& work);

/// Includes the rows of contacts that the last solution met on its way.
void include_met(StepWorkspace::Impl& work);

/// Selects the rows that an exact step starts with. @param closed  contacts may slide without opening (Coulomb's law)
void include_within_reach(const world::Model& model, const StepInput& in, const StepOptions& options, bool closed,
                          StepWorkspace::Impl& work);

/// Selects the first rows of an exact step when an approximate δq is known.
void include_near(const world::Model& model, const StepInput& in, const StepOptions& options, const Eigen::VectorXd& guess,
                  StepWorkspace::Impl& work);

void include_all(const StepOptions& options, StepWorkspace::Impl& work);

/// Saturates, for the next round, each joint whose spring pulls with more than its effort at the solution, on that side only. The program
/// of each round bounds the energy (S.15) from above and equals it at the last solution. Its minimum therefore falls from round to round,
/// and no choice of sides occurs twice.
/// @returns true if any joint saturates
bool saturate_motors(const world::Model& model, const StepInput& in, StepWorkspace::Impl& work);

/// Adds the rows that the solution violates to the problem of the next round.
/// @param closed  contacts may slide without opening (Coulomb's law)
/// @returns true if any row was added
bool add_violated(const world::Model& model, const StepInput& in, const StepOptions& options, bool closed, StepWorkspace::Impl& work);

}  // namespace stiction::dynamics::detail
