#pragma once

#include "stiction/core/random.hpp"
#include "stiction/trajopt/box_lq.hpp"

namespace stiction::trajopt::test {

inline Eigen::MatrixXd random_matrix(core::Random& random, Eigen::Index rows, Eigen::Index cols) {
  Eigen::MatrixXd out(rows, cols);
  for (double& x : out.reshaped()) x = random.normal();
  return out;
}

/// Random problem with A near 1; boxes about 0 that hold back about half of the inputs; rows that hold at u = 0, x = 0 … or not.
inline BoxLqProblem random_problem(std::uint64_t seed, int n, int m, int T, int rows) {
  core::Random random(seed, 0);
  BoxLqProblem p;
  p.x0 = rows > 0 ? Eigen::VectorXd::Zero(n) : Eigen::VectorXd(random_matrix(random, n, 1));
  p.R = random_matrix(random, m, 1).cwiseAbs();
  if (seed % 5 == 0) p.R.setZero();
  for (int t = 0; t < T; ++t) {
    LqStage s;
    s.A = Eigen::MatrixXd::Identity(n, n) + 0.2 * random_matrix(random, n, n);
    s.B = random_matrix(random, n, m);
    const Eigen::MatrixXd L = random_matrix(random, n, std::max(1, n / 2));
    s.Q = L * L.transpose();
    s.q = random_matrix(random, n, 1);
    s.r = random_matrix(random, m, 1);
    const Eigen::VectorXd middle = 0.1 * random_matrix(random, m, 1), width = random_matrix(random, m, 1).cwiseAbs();
    s.lower = middle - 0.3 * width;
    s.upper = middle + 0.3 * width;
    s.Gx = random_matrix(random, rows, n);
    s.Gu = random_matrix(random, rows, m);
    // Holds with room at the middle of the boxes, where the program starts.
    s.g = random_matrix(random, rows, 1).cwiseAbs();
    p.stages.push_back(s);
  }
  if (rows > 0) {  // a point that satisfies everything: shift g by what the middle of the boxes needs
    Eigen::VectorXd x = p.x0;
    for (auto& s : p.stages) {
      const Eigen::VectorXd u = 0.5 * (s.lower + s.upper);
      s.g -= s.Gx * x + s.Gu * u;
      x = s.A * x + s.B * u;
    }
  }
  return p;
}

/// The same problem with the states eliminated: ½ uᵀHu + hᵀu + constant over all inputs in one vector, rows C u + c ≥ 0.
struct Condensed {
  Eigen::MatrixXd H, C;
  Eigen::VectorXd h, c, lower, upper;
  double constant = 0;

  explicit Condensed(const BoxLqProblem& p) {
    const auto n = p.x0.size(), m = p.R.size(), T = static_cast<Eigen::Index>(p.stages.size());
    const auto N = m * T;
    H.setZero(N, N), h.setZero(N), lower.resize(N), upper.resize(N);
    Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, N);  // x = S u + s
    Eigen::VectorXd s = p.x0;
    const auto k = p.stages[0].g.size();
    C.resize(k * T, N), c.resize(k * T);
    for (Eigen::Index t = 0; t < T; ++t) {
      const LqStage& d = p.stages[static_cast<std::size_t>(t)];
      Eigen::MatrixXd D = Eigen::MatrixXd::Zero(m, N);  // change = D u + r
      D.middleCols(t * m, m).setIdentity();
      C.middleRows(k * t, k) = d.Gx * S + d.Gu * D;
      c.segment(k * t, k) = d.Gx * s + d.g;
      Eigen::MatrixXd S_next = d.A * S + d.B * D;
      s = d.A * s;
      S = S_next;
      H += S.transpose() * d.Q * S;
      h += S.transpose() * (d.Q * s + d.q);
      constant += 0.5 * s.dot(d.Q * s) + d.q.dot(s);
      if (t > 0) D.middleCols((t - 1) * m, m) = -Eigen::MatrixXd::Identity(m, m);
      H += D.transpose() * p.R.asDiagonal() * D;
      h += D.transpose() * p.R.cwiseProduct(d.r);
      constant += 0.5 * d.r.dot(p.R.cwiseProduct(d.r));
      lower.segment(t * m, m) = d.lower, upper.segment(t * m, m) = d.upper;
    }
  }
  double cost(const Eigen::VectorXd& u) const { return 0.5 * u.dot(H * u) + h.dot(u) + constant; }
};

inline Eigen::VectorXd stacked(const std::vector<Eigen::VectorXd>& u) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(u.size()) * u[0].size());
  for (std::size_t t = 0; t < u.size(); ++t) out.segment(static_cast<Eigen::Index>(t) * u[0].size(), u[0].size()) = u[t];
  return out;
}

}  // namespace stiction::trajopt::test
