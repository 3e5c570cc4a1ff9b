#include "proxqp.hpp"

#include <proxsuite/proxqp/dense/dense.hpp>

namespace stiction::bench {

namespace proxqp = proxsuite::proxqp;

struct ProxQp::Impl {
  Impl(Eigen::Index n, Eigen::Index equations, Eigen::Index rows) : solver(n, equations, rows) {}
  proxqp::dense::QP<double> solver;
  bool first = true;
};

ProxQp::ProxQp(Eigen::Index n, Eigen::Index equations, Eigen::Index rows, const ProxQpOptions& options)
    : impl_(std::make_unique<Impl>(n, equations, rows)) {
  auto& settings = impl_->solver.settings;
  settings.eps_abs = options.residual;
  settings.eps_rel = 0;
  settings.max_iter = options.max_iterations;
  settings.compute_timings = false;
  if (options.warm_start) settings.initial_guess = proxqp::InitialGuessStatus::WARM_START_WITH_PREVIOUS_RESULT;
}
ProxQp::~ProxQp() = default;
ProxQp::ProxQp(ProxQp&&) noexcept = default;

bool ProxQp::solve(const QuadraticProgram& p) {
  using proxsuite::nullopt;
  auto& solver = impl_->solver;
  if (impl_->first && p.b.size() == 0)
    solver.init(p.H, p.g, nullopt, nullopt, p.C, p.lower, p.upper);
  else if (impl_->first)
    solver.init(p.H, p.g, p.A, p.b, p.C, p.lower, p.upper);
  else if (p.b.size() == 0)
    solver.update(p.H, p.g, nullopt, nullopt, p.C, p.lower, p.upper);
  else
    solver.update(p.H, p.g, p.A, p.b, p.C, p.lower, p.upper);
  impl_->first = false;
  solver.solve();
  return solver.results.info.status == proxqp::QPSolverOutput::PROXQP_SOLVED;
}

const Eigen::VectorXd& ProxQp::x() const { return impl_->solver.results.x; }

std::optional<Eigen::VectorXd> minimise_by_proxqp(const QuadraticProgram& program, const ProxQpOptions& options) {
  ProxQp solver(program.g.size(), program.b.size(), program.lower.size(), options);
  if (!solver.solve(program)) return std::nullopt;
  return solver.x();
}

}  // namespace stiction::bench
