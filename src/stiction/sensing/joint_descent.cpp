#include "stiction/sensing/joint_descent.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace stiction::sensing {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

const SensedLink& link_of(const JointProblem& problem, const ContactPoint& point) { return problem.sensor.links()[at(point.link)]; }

/// J_Cᵀ R of the directions R (rows × 3).
void fill_map(const JointProblem& problem, const ContactPoint& point, const Matrix3d& R, Eigen::MatrixX3d& out) {
  const Eigen::Matrix3Xd &J_w = problem.rows.J_w[at(point.link)], &J_v = problem.rows.J_v[at(point.link)];
  out.resize(J_w.cols(), 3);
  for (int k = 0; k < 3; ++k) {
    const Vector3d e = R.col(k), m = point.p_L.cross(e);
    out.col(k).noalias() = J_v.transpose() * e;
    out.col(k).noalias() += J_w.transpose() * m;
  }
}

/// Columns −J_wᵀ [f]× e of the tangential steps of a point (Y.10).
void fill_steps(const JointProblem& problem, const ContactPoint& point, const Matrix3d& R_LC, Eigen::Ref<Eigen::MatrixXd> out) {
  for (int k = 0; k < 2; ++k) out.col(k).noalias() = problem.rows.J_w[at(point.link)].transpose() * R_LC.col(k + 1).cross(point.f_L);
}

/// Residual torques Σ J_iᵀ f_i − τ.
void calc_left(const JointProblem& problem, const JointWorkspace& work, const ContactSet& set, Eigen::VectorXd& out) {
  out = -problem.rows.tau;
  for (int i = 0; i < set.count; ++i) out.noalias() += work.forces.maps[at(i)] * work.solution.forces_C[at(i)];
}

/// The damped normal equations: first the active rays, then two columns per contact.
void fill_equations(const JointProblem& problem, JointWorkspace& work, const ContactSet& set) {
  const auto carrying = static_cast<Index>(work.active_set.carrying.size()), n = carrying + 2 * set.count;
  const int rays = static_cast<int>(problem.cone.ray_matrix().cols());
  work.D.resize(problem.rows.tau.size(), 5 * kMostContacts);
  work.N.resize(5 * kMostContacts, 5 * kMostContacts);
  work.gradient.resize(5 * kMostContacts);
  for (Index k = 0; k < carrying; ++k) work.D.col(k) = work.active_set.rays.col(work.active_set.carrying[static_cast<std::size_t>(k)]);
  for (int i = 0; i < set.count; ++i) {
    const ContactPoint& point = set.contacts[at(i)];
    fill_steps(problem, point, make_contact_frame(point.n_L), work.D.middleCols(carrying + 2 * i, 2));
  }
  const auto D = work.D.leftCols(n);
  work.N.topLeftCorner(n, n).noalias() = D.transpose().lazyProduct(D);
  for (Index a = 0; a < carrying; ++a)
    for (Index b = 0; b < carrying; ++b) {
      const int i = work.active_set.carrying[static_cast<std::size_t>(a)], j = work.active_set.carrying[static_cast<std::size_t>(b)];
      if (i / rays == j / rays)
        work.N(a, b) += problem.prior * problem.cone.ray_matrix().col(i % rays).dot(problem.cone.ray_matrix().col(j % rays));
    }
  calc_left(problem, work, set, work.left);
  work.gradient.setZero();  // forces are optimal
  work.gradient.segment(carrying, 2 * set.count).noalias() = work.D.middleCols(carrying, 2 * set.count).transpose() * work.left;
}

using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 5 * kMostContacts, 5 * kMostContacts>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 5 * kMostContacts, 1>;

/// Moves all points by one damped step. @returns the largest move, as a share of the size of its link
double move_points(const JointProblem& problem, const JointDescent& options, double damping, const JointWorkspace& work, ContactSet& set) {
  const auto carrying = static_cast<Index>(work.active_set.carrying.size()), n = carrying + 2 * set.count;
  Small N = work.N.topLeftCorner(n, n);
  N.diagonal() *= 1 + damping;
  N.diagonal().array() += 1e-300;
  const SmallVector step = N.ldlt().solve(-work.gradient.head(n));
  if (!step.allFinite()) return 0;
  double share = 0;
  for (int i = 0; i < set.count; ++i)
    share = std::max(share, step.segment<2>(carrying + 2 * i).norm() / link_of(problem, set.contacts[at(i)]).surface.size);
  const double shorter = std::min(1.0, options.max_step / share);
  for (int i = 0; i < set.count; ++i) {
    ContactPoint& point = set.contacts[at(i)];
    const SensedLink& link = link_of(problem, point);
    const Vector3d move = make_contact_frame(point.n_L).rightCols<2>() * (shorter * step.segment<2>(carrying + 2 * i));
    const TriangleTree::Closest closest = link.surface.tree.closest(point.p_L + move, point.triangle);
    point.triangle = closest.triangle;
    point.p_L = closest.point;
    point.n_L = link.surface.normal(closest.triangle, closest.point, problem.sensor.options().normals);
  }
  return share;
}

}  // namespace

void evaluate(const JointProblem& problem, JointWorkspace& work, ContactSet& set) {
  ForceProblem& forces = work.forces;
  forces.contacts = set.count;
  forces.prior = problem.prior;
  forces.tau = problem.rows.tau;
  for (int i = 0; i < set.count; ++i) {
    const ContactPoint& point = set.contacts[at(i)];
    fill_map(problem, point, make_contact_frame(point.n_L), forces.maps[at(i)]);
  }
  solve_forces(forces, problem.cone, work.active_set, work.solution);
  set.residual = work.solution.residual;
  set.objective = work.solution.objective;
  for (int i = 0; i < set.count; ++i) {
    ContactPoint& point = set.contacts[at(i)];
    point.f_L = make_contact_frame(point.n_L) * work.solution.forces_C[at(i)];
    point.residual = set.residual;
  }
}

void descend(const JointProblem& problem, const JointDescent& options, double enough, JointWorkspace& work, ContactSet& set) {
  evaluate(problem, work, set);
  double damping = options.damping;
  for (int step = 0; step < options.max_steps; ++step) {
    fill_equations(problem, work, set);
    ContactSet next = set;
    const double share = move_points(problem, options, damping, work, next);
    if (share <= options.tol_step) return;
    evaluate(problem, work, next);
    if (next.objective < set.objective) {
      const bool settled = set.objective - next.objective <= options.tol_gain * next.objective && next.objective <= enough;
      set = next;
      damping = std::max(options.damping, 0.1 * damping);
      if (settled) return;
      continue;
    }
    damping = std::max(10 * damping, 1e-3);
    if (damping > 100) break;  // at a crease
    evaluate(problem, work, set);
  }
}

void calc_identifiability(const JointProblem& problem, JointWorkspace& work, ContactSet& set) {
  const Index n = 5 * set.count, rows = problem.rows.tau.size();
  work.D.resize(rows, 5 * kMostContacts);
  SmallVector sizes(n);  // units: F for forces, link sizes for points
  Eigen::MatrixX3d& map = work.forces.maps[0];
  for (int i = 0; i < set.count; ++i) {
    const ContactPoint& point = set.contacts[at(i)];
    fill_map(problem, point, Matrix3d::Identity(), map);
    work.D.middleCols<3>(5 * i) = map;
    fill_steps(problem, point, make_contact_frame(point.n_L), work.D.middleCols(5 * i + 3, 2));
    sizes.segment<3>(5 * i).setConstant(problem.noise / std::sqrt(problem.prior));
    sizes.segment<2>(5 * i + 3).setConstant(link_of(problem, point).surface.size);
  }
  for (Index k = 0; k < n; ++k) work.D.col(k) *= sizes[k];
  Small N = work.D.leftCols(n).transpose().lazyProduct(work.D.leftCols(n));
  const Eigen::SelfAdjointEigenSolver<Small> eigen(N);
  constexpr double kRank = 1e-12;  // of the largest eigenvalue, the square of a singular value
  const double least = kRank * eigen.eigenvalues()[n - 1];
  set.freedom = static_cast<int>((eigen.eigenvalues().array() <= least).count());
  const Small null_space = eigen.eigenvectors().leftCols(set.freedom);
  const Small covariance = (N / (problem.noise * problem.noise) + Small::Identity(n, n)).ldlt().solve(Small::Identity(n, n));
  for (int i = 0; i < set.count; ++i) {
    const Index point = 5 * i + 3;
    set.deviation[at(i)] = sizes[point] * std::sqrt(covariance(point, point) + covariance(point + 1, point + 1));
    constexpr double kMoves = 1e-5;  // share of a unit motion of the family (Y.11)
    set.point_is_unique[at(i)] = set.freedom == 0 || null_space.middleRows(point, 2).cwiseAbs().maxCoeff() <= kMoves;
  }
}

}  // namespace stiction::sensing
