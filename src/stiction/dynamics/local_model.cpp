#include "stiction/dynamics/local_model.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/core/random.hpp"
#include "stiction/dynamics/sample_step.hpp"
#include "stiction/dynamics/so3.hpp"

namespace stiction::dynamics {
namespace {

using core::Overloaded;
using core::Status;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using world::Model;

struct Sample {
  VectorXd w_q, w_u;  // disturbance
  VectorXd q, u;      // disturbed point
  VectorXd guess;     // approximate δq at the disturbed point
  StepResult step;
  VectorXd r;  // difference of q_next from the nominal q_next
};

void require_std(const char* field, const VectorXd& std, Eigen::Index size) {
  if (std.size() != 1) core::require_size(field, std.size(), size);
  for (const double s : std) core::require_nonnegative(field, s);
}

void validate_sampling(const Model& model, const Sampling& s) {
  require_std("std_q", s.std_q, model.n_v());
  require_std("std_u", s.std_u, model.n_a());
  if (s.std_q.maxCoeff() == 0 && s.std_u.maxCoeff() == 0) core::throw_invalid("std_u", "0, and std_q too", "a disturbance");
  if (s.samples < 1) core::throw_invalid("samples", std::to_string(s.samples), "at least 1");
}

double entry(const VectorXd& std, Eigen::Index i) { return std.size() == 1 ? std[0] : std[i]; }

/// Draws std · normal(). If std is 0, the function still consumes the two random numbers of a normal draw.
double draw(double std, core::Random& random) {
  if (std > 0) return std * random.normal();
  random.bits(), random.bits();
  return 0;
}

}  // namespace

struct LocalModelWorkspace::Impl {
  Impl(std::shared_ptr<const Model> model, int threads) : pool(threads) {
    for (int i = 0; i < threads; ++i) steps.emplace_back(model);
  }
  core::ThreadPool pool;
  std::vector<StepWorkspace> steps;  // one per thread
  std::vector<Sample> samples;
  StepResult nominal;
};

LocalModelWorkspace::LocalModelWorkspace(std::shared_ptr<const Model> model, int threads)
    : impl_(std::make_unique<Impl>(std::move(model), threads)) {}
LocalModelWorkspace::~LocalModelWorkspace() = default;
LocalModelWorkspace::LocalModelWorkspace(LocalModelWorkspace&&) noexcept = default;

namespace {

/// Computes exact steps from all disturbed points. Sample i depends on the seed and on i alone. If only u is disturbed, the nominal step
/// and its B predict which contacts a sample comes near.
void calc_samples(const Model& model, const StepInput& in, const Sampling& sampling, const StepOptions& options,
                  const core::RunControl& control, LocalModelWorkspace::Impl& work) {
  work.samples.resize(static_cast<std::size_t>(sampling.samples));
  const bool same_q = sampling.std_q.maxCoeff() == 0;
  work.pool.run(sampling.samples, [&](int item, int worker) {
    Sample& s = work.samples[static_cast<std::size_t>(item)];
    if (control.stop()) {
      s.step.status = control.status_when_stopped();
      return;
    }
    core::Random random(sampling.seed, static_cast<std::uint64_t>(item));
    s.w_q.resize(model.n_v());
    s.w_u.resize(model.n_a());
    for (Eigen::Index i = 0; i < s.w_q.size(); ++i) s.w_q[i] = draw(entry(sampling.std_q, i), random);
    for (Eigen::Index i = 0; i < s.w_u.size(); ++i) s.w_u[i] = draw(entry(sampling.std_u, i), random);
    s.q.resize(model.n_q());
    world::retract(model, in.q, s.w_q, s.q);
    s.u = in.u + s.w_u;
    const StepInput disturbed{s.q, s.u, in.tau_ext, in.damping, in.friction};
    StepWorkspace& step_work = work.steps[static_cast<std::size_t>(worker)];
    if (same_q) {
      s.guess = work.nominal.delta;
      s.guess.noalias() += work.nominal.B * s.w_u;
      s.step.status = detail::sample_step(model, disturbed, s.guess, options, step_work, s.step);
    } else {
      s.step.status = step(model, disturbed, options, step_work, s.step);
    }
  });
}

/// Computes c of (2.22c), the mean of q_next in the tangent space at q_ref (in two passes), and r = q_next ⊖ c of every sample.
void calc_mean(const Model& model, const VectorXd& q_ref, LocalModelWorkspace::Impl& work, LocalModel& out) {
  out.c = q_ref;
  VectorXd mean(model.n_v());
  for (int pass = 0; pass < 2; ++pass) {
    mean.setZero();
    int n = 0;
    for (auto& s : work.samples) {
      if (s.step.status != Status::Solved) continue;
      s.r.resize(model.n_v());
      world::local(model, out.c, s.step.q_next, s.r);
      mean += s.r;
      ++n;
    }
    mean /= n;
    world::retract(model, out.c, mean, out.c);
  }
  for (auto& s : work.samples) {
    if (s.step.status == Status::Solved) world::local(model, out.c, s.step.q_next, s.r);
  }
}

/// (2.22a, b) with the transports of (S.11): D_r_q_next = J_r(r)⁻¹ at the end, exp(w)ᵀ at the start.
void average_derivatives(const Model& model, bool with_A, LocalModelWorkspace::Impl& work, LocalModel& out) {
  if (with_A) out.A.setZero(model.n_v(), model.n_v());
  out.B.setZero(model.n_v(), model.n_a());
  int n = 0;
  for (auto& s : work.samples) {
    if (s.step.status != Status::Solved) continue;
    ++n;
    for_each_free_rotation(model, [&](int row) {
      const Eigen::Matrix3d back = right_jacobian(s.r.segment<3>(row)).inverse();
      if (with_A) {
        s.step.A.middleCols<3>(row) = (s.step.A.middleCols<3>(row) * exp_so3(s.w_q.segment<3>(row)).transpose()).eval();
        s.step.A.middleRows<3>(row) = (back * s.step.A.middleRows<3>(row)).eval();
      }
      s.step.B.middleRows<3>(row) = (back * s.step.B.middleRows<3>(row)).eval();
    });
    if (with_A) out.A += s.step.A;
    out.B += s.step.B;
  }
  if (with_A) out.A /= n;
  out.B /= n;
}

/// Indices of the disturbed coordinates of w = (w_q, w_u).
std::vector<int> disturbed(const Model& model, const Sampling& sampling) {
  std::vector<int> out;
  for (int i = 0; i < model.n_v(); ++i) {
    if (entry(sampling.std_q, i) > 0) out.push_back(i);
  }
  for (int i = 0; i < model.n_a(); ++i) {
    if (entry(sampling.std_u, i) > 0) out.push_back(model.n_v() + i);
  }
  return out;
}

/// Checks the extra conditions of the least-squares fit before any step is computed.
void validate_fit(const Model& model, const Sampling& sampling, bool with_A) {
  if (with_A && !(sampling.std_q.minCoeff() > 0)) core::throw_invalid("std_q", "0", "greater than 0 for A by least squares");
  const std::size_t unknowns = disturbed(model, sampling).size();
  if (sampling.samples < static_cast<int>(unknowns))
    core::throw_invalid("samples", std::to_string(sampling.samples), "at least " + std::to_string(unknowns) + ", one per unknown");
}

/// (2.23): min Σ ‖r − A w_q − B w_u‖², by QR. Undisturbed coordinates get no column.
Status fit(const Model& model, const Sampling& sampling, bool with_A, LocalModelWorkspace::Impl& work, LocalModel& out) {
  const std::vector<int> columns = disturbed(model, sampling);
  const auto n = static_cast<Eigen::Index>(work.samples.size()) - out.failed;
  if (n < static_cast<Eigen::Index>(columns.size())) return Status::NumericalFailure;
  MatrixXd W(n, static_cast<Eigen::Index>(columns.size())), R(n, model.n_v());
  Eigen::Index i = 0;
  for (const auto& s : work.samples) {
    if (s.step.status != Status::Solved) continue;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const int c = columns[k];
      W(i, static_cast<Eigen::Index>(k)) = c < model.n_v() ? s.w_q[c] : s.w_u[c - model.n_v()];
    }
    R.row(i++) = s.r.transpose();
  }
  const MatrixXd X = W.colPivHouseholderQr().solve(R);
  if (with_A) out.A.setZero(model.n_v(), model.n_v());
  out.B.setZero(model.n_v(), model.n_a());
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const int c = columns[k];
    if (c >= model.n_v())
      out.B.col(c - model.n_v()) = X.row(static_cast<Eigen::Index>(k)).transpose();
    else if (with_A)
      out.A.col(c) = X.row(static_cast<Eigen::Index>(k)).transpose();
  }
  return Status::Solved;
}

Status randomized(const Model& model, const StepInput& in, const Sampling& sampling, bool first_order, StepOptions options, bool with_A,
                  const core::RunControl& control, LocalModelWorkspace::Impl& work, LocalModel& out) {
  validate_sampling(model, sampling);
  if (!first_order) validate_fit(model, sampling, with_A);
  options.smoothing = Exact{};
  options.with_A = false;
  options.with_B = true;
  options.with_force_derivatives = false;
  options.warm_start = false;  // a sample must not depend on earlier samples of its workspace
  const Status status = step(model, in, options, work.steps[0], work.nominal);
  if (status != Status::Solved) return status;
  options.with_A = first_order && with_A;
  options.with_B = first_order;
  calc_samples(model, in, sampling, options, control, work);
  if (control.stop()) return control.status_when_stopped();
  for (const auto& s : work.samples) out.failed += s.step.status == Status::Solved ? 0 : 1;
  if (out.failed == sampling.samples) return Status::NumericalFailure;
  calc_mean(model, work.nominal.q_next, work, out);
  if (!first_order) return fit(model, sampling, with_A, work, out);
  average_derivatives(model, with_A, work, out);
  return Status::Solved;
}

Status single_step(const Model& model, const StepInput& in, const Smoothing& smoothing, StepOptions options, bool with_A,
                   LocalModelWorkspace::Impl& work, LocalModel& out) {
  options.smoothing = smoothing;
  options.with_A = with_A;
  options.with_B = true;
  options.with_force_derivatives = false;
  options.warm_start = false;
  const Status status = step(model, in, options, work.steps[0], work.nominal);
  out.c = work.nominal.q_next;
  out.B = work.nominal.B;
  if (with_A) out.A = work.nominal.A;
  return status;
}

}  // namespace

void validate(const Model& model, const LocalModelScheme& scheme, bool with_A) {
  std::visit(Overloaded{[](const Exact&) {}, [](const Analytic& s) { StepOptions{.smoothing = s}.validate(); },
                        [&](const RandomizedFirstOrder& s) { validate_sampling(model, s); },
                        [&](const RandomizedZerothOrder& s) {
                          validate_sampling(model, s);
                          validate_fit(model, s, with_A);
                        }},
             scheme);
}

Status calc_local_model(const Model& model, const StepInput& in, const LocalModelScheme& scheme, const StepOptions& given, bool with_A,
                        LocalModelWorkspace& workspace, LocalModel& out, const core::RunControl& control) {
  LocalModelWorkspace::Impl& work = workspace.impl();
  StepOptions options = given;
  options.friction_law = FrictionLaw::Anitescu;
  out.failed = 0;
  out.status = std::visit(
      Overloaded{[&](const Exact& s) { return single_step(model, in, s, options, with_A, work, out); },
                 [&](const Analytic& s) { return single_step(model, in, s, options, with_A, work, out); },
                 [&](const RandomizedFirstOrder& s) { return randomized(model, in, s, true, options, with_A, control, work, out); },
                 [&](const RandomizedZerothOrder& s) { return randomized(model, in, s, false, options, with_A, control, work, out); }},
      scheme);
  if (out.status != Status::Solved) {
    out.c = in.q;
    if (with_A) out.A.setZero(model.n_v(), model.n_v());
    out.B.setZero(model.n_v(), model.n_a());
  }
  return out.status;
}

}  // namespace stiction::dynamics
