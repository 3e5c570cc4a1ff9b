#include "contact_ticks.hpp"

#if __has_include(<proxsuite/proxqp/dense/dense.hpp>)
#include <chrono>
#include <proxsuite/proxqp/dense/dense.hpp>

namespace stiction::bench {
namespace {

using Eigen::Index;

struct Program {
  Eigen::MatrixXd H, A, C;
  Eigen::VectorXd g, b, lower, upper;
};

/// Unknowns x = (d, λ), d = q_cmd − q_cmd⁻.
Program make_program(const control::RobotLimits& robot, const ContactTick& t, const control::ContactQpOptions& options) {
  const Index n = t.q.size(), m = t.J_u.rows();
  const Eigen::VectorXd offset = t.q_cmd - t.q, wanted = t.q_ref - t.q_cmd;
  Program p;
  p.H = Eigen::MatrixXd::Zero(n + m, n + m);  // λ costs nothing: (C.4) fixes it
  p.H.topLeftCorner(n, n).diagonal().setConstant(1 + t.damping);
  p.g = Eigen::VectorXd::Zero(n + m);
  p.g.head(n) = -wanted;
  const Eigen::MatrixXd G = t.J_u * robot.stiffness.cwiseInverse().asDiagonal() * t.J_u.transpose();
  const Eigen::VectorXd least = Eigen::VectorXd::Constant(m, options.least_lever * options.least_lever / robot.stiffness.maxCoeff());
  const Eigen::VectorXd C = options.contact_compliance * G.diagonal().cwiseMax(least);
  p.A.resize(m, n + m);
  p.A << t.J_u, G + Eigen::MatrixXd(C.asDiagonal());
  p.b = C.cwiseProduct(t.lambda) - t.J_u * offset;
  p.C = Eigen::MatrixXd::Identity(n + m, n + m);
  p.lower.resize(n + m);
  p.upper.resize(n + m);
  p.lower.head(n) = (-robot.rate).cwiseMax(robot.lower - t.q_cmd);
  p.upper.head(n) = robot.rate.cwiseMin(robot.upper - t.q_cmd);
  const Eigen::VectorXd along = t.J_u * (t.q_ref - t.q);
  for (Index i = 0; i < m; ++i) p.lower[n + i] = options.unilateral && along[i] < 0 ? 0 : -1e20;
  p.upper.tail(m) = t.lambda_max;
  return p;
}

}  // namespace

std::optional<GeneralQp> time_general_qp(const control::RobotLimits& robot, const std::vector<ContactTick>& ticks,
                                         const control::ContactQpOptions& options, int repeat) {
  using Clock = std::chrono::steady_clock;
  GeneralQp out;
  if (ticks.empty()) return out;
  const Index n = ticks[0].q.size(), m = ticks[0].J_u.rows();
  proxsuite::proxqp::dense::QP<double> solver(n + m, m, n + m);
  solver.settings.eps_abs = 1e-6;
  solver.settings.eps_rel = 0;
  solver.settings.compute_timings = false;
  bool first = true;
  for (int r = 0; r < repeat; ++r)
    for (std::size_t k = 0; k < ticks.size(); ++k) {
      const Program p = make_program(robot, ticks[k], options);
      const auto start = Clock::now();
      if (first)
        solver.init(p.H, p.g, p.A, p.b, p.C, p.lower, p.upper);
      else
        solver.update(p.H, p.g, p.A, p.b, p.C, p.lower, p.upper);
      solver.solve();
      out.seconds.push_back(std::chrono::duration<double>(Clock::now() - start).count());
      first = false;
      if (r == 0 && solver.results.info.status != proxsuite::proxqp::QPSolverOutput::PROXQP_SOLVED) ++out.unsolved;
    }
  return out;
}

}  // namespace stiction::bench
#else
namespace stiction::bench {
std::optional<GeneralQp> time_general_qp(const control::RobotLimits&, const std::vector<ContactTick>&, const control::ContactQpOptions&,
                                         int) {
  return std::nullopt;
}
}  // namespace stiction::bench
#endif
