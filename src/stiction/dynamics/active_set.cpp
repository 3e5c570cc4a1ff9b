#include "stiction/dynamics/active_set.hpp"

#include <algorithm>

#include "stiction/dynamics/coulomb.hpp"
#include "stiction/dynamics/joint_friction.hpp"
#include "stiction/dynamics/rim.hpp"
#include "stiction/dynamics/working_set.hpp"

namespace stiction::dynamics::detail {
namespace {

using core::Status;

constexpr int kMaxRounds = 12;  // the last round has all rows
/// Complementarity to which an exact step with A or B is centred [-]. With a smaller value the factor of H would lose the digits that B
/// needs, because the entries of H grow with λ²/σ.
constexpr double kSensitivityComplementarity = 1e-8;

cone::Options solver_options(const StepProgram& program, const RowRule& rule) {
  const StepOptions& options = program.options;
  const bool exact = program.smoothing == nullptr;
  cone::Options out;
  out.mode = exact ? cone::Mode::Exact : cone::Mode::Smoothed;
  out.tol_complementarity = exact && program.with_derivatives() ? std::max(options.tol_complementarity, kSensitivityComplementarity)
                                                                : options.tol_complementarity;
  out.warm_start = options.warm_start && !is_coulomb(options);  // the final shifts depend on the initial ones
  out.x_near = exact ? nullptr : program.guess;
  out.sensitivities = program.with_derivatives();
  out.shift_by_tangent = rule.closed;
  return out;
}

/// Chooses the rows of the first round; no motor is saturated and all joints with friction stick.
void start_rows(const StepProgram& program, const RowRule& rule, StepWorkspace::Impl& work) {
  const auto& [model, in, options, guess, smoothing, barrier] = program;
  work.included.resize(work.contacts.size());
  work.moved.resize(work.contacts.size());
  if (smoothing != nullptr)
    include_smoothed(model, in, options, smoothing->self_sharpness, rule.least_share, work);
  else if (guess == nullptr)
    include_within_reach(model, in, options, rule.closed, work);
  else
    include_near(model, in, options, *guess, work);
  include_met(work);
  std::ranges::fill(work.motor, static_cast<signed char>(0));
  for (FrictionJoint& joint : work.friction_joints) joint.side = 0;
}

void add_contacts(const StepProgram& program, const RowRule& rule, StepWorkspace::Impl& work) {
  const StepOptions& options = program.options;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    if (!work.included[i]) continue;
    const contact::Contact& contact = work.contacts[i];
    const bool self = work.self_contact[at(contact.pair)] != 0;
    const double share =
        program.smoothing == nullptr ? 1.0 : std::max(barrier_share(program.model, work.kinematics, contact), rule.least_share);
    const double part = contact.spin == 0 ? 1.0 : 0.5;  // two rows for one contact
    const double sigma = self ? program.barrier.self_contact : program.barrier.contact;
    add_contact(program.model, i, options.h, contact.friction * options.friction_scale, part * share * sigma, work);
  }
}

/// Writes the program of one round from the included rows.
void write_program(const StepProgram& program, const RowRule& rule, StepWorkspace::Impl& work) {
  const auto& [model, in, options, guess, smoothing, barrier] = program;
  cone::Problem& problem = *work.problem;
  problem.clear();
  work.bound_variables.clear();
  set_springs(model, in, options, work);
  set_friction(options, work);
  add_objective(work, options.h, problem);
  add_contacts(program, rule, work);
  for_each_limit(model, in, work, [&](int variable, double sign, double offset) {
    const std::uint64_t id = limit_id(variable, sign);
    if (!work.limit_included[id]) return;
    problem.add_bound(id, variable, sign, offset, program.barrier.limit, during(work.variable_unit[at(variable)], program.options.h));
    work.bound_variables.push_back(variable);
  });
  add_motors(model, in, options, work);
  work.moving_bounds = work.bound_variables.size();
  add_friction(options, work);
}

/// Adds violated rows, saturated motors and sliding joints for the next round. @returns true if anything was added
bool extend(const StepProgram& program, const RowRule& rule, StepWorkspace::Impl& work) {
  const bool rows = add_violated(program.model, program.in, program.options, rule.closed, work);
  const bool motors = program.options.effort_limits && saturate_motors(program.model, program.in, work);
  const bool slides = slide_joints(work);
  return rows || motors || slides;
}

}  // namespace

StepProgram make_program(const world::Model& model, const StepInput& in, const Eigen::VectorXd* guess, const StepOptions& options) {
  const auto* analytic = std::get_if<Analytic>(&options.smoothing);
  Barrier barrier;
  if (analytic != nullptr) {
    const double sigma = options.h / analytic->kappa;
    barrier = {sigma, sigma / analytic->self_sharpness, sigma / analytic->limit_sharpness};
  }
  return {model, in, options, guess, analytic, barrier};
}

Status solve_rounds(const StepProgram& program, const RowRule& rule, StepWorkspace::Impl& work, int& iterations) {
  const cone::Options options = solver_options(program, rule);
  const int last = kMaxRounds + 2 * (program.model.n_a() + static_cast<int>(work.friction_joints.size()));
  start_rows(program, rule, work);
  for (int round = 0;; ++round) {
    write_program(program, rule, work);
    const Status status = cone::solve(*work.problem, options, *work.solver, work.solution);
    iterations += work.solution.iterations;
    if (status != Status::Solved || !extend(program, rule, work)) return status;
    if (round == kMaxRounds - 2) include_all(program.options, work);
    if (round == last) return Status::MaxIterations;
  }
}

Status solve_smoothed(const StepProgram& program, double& least_share, StepWorkspace::Impl& work, int& iterations) {
  const Status status = solve_rounds(program, {.least_share = least_share}, work, iterations);
  if (status != Status::MaxIterations || least_share >= 1) return status;
  least_share = 1;
  return solve_rounds(program, {.least_share = least_share}, work, iterations);
}

}  // namespace stiction::dynamics::detail
