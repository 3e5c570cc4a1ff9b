#include "stiction/trajopt/riccati.hpp"

namespace stiction::trajopt {
namespace {

using Stage = BoxLqWorkspace::Stage;

void add_rows(const LqStage& d, BoxLqWorkspace& work, Stage& s) {
  if (d.g.size() == 0) return;
  const auto weights = s.y_row.cwiseQuotient(s.s_row);
  work.weighted_x = weights.asDiagonal() * d.Gx;
  work.weighted_u = weights.asDiagonal() * d.Gu;
  s.P_xx.noalias() += d.Gx.transpose() * work.weighted_x;
  s.W_xu.noalias() += d.Gx.transpose() * work.weighted_u;
  s.H.noalias() += d.Gu.transpose() * work.weighted_u;
}

/// Computes the linear terms of the cost to go, in increments from the current point: absolute inputs would lose the digits of small
/// slacks.
void backward(const BoxLqProblem& problem, BoxLqWorkspace& work) {
  work.costate.setZero(problem.x0.size());  // linear terms of the cost to go in x_{t+1} (costate) and u_t (u_before)
  work.u_before.setZero(problem.R.size());
  for (std::size_t t = problem.stages.size(); t-- > 0;) {
    const LqStage& d = problem.stages[t];
    Stage& s = work.stages[t];
    work.costate += d.q;
    work.costate.noalias() += d.Q * s.x_next;
    change(problem, work, t, work.change);
    s.k = work.u_before + problem.R.cwiseProduct(work.change);
    s.k -= s.center_lower.cwiseQuotient(s.s_lower) - s.center_upper.cwiseQuotient(s.s_upper);
    s.k.noalias() += d.B.transpose() * work.costate;
    s.p_x.noalias() = d.A.transpose() * work.costate;
    if (d.g.size() > 0) {
      row_value(problem, work, t, work.row);
      work.row = (s.y_row.cwiseProduct(work.row - s.s_row) - s.center_row).cwiseQuotient(s.s_row);
      s.k.noalias() += d.Gu.transpose() * work.row;
      s.p_x.noalias() += d.Gx.transpose() * work.row;
    }
    s.llt.solveInPlace(s.k);
    s.k = -s.k;
    s.p_x.noalias() += s.W_xu * s.k;
    work.u_before = -problem.R.cwiseProduct(work.change + s.k);
    work.costate = s.p_x;
  }
}

void forward(const BoxLqProblem& problem, BoxLqWorkspace& work) {
  work.x.setZero(problem.x0.size());
  work.u_before.setZero(problem.R.size());
  for (std::size_t t = 0; t < problem.stages.size(); ++t) {
    const LqStage& d = problem.stages[t];
    Stage& s = work.stages[t];
    s.du = s.k;
    s.du.noalias() += s.gains.K_x * work.x;
    s.du.noalias() += s.gains.K_u * work.u_before;
    if (d.g.size() > 0) {
      row_value(problem, work, t, s.ds_row);
      s.ds_row -= s.s_row;
      s.ds_row.noalias() += d.Gx * work.x;
      s.ds_row.noalias() += d.Gu * s.du;
    }
    s.dx_next.noalias() = d.A * work.x;
    s.dx_next.noalias() += d.B * s.du;
    work.x = s.dx_next;
    work.u_before = s.du;
  }
}

}  // namespace

bool factorise(const BoxLqProblem& problem, BoxLqWorkspace& work) {
  const Eigen::Index n = problem.x0.size(), m = problem.R.size();
  for (std::size_t t = problem.stages.size(); t-- > 0;) {
    const LqStage& d = problem.stages[t];
    Stage& s = work.stages[t];
    s.S_xx = d.Q;
    if (t + 1 < problem.stages.size()) {
      const Stage& next = work.stages[t + 1];
      s.S_xx += next.P_xx;
      s.S_xu = next.P_xu, s.S_uu = next.P_uu;
    } else {
      s.S_xu.setZero(n, m), s.S_uu.setZero(m, m);
    }
    s.M = s.S_xu;
    s.M.noalias() += s.S_xx * d.B;
    s.W_xu.noalias() = d.A.transpose() * s.M;
    s.H = s.S_uu;
    s.H.noalias() += d.B.transpose() * s.M;
    s.H.noalias() += s.S_xu.transpose() * d.B;
    work.S_A.noalias() = s.S_xx * d.A;
    s.P_xx.noalias() = d.A.transpose() * work.S_A;
    add_rows(d, work, s);
    for (Eigen::Index i = 0; i < m; ++i) {
      s.H(i, i) += problem.R[i] + s.z_lower[i] / s.s_lower[i] + s.z_upper[i] / s.s_upper[i];
    }
    s.llt.compute(s.H);
    if (s.llt.info() != Eigen::Success) return false;
    s.gains.K_x = -s.W_xu.transpose();
    s.llt.solveInPlace(s.gains.K_x);
    s.gains.K_u = problem.R.asDiagonal().toDenseMatrix();
    s.llt.solveInPlace(s.gains.K_u);
    s.P_xx.noalias() += s.W_xu * s.gains.K_x;
    s.P_xu.noalias() = s.W_xu * s.gains.K_u;
    s.P_uu = -(problem.R.asDiagonal() * s.gains.K_u);
    s.P_uu.diagonal() += problem.R;
  }
  return true;
}

void calc_newton_step(const BoxLqProblem& problem, BoxLqWorkspace& work) {
  backward(problem, work);
  forward(problem, work);
}

}  // namespace stiction::trajopt
