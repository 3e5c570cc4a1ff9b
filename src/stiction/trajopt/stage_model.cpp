#include "stiction/trajopt/stage_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stiction/core/number.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/core/random.hpp"
#include "stiction/dynamics/so3.hpp"

namespace stiction::trajopt {

using core::Status;
using Eigen::VectorXd;
using world::Model;

namespace {

/// Writes A and B, which map the tangent space at q̄_t to the tangent space at the exact q̄_{t+1}. The smoothed next state c differs from
/// q̄_{t+1}, so increments of free rotations are transported between the two in the world frame.
void fill_dynamics(const Model& model, const dynamics::LocalModel& local, VectorRef q_next, bool use_A, LqStage& stage) {
  const Eigen::Index n = model.n_v(), m = model.n_a();
  const bool solved = local.status == Status::Solved;
  if (solved && use_A) {
    stage.A = local.A;
  } else {
    stage.A.setZero(n, n);
    stage.A.topLeftCorner(model.n_vu(), model.n_vu()).setIdentity();
  }
  if (solved) {
    stage.B = local.B;
  } else {
    stage.B.setZero(n, m);
  }
  if (!solved || !use_A) stage.B.bottomRows(m).setIdentity();
  if (!solved) return;
  VectorXd offset(n);
  world::local(model, q_next, local.c, offset);
  dynamics::for_each_free_rotation(model, [&](int row) {
    const Eigen::Matrix3d carry = dynamics::exp_so3(offset.segment<3>(row));
    if (use_A) stage.A.middleRows<3>(row) = (carry * stage.A.middleRows<3>(row)).eval();
    stage.B.middleRows<3>(row) = (carry * stage.B.middleRows<3>(row)).eval();
  });
}

// ---- forces

/// Row μ λ_n − dᵀλ_t ≥ 0 of one contact, divided by its λ_n.
struct ForceRow {
  std::size_t contact;
  Eigen::RowVector3d weights;
};

/// Writes the rows (T.7) of the near contacts with a smoothed force.
std::vector<ForceRow> force_rows(const Model& model, const OptimizeOptions& options, const dynamics::StepResult& step) {
  const bool planar = model.planar_axis().has_value();
  const int rays = planar ? 2 : options.forces->rays;
  std::vector<ForceRow> out;
  for (std::size_t c = 0; c < step.contacts.size(); ++c) {
    const auto& contact = step.contacts[c];
    if (contact.contact.phi > options.forces->max_distance || !(contact.lambda[0] > 0)) continue;
    const double mu = contact.contact.friction * options.step.friction_scale * options.forces->friction;
    const int n = mu > 0 ? rays : 1;
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * M_PI * k / n;
      Eigen::RowVector3d row(mu, -std::cos(angle), -std::sin(angle));
      if (planar) row[2] = 0;
      if (!(mu > 0)) row = Eigen::RowVector3d::UnitX();
      row /= contact.lambda[0];
      if (row.dot(contact.lambda) > 0) out.push_back({c, row});
    }
  }
  return out;
}

void fill_rows(const Model& model, const std::vector<ForceRow>& rows, const dynamics::StepResult& step, LqStage& stage) {
  const auto k = static_cast<Eigen::Index>(rows.size());
  stage.Gx.resize(k, model.n_v()), stage.Gu.resize(k, model.n_a()), stage.g.resize(k);
  for (Eigen::Index i = 0; i < k; ++i) {
    const ForceRow& row = rows[static_cast<std::size_t>(i)];
    stage.Gx.row(i).noalias() = row.weights * step.D_lambda_q[row.contact];
    stage.Gu.row(i).noalias() = row.weights * step.D_lambda_u[row.contact];
    stage.g[i] = row.weights.dot(step.contacts[row.contact].lambda);
  }
}

/// Computes the analytic local model together with the derivatives of its forces.
void calc_with_forces(const Model& model, const NominalStep& nominal, const dynamics::Analytic& scheme, const OptimizeOptions& options,
                      StageModelWorkspace& work, LqStage& stage) {
  dynamics::StepOptions step_options = options.step;
  step_options.smoothing = scheme;
  step_options.with_A = step_options.with_B = step_options.with_force_derivatives = true;
  dynamics::StepResult& step = work.smooth;
  work.steps.forget();
  dynamics::LocalModel& local = work.local;
  local.status = dynamics::step(model, {nominal.q, nominal.u}, step_options, work.steps, step);
  if (local.status == Status::Solved) local.c = step.q_next, local.A = step.A, local.B = step.B;
  fill_rows(model, local.status == Status::Solved ? force_rows(model, options, step) : std::vector<ForceRow>{}, step, stage);
}

}  // namespace

dynamics::LocalModelScheme scheme_of(const OptimizeOptions& options, int i, std::size_t t, std::size_t T) {
  dynamics::LocalModelScheme out = options.scheme;
  const auto sharpen = [&](dynamics::Sampling& s) {
    const double share = std::pow(i + 1, -options.std_decay);
    s.std_u *= share, s.std_q *= share;
    s.seed = core::Random(s.seed, static_cast<std::uint64_t>(i) * T + t).bits();
  };
  std::visit(core::Overloaded{
                 [](dynamics::Exact&) {},
                 [&](dynamics::Analytic& s) { s.kappa = std::min(s.kappa * std::pow(options.kappa_growth, i), core::kLargestNumber); },
                 [&](dynamics::RandomizedFirstOrder& s) { sharpen(s); }, [&](dynamics::RandomizedZerothOrder& s) { sharpen(s); }},
             out);
  return out;
}

double sharpness(const dynamics::LocalModelScheme& scheme) {
  return std::visit(core::Overloaded{[](const dynamics::Exact&) { return 0.0; }, [](const dynamics::Analytic& s) { return s.kappa; },
                                     [](const dynamics::Sampling& s) { return s.std_u.maxCoeff(); }},
                    scheme);
}

Status calc_stage_model(const Model& model, const NominalStep& nominal, const dynamics::LocalModelScheme& scheme,
                        const OptimizeOptions& options, StageModelWorkspace& work, LqStage& stage) {
  if (options.forces) {
    calc_with_forces(model, nominal, std::get<dynamics::Analytic>(scheme), options, work, stage);
  } else {
    (void)dynamics::calc_local_model(model, {nominal.q, nominal.u}, scheme, options.step, options.use_A, work.models, work.local);
    fill_rows(model, {}, work.smooth, stage);
  }
  fill_dynamics(model, work.local, nominal.q_next, options.use_A, stage);
  return work.local.status;
}

}  // namespace stiction::trajopt
