#pragma once

#include "stiction/dynamics/program.hpp"

// Internal to the layer: rounds that choose the rows of (2.6) and solve the program, until the solution violates no row that was left out.

namespace stiction::dynamics::detail {

/// Barrier weights σ of a smoothed step [J·s]; all are 0 in an exact step.
struct Barrier {
  double contact = 0, self_contact = 0, limit = 0;
};

/// Data shared by all rounds of one step.
struct StepProgram {
  const world::Model& model;
  const StepInput& in;
  const StepOptions& options;
  const Eigen::VectorXd* guess;  ///< approximate δq (n_v); null: not known
  const Analytic* smoothing;     ///< null: the step is exact
  Barrier barrier;

  bool with_derivatives() const { return options.with_A || options.with_B; }
};

StepProgram make_program(const world::Model& model, const StepInput& in, const Eigen::VectorXd* guess, const StepOptions& options);

/// How the rows of contacts are written.
struct RowRule {
  bool closed = false;     ///< contacts may slide without opening (Coulomb's law)
  double least_share = 0;  ///< smallest share of σ of a rim point (S.17); 1: the point counts as any other
};

/// Solves the program with the rows that the step may reach. Then adds violated rows, saturated motors and sliding joints, and solves again
/// until there are no more.
/// @param iterations  incremented by the solver iterations
/// @returns Solved | MaxIterations | the status of the solver; the solution is work.solution
core::Status solve_rounds(const StepProgram& program, const RowRule& rule, StepWorkspace::Impl& work, int& iterations);

/// Does the same for a smoothed step. In rare heaps of cylinders the weights of rim points differ too much for the solver. Rim points then
/// count as any other point.
/// @param least_share  RowRule::least_share; set to 1 if rim points had to count as any other point
core::Status solve_smoothed(const StepProgram& program, double& least_share, StepWorkspace::Impl& work, int& iterations);

}  // namespace stiction::dynamics::detail
