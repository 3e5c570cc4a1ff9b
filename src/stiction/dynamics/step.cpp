#include "stiction/dynamics/step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/dynamics/joint_friction.hpp"
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
  wrench.tail<3>() = geometry.p_WA.cross(wrench.head<3>());
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
  impl_->q_seen.setConstant(std::numeric_limits<double>::quiet_NaN());  // no q is that
}
const Model& StepWorkspace::model() const { return *impl_->model; }
namespace {

constexpr int kMaxRounds = 12;  // the last one has all rows
constexpr int kMaxLooks = 16;   // at what is farther than contact_distance
/// Complementarity to which an exact step with A or B is centred [-]: sharper, the factor of H loses the digits that B needs, since its
/// entries grow with λ²/σ.
constexpr double kSensitivityComplementarity = 1e-8;

bool is_coulomb(const StepOptions& options) {
  return options.friction_law == FrictionLaw::Coulomb && std::holds_alternative<Exact>(options.smoothing);
}

/// A pair touches or overlaps, and its gap changes with no coordinate: the first row of its Jacobian is rounding beside the others. No force can act across it,
/// and an overlap that nothing undoes is no reason for a step to be infeasible.
bool has_fixed_gap(const Model& model, const StepWorkspace::Impl& work, std::size_t i) {
  constexpr double kRounding = 1e-12;
  if (work.contacts[i].phi > model.scales().contact_tolerance(work.contacts[i].pair)) return false;
  const auto support = at(model.pairs()[at(work.contacts[i].pair)].support);
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3>> J(jacobian(work, i),
                                                                     static_cast<Eigen::Index>(model.supports()[support].size()), 3);
  return J.col(0).lpNorm<Eigen::Infinity>() <= kRounding * J.lpNorm<Eigen::Infinity>();
}

/// @param near  distances from which on pairs are left out, or nothing
void find_contacts(const Model& model, double margin, std::span<const double> near, StepWorkspace::Impl& work) {
  contact::query(model, work.kinematics, {.margin = margin, .near = near}, work.contact_work, work.contacts);
  contact::calc_jacobians(model, work.kinematics, work.contacts, work.contact_work, work.J);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < work.contacts.size(); ++i) {
    if (has_fixed_gap(model, work, i)) continue;
    if (kept != i) work.contacts[kept] = work.contacts[i];
    ++kept;
  }
  if (kept == work.contacts.size()) return;
  work.contacts.resize(kept);
  contact::calc_jacobians(model, work.kinematics, work.contacts, work.contact_work, work.J);
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
      c.gap = slack(work, c.contact.phi, mu, c.displacement);
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
      c.displacement = {w[0] - shift - c.contact.phi, w[1] / mu, w[2] / mu};
      c.gap = w[0] - std::hypot(w[1], w[2]);
    }
    c.active = c.lambda[0] > options.h * world::share::kActive * model.scales().pair(c.contact.pair).force;
  }
}

/// step() and sample_step(): `guess` may be null.
Status solve_step(const Model& model, const StepInput& in, const Eigen::VectorXd* guess, const StepOptions& options,
                  StepWorkspace& workspace, StepResult& out) {
  options.validate();
  core::require_size("q", in.q.size(), model.n_q());
  core::require_size("u", in.u.size(), model.n_a());
  if (!in.q.allFinite()) core::throw_invalid("q", "a number that is not finite", "finite numbers");
  if (!in.u.allFinite()) core::throw_invalid("u", "a number that is not finite", "finite numbers");
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

  StepWorkspace::Impl& work = workspace.impl();
  const auto* analytic = std::get_if<Analytic>(&options.smoothing);

  set_rays(model, options, work.rays);
  if (is_coulomb(options) && !work.rays.empty())
    core::throw_invalid("friction_law", "coulomb", "anitescu for a planar model or a polyhedral cone");
  if (work.q_seen.size() == 0 || work.q_seen != in.q) {
    world::calc_kinematics(model, in.q, work.kinematics_work, work.kinematics);
    work.q_seen = in.q;
    work.margin_seen = -1;
  }
  const double fall = calc_objective(model, in, options, work, out.epsilon);
  set_stiction(model, options, work);

  // An unsupported object must not fall through what it would have met: look as far as it can fall.
  const double margin = options.contact_margin + std::max(0.0, fall - model.scene().contact_distance);
  const auto look = [&](std::span<const double> near) {
    if (work.margin_seen != margin) {
      find_contacts(model, margin, near, work);
      work.margin_seen = margin;
      work.near_contacts = work.contacts.size();
    }
    if (in.friction)
      for (auto& contact : work.contacts) contact.friction *= (*in.friction)[contact.pair];
    if (in.friction || !near.empty()) work.margin_seen = -1;  // no other step takes these over
  };

  const bool exact = analytic == nullptr;
  const bool derivatives = options.with_A || options.with_B;
  const double sigma = exact ? 0.0 : options.h / analytic->kappa;
  const double sigma_self = exact ? 0.0 : sigma / analytic->self_sharpness;
  const double sigma_limit = exact ? 0.0 : sigma / analytic->limit_sharpness;
  work.commanded.tail(model.n_a()) = in.u - in.q.tail(model.n_a());
  const bool within_reach =
      options.contacts_within_reach && exact && guess == nullptr && !work.reach.pairs.empty() && !model.scene().max_contacts;
  if (within_reach) guess_reach(model, in, options, margin, work);
  look(within_reach ? std::span<const double>(work.reach.near) : std::span<const double>());

  cone::Options solver_options;
  solver_options.mode = exact ? cone::Mode::Exact : cone::Mode::Smoothed;
  solver_options.tol_complementarity =
      exact && derivatives ? std::max(options.tol_complementarity, kSensitivityComplementarity) : options.tol_complementarity;
  const bool coulomb = is_coulomb(options);
  solver_options.warm_start = options.warm_start && !coulomb;  // where the shifts end depends on where they start
  solver_options.sensitivities = derivatives;
  out.iterations = 0;
  const int growths = work.problem->growths();
  const auto solve_rounds = [&] {
    work.included.resize(work.contacts.size());
    work.moved.resize(work.contacts.size());
    if (!exact)
      include_smoothed(model, in, options, analytic->self_sharpness, work);
    else if (guess == nullptr)
      include_within_reach(model, in, options, solver_options.shift_by_tangent, work);
    else
      include_near(model, in, options, *guess, work);
    include_met(work);
    std::ranges::fill(work.motor, static_cast<signed char>(0));
    for (FrictionJoint& joint : work.friction_joints) joint.side = 0;
    for (int round = 0;; ++round) {
      cone::Problem& problem = *work.problem;
      problem.clear();
      work.bound_variables.clear();
      set_springs(model, in, options, work);
      set_friction(options, work);
      add_objective(work, options.h, problem);
      for (std::size_t i = 0; i < work.contacts.size(); ++i) {
        if (!work.included[i]) continue;
        const contact::Contact& contact = work.contacts[i];
        const bool self = work.self_contact[static_cast<std::size_t>(contact.pair)] != 0;
        const double share = exact ? 1.0 : std::max(barrier_share(model, work.kinematics, contact), work.least_share);
        add_contact(model, i, options.h, contact.friction * options.friction_scale, share * (self ? sigma_self : sigma), work);
      }
      for_each_limit(model, in, [&](int variable, double sign, double offset) {
        const std::uint64_t id = limit_id(variable, sign);
        if (!work.limit_included[id]) return;
        problem.add_bound(id, variable, sign, offset, sigma_limit, during(work.variable_unit[at(variable)], options.h));
        work.bound_variables.push_back(variable);
      });
      add_motors(model, in, options, work);
      work.moving_bounds = work.bound_variables.size();
      add_friction(options, work);
      out.status = cone::solve(problem, solver_options, *work.solver, work.solution);
      out.iterations += work.solution.iterations;
      if (out.status != Status::Solved) break;
      const bool rows = add_violated(model, in, options, solver_options.shift_by_tangent, work);
      const bool motors = options.effort_limits && saturate_motors(model, in, work);
      const bool slides = slide_joints(work);
      if (!rows && !motors && !slides) break;
      if (round == kMaxRounds - 2) include_all(options, work);
      if (round == kMaxRounds + 2 * (model.n_a() + static_cast<int>(work.friction_joints.size()))) {
        out.status = Status::MaxIterations;
        break;
      }
    }
  };
  const auto solve_program = [&] {
    solver_options.shift_by_tangent = coulomb;
    solve_rounds();
    if (!exact && out.status == Status::MaxIterations && work.least_share < 1) {  // σ of rows too far apart: rare heaps of cylinders
      work.least_share = 1;
      solve_rounds();
    }
    if (!coulomb || (out.status == Status::Solved && !misses_contact(model, options, work))) return;
    solver_options.shift_by_tangent = false;
    solve_rounds();  // from the rows it would start with by itself: Anitescu's step to the last digit
  };
  const auto solve_to_the_end = [&] {
    work.least_share = kLeastShare;
    solve_program();
    for (int looks = 0; out.status == Status::Solved && add_met(model, in, margin, work); ++looks) {
      if (looks < kMaxLooks)
        solve_program();
      else
        out.status = Status::MaxIterations;
    }
  };
  solve_to_the_end();
  if (within_reach && !(out.status == Status::Solved && stays_within_reach(model, in, options, work))) {
    work.margin_seen = -1;
    look({});
    solve_to_the_end();
  }
  out.residuals = work.solution.residuals;
  out.growths = work.problem->growths() - growths;
  if (out.status != Status::Solved) {
    out.q_next = in.q;
    out.delta.setZero(model.n_v());
    out.contacts.clear();
    out.torque.setZero(model.n_a());
    out.saturated.assign(static_cast<std::size_t>(model.n_a()), 0);
    out.joint_friction.setZero(work.friction_joints.empty() ? 0 : model.n_vu());
    if (options.with_A) out.A.setZero(model.n_v(), model.n_v());
    if (options.with_B) out.B.setZero(model.n_v(), model.n_a());
    out.D_lambda_q.resize(0, 0);
    out.D_lambda_u.resize(0, 0);
    return out.status;
  }
  out.delta = work.solution.x;
  out.q_next.resize(model.n_q());
  world::retract(model, in.q, out.delta, out.q_next);
  read_motors(model, in, options, work, out);
  read_friction(model, options, work, out);
  if (guess == nullptr || options.with_A) read_contacts(model, options, work, out.contacts);
  if (derivatives) {
    const detail::SolvedStep solved{model,
                                    options,
                                    work.kinematics,
                                    work.J,
                                    work.included,
                                    work.least_share < 1,
                                    work.rays,
                                    work.bound_variables,
                                    work.moving_bounds,
                                    work.motor_bound,
                                    work.Q,
                                    *work.solver};
    detail::linearise(solved, work.contact_work, work.linearisation, out);
  }
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
