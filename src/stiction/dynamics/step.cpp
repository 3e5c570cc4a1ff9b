#include "stiction/dynamics/step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/dynamics/active_set.hpp"
#include "stiction/dynamics/coulomb.hpp"
#include "stiction/dynamics/joint_friction.hpp"
#include "stiction/dynamics/nearby.hpp"
#include "stiction/dynamics/reach.hpp"
#include "stiction/dynamics/rim.hpp"
#include "stiction/dynamics/sample_step.hpp"
#include "stiction/dynamics/sweep.hpp"
#include "stiction/dynamics/working_set.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics {

using core::Overloaded;
using core::Status;
using world::Model;
using namespace detail;

Eigen::Matrix<double, 6, 1> calc_wrench(const ContactImpulse& c, double h) {
  const contact::Contact& geometry = c.contact;
  Eigen::Matrix<double, 6, 1> wrench;
  wrench.head<3>() = (geometry.nhat_BA_W * c.lambda[0] + geometry.t1_W * c.lambda[1] + geometry.t2_W * c.lambda[2]) / h;
  wrench.tail<3>() = geometry.p_WA.cross(wrench.head<3>()) + geometry.nhat_BA_W * (geometry.spin * c.lambda[2] / h);
  return wrench;
}

void StepOptions::validate() const {
  core::require_positive("h", h);
  core::require_nonnegative("friction_scale", friction_scale);
  core::require_nonnegative("contact_margin", contact_margin);
  core::require_positive("tol_complementarity", tol_complementarity);
  if (with_force_derivatives && !with_A && !with_B) core::throw_invalid("with_force_derivatives", "true", "with_A or with_B as well");
  std::visit(Overloaded{[](const Exact&) {},
                        [](const Analytic& a) {
                          core::require_positive("smoothing.kappa", a.kappa);
                          core::require_positive("smoothing.self_sharpness", a.self_sharpness);
                          core::require_positive("smoothing.limit_sharpness", a.limit_sharpness);
                        }},
             smoothing);
  std::visit(Overloaded{[](const ByRule& r) { core::require_positive("regularisation.ratio", r.ratio); },
                        [](const FixedEpsilon& f) { core::require_positive("regularisation.epsilon", f.epsilon); }},
             regularisation);
  const auto* pyramid = std::get_if<PolyhedralCone>(&friction_cone);
  if (pyramid != nullptr && (pyramid->rays < 3 || pyramid->rays > kMostRays)) {
    core::throw_invalid("friction_cone.rays", std::to_string(pyramid->rays), "a number in [3, " + std::to_string(kMostRays) + "]");
  }
}

StepWorkspace::StepWorkspace(std::shared_ptr<const Model> model) : impl_(std::make_unique<Impl>(std::move(model))) {}
StepWorkspace::~StepWorkspace() = default;
StepWorkspace::StepWorkspace(StepWorkspace&&) noexcept = default;
void StepWorkspace::forget() {
  impl_->solver->forget();
  impl_->q_seen.setConstant(std::numeric_limits<double>::quiet_NaN());  // NaN equals no q
}
const Model& StepWorkspace::model() const { return *impl_->model; }
namespace {

constexpr int kMaxLooks = 16;  // most searches along δq for contacts beyond contact_distance
/// Gap of bodies that overlap for good, in smoothed steps.
constexpr double kOverlapRoom = 0.1;  // share of the tolerance of contacts

void require_finite(std::string_view field, VectorRef value) {
  if (!value.allFinite()) core::throw_invalid(field, "a number that is not finite", "finite numbers");
}

void require_input(const Model& model, const StepInput& in) {
  core::require_size("q", in.q.size(), model.n_q());
  core::require_size("u", in.u.size(), model.n_a());
  require_finite("q", in.q);
  require_finite("u", in.u);
  if (in.tau_ext) core::require_size("tau_ext", in.tau_ext->size(), model.n_v());
  if (in.damping) {
    core::require_size("damping", in.damping->size(), model.n_v());
    for (const double d : *in.damping) core::require_nonnegative("damping", d);
  }
  if (in.friction) {
    core::require_size("friction", in.friction->size(), static_cast<Eigen::Index>(model.pairs().size()));
    if (!(in.friction->array() >= 0 && in.friction->array().isFinite()).all()) {  // there are hundreds
      for (const double factor : *in.friction) core::require_nonnegative("friction", factor);
    }
  }
}

void read_contacts(const Model& model, const StepOptions& options, StepWorkspace::Impl& work, std::vector<ContactImpulse>& out) {
  const cone::Result& s = work.solution;
  out.resize(work.contacts.size());
  Eigen::Index cone = 0;
  Eigen::Index half = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    ContactImpulse& c = out[i];
    c.contact = work.contacts[i];
    const double mu = c.contact.friction * options.friction_scale;
    if (!work.included[i]) {
      c.lambda.setZero();
      c.displacement = work.moved[i];
      c.gap = slack(work, row_gap(work, i), mu, c.displacement);
    } else if (!work.rays.empty()) {
      c.lambda.setZero();
      c.displacement = displacement(model, i, s.x, work);
      c.gap = std::numeric_limits<double>::infinity();
      for (const auto& d : work.rays) {
        c.lambda += s.z_half_line[half] * Eigen::Vector3d(1, mu * d.x(), mu * d.y());
        c.gap = std::min(c.gap, s.w_half_line[half++]);
      }
    } else if (mu == 0) {
      c.lambda = {s.z_half_line[half], 0, 0};
      c.displacement = displacement(model, i, s.x, work);
      c.gap = s.w_half_line[half++];
    } else {
      const auto w = s.w_cone.col(cone), z = s.z_cone.col(cone);
      const double shift = s.shift_cone[cone++];
      c.lambda = {z[0], mu * z[1], mu * z[2]};
      c.displacement = {w[0] - shift - row_gap(work, i), w[1] / mu, w[2] / mu};
      c.gap = w[0] - std::hypot(w[1], w[2]);
    }
    c.active = is_active(model, options, c.contact.pair, c.lambda[0], c.gap);
  }
}

Status solve_program(const StepProgram& program, StepWorkspace::Impl& work, double& least_share, int& iterations) {
  if (program.smoothing != nullptr) return solve_smoothed(program, least_share, work, iterations);
  return solve_by_law(program, work, iterations);
}

/// Solves the program of the known contacts, and solves it again with the contacts that the solution meets on its way.
/// @param least_share  RowRule::least_share of the last solution
Status solve_with_met(const StepProgram& program, double margin, StepWorkspace::Impl& work, double& least_share, int& iterations) {
  least_share = kLeastShare;
  Status status = solve_program(program, work, least_share, iterations);
  for (int looks = 0; status == Status::Solved && add_met(program.model, program.in, margin, work); ++looks) {
    if (looks == kMaxLooks) return Status::MaxIterations;
    status = solve_program(program, work, least_share, iterations);
  }
  return status;
}

/// Finds the contacts (only those within reach if the options say so) and solves the program.
/// @param fall  how far an object falls in the step if nothing holds it [m]
Status find_and_solve(const StepProgram& program, double fall, StepWorkspace::Impl& work, double& least_share, int& iterations) {
  const auto& [model, in, options, guess, smoothing, barrier] = program;
  const double margin = options.contact_margin;
  const bool within_reach =
      options.contacts_within_reach && smoothing == nullptr && guess == nullptr && !work.reach.pairs.empty() && !model.scene().max_contacts;
  if (within_reach) {
    guess_reach(model, in, options, margin, work);
    find_contacts(model, in, margin, fall, true, work);
    const Status status = solve_with_met(program, margin, work, least_share, iterations);
    if (status == Status::Solved && stays_within_reach(model, in, options, work)) return status;
    work.margin_seen = -1;
  }
  find_contacts(model, in, margin, fall, false, work);
  return solve_with_met(program, margin, work, least_share, iterations);
}

/// Solves the step again where no motion ends all overlaps: those within the tolerance of contacts may stay. A body between two others overlaps with
/// both in a simulation with soft contacts. A smoothed step needs room inside its constraints.
Status keep_overlaps(const StepProgram& program, double fall, StepWorkspace::Impl& work, double& least_share, int& iterations) {
  const double length = program.model.scales().robots().length;
  work.kept_gap = program.smoothing == nullptr ? 0 : kOverlapRoom * world::share::kContact * length;
  return find_and_solve(program, fall, work, least_share, iterations);
}

/// Fills the result of a step that was not solved: nothing moves.
void read_failure(const StepProgram& program, const StepWorkspace::Impl& work, StepResult& out) {
  const Model& model = program.model;
  out.q_next = program.in.q;
  out.delta.setZero(model.n_v());
  out.contacts.clear();
  out.torque.setZero(model.n_a());
  out.saturated.assign(static_cast<std::size_t>(model.n_a()), 0);
  out.joint_friction.setZero(work.friction_joints.empty() ? 0 : model.n_vu());
  if (program.options.with_A) out.A.setZero(model.n_v(), model.n_v());
  if (program.options.with_B) out.B.setZero(model.n_v(), model.n_a());
  out.D_lambda_q.resize(0, 0);
  out.D_lambda_u.resize(0, 0);
}

void differentiate(const StepProgram& program, double least_share, StepWorkspace::Impl& work, StepResult& out) {
  const SolvedStep solved{program.model, program.options,      work.kinematics,    work.J,           work.included, least_share < 1,
                          work.rays,     work.bound_variables, work.moving_bounds, work.motor_bound, work.Q,        *work.solver};
  linearise(solved, work.contact_work, work.linearisation, out);
}

/// Implements step() and sample_step(); `guess` is null for step().
Status solve_step(const Model& model, const StepInput& in, const Eigen::VectorXd* guess, const StepOptions& options,
                  StepWorkspace& workspace, StepResult& out) {
  options.validate();
  require_input(model, in);
  StepWorkspace::Impl& work = workspace.impl();
  set_rays(model, options, work.rays);
  if (is_coulomb(options) && !work.rays.empty())
    core::throw_invalid("friction_law", "coulomb", "anitescu for a planar model or a polyhedral cone");

  calc_kinematics(model, in.q, work);
  const double fall = calc_objective(model, in, options, work, out.epsilon);
  set_stiction(model, options, work);
  work.commanded.tail(model.n_a()) = in.u - in.q.tail(model.n_a());
  const StepProgram program = make_program(model, in, guess, options);
  const int growths = work.problem->growths();
  double least_share = 0;
  out.iterations = 0;
  work.kept_gap = -std::numeric_limits<double>::infinity();
  out.status = find_and_solve(program, fall, work, least_share, out.iterations);
  if (out.status == Status::Infeasible) out.status = keep_overlaps(program, fall, work, least_share, out.iterations);
  out.residuals = work.solution.residuals;
  out.growths = work.problem->growths() - growths;
  if (out.status != Status::Solved) {
    read_failure(program, work, out);
    return out.status;
  }

  out.delta = work.solution.x;
  out.q_next.resize(model.n_q());
  world::retract(model, in.q, out.delta, out.q_next);
  read_motors(model, in, options, work, out);
  read_friction(model, options, work, out);
  if (guess == nullptr || options.with_A) read_contacts(model, options, work, out.contacts);
  if (program.with_derivatives()) differentiate(program, least_share, work, out);
  return out.status;
}

}  // namespace

Status step(const Model& model, const StepInput& in, const StepOptions& options, StepWorkspace& workspace, StepResult& out) {
  if (&model != &workspace.model()) core::throw_invalid("work", "the workspace of another model", "one made for this model");
  return solve_step(model, in, nullptr, options, workspace, out);
}

Status detail::sample_step(const Model& model, const StepInput& in, const Eigen::VectorXd& guess, const StepOptions& options,
                           StepWorkspace& workspace, StepResult& out) {
  return solve_step(model, in, &guess, options, workspace, out);
}

}  // namespace stiction::dynamics
