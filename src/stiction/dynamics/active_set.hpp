#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: rounds in which the rows of (2.6) are chosen and the program is solved, until no row that was left out is violated.

namespace stiction::dynamics::detail {

/// Barrier weights σ of a smoothed step [J·s]; all are 0 in an exact one.
struct Barrier {
  double contact = 0, self_contact = 0, limit = 0;
};

/// What all rounds of one step have in common.
struct StepProgram {
  const world::Model& model;
  const StepInput& in;
  const StepOptions& options;
  const Eigen::VectorXd* guess;  ///< of δq (n_v); null: δq is not known
  const Analytic* smoothing;     ///< null: the step is exact
  Barrier barrier;

  bool with_derivatives() const { return options.with_A || options.with_B; }
};

StepProgram make_program(const world::Model& model, const StepInput& in, const Eigen::VectorXd* guess, const StepOptions& options);

/// How the rows of contacts are written.
struct RowRule {
  bool closed = false;     ///< contacts may slide without opening (Coulomb's law)
  double least_share = 0;  ///< the least share of σ that the point of a rim has (S.17); 1: the point counts as any other
};

/// Solves the program with the rows that the step may reach, adds rows that the solution violates, motors that saturate and joints that slide, and solves again.
/// @param iterations  counts those of the solver
/// @returns Solved | MaxIterations | the status of the solver; the solution is work.solution
core::Status solve_rounds(const StepProgram& program, const RowRule& rule, StepWorkspace::Impl& work, int& iterations);

/// The same for a smoothed step. Where the weights of rims lie too far apart for the solver, as in rare heaps of cylinders, the points of rims count as any other.
/// @param least_share  RowRule::least_share; becomes 1 where the points of rims count as any other
core::Status solve_smoothed(const StepProgram& program, double& least_share, StepWorkspace::Impl& work, int& iterations);

}  // namespace stiction::dynamics::detail
