#include "stiction/sensing/joint_forces.hpp"

#include <algorithm>
#include <cmath>

namespace stiction::sensing {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double kRounding = 1e-11;  // of a pivot or slope, relative to the terms of its difference

/// Number of rays of this call: the leading columns and entries of the workspace, which has room for kMostContacts.
Index count_rays(const ForceWorkspace& work) { return static_cast<Index>(work.blocked.size()); }

void fill(const ForceProblem& problem, const FrictionCone& cone, ForceWorkspace& work) {
  const Index n = cone.ray_matrix().cols(), room = n * kMostContacts;
  const Index size = n * problem.contacts;
  work.blocked.assign(static_cast<std::size_t>(size), 0);
  work.rays.resize(problem.tau.size(), room);
  for (int i = 0; i < problem.contacts; ++i)
    work.rays.middleCols(n * i, n).noalias() = problem.maps[static_cast<std::size_t>(i)] * cone.ray_matrix();
  const auto rays = work.rays.leftCols(size);
  work.gram.resize(room, room);
  work.gram.topLeftCorner(size, size).noalias() = rays.transpose().lazyProduct(rays);
  for (int i = 0; i < problem.contacts; ++i)
    work.gram.block(n * i, n * i, n, n) += problem.prior * cone.ray_matrix().transpose().lazyProduct(cone.ray_matrix());
  work.linear.setZero(room);
  work.linear.head(size).noalias() = rays.transpose() * problem.tau;
}

/// Appends a row to the Cholesky factor of the active rays. @returns whether the ray is linearly independent of them
bool append(ForceWorkspace& work, int ray) {
  const auto n = static_cast<Index>(work.carrying.size());
  auto row = work.factor.row(n);
  double pivot = work.gram(ray, ray);
  for (Index k = 0; k < n; ++k) {
    double sum = work.gram(ray, work.carrying[static_cast<std::size_t>(k)]);
    for (Index j = 0; j < k; ++j) sum -= row[j] * work.factor(k, j);
    row[k] = sum / work.factor(k, k);
    pivot -= row[k] * row[k];
  }
  if (!(pivot > kRounding * work.gram(ray, ray))) return false;
  row[n] = std::sqrt(pivot);
  work.carrying.push_back(ray);
  return true;
}

void factorize(ForceWorkspace& work) {
  auto& rays = work.solution;  // holds the ray numbers while the list is rebuilt
  const auto n = static_cast<Index>(work.carrying.size());
  for (Index k = 0; k < n; ++k) rays[k] = work.carrying[static_cast<std::size_t>(k)];
  work.carrying.clear();
  for (Index k = 0; k < n; ++k) append(work, static_cast<int>(rays[k]));
}

/// β of the active rays without the bounds β ≥ 0.
void solve_carrying(ForceWorkspace& work) {
  const auto n = static_cast<Index>(work.carrying.size());
  VectorXd& x = work.solution;
  for (Index k = 0; k < n; ++k) {
    x[k] = work.linear[work.carrying[static_cast<std::size_t>(k)]];
    for (Index j = 0; j < k; ++j) x[k] -= work.factor(k, j) * x[j];
    x[k] /= work.factor(k, k);
  }
  for (Index k = n - 1; k >= 0; --k) {
    for (Index j = k + 1; j < n; ++j) x[k] -= work.factor(j, k) * x[j];
    x[k] /= work.factor(k, k);
  }
}

/// Moves β towards the unconstrained solution and drops rays until all active rays are positive. @returns false if the newest ray is not
/// positive
bool settle(ForceWorkspace& work, int newest) {
  while (!work.carrying.empty()) {
    solve_carrying(work);
    double step = 1;
    for (std::size_t k = 0; k < work.carrying.size(); ++k) {
      const double z = work.solution[static_cast<Index>(k)], x = work.beta[work.carrying[k]];
      if (z > 0) continue;
      if (work.carrying[k] == newest && x == 0) return false;
      step = std::min(step, x / (x - z));
    }
    for (std::size_t k = 0; k < work.carrying.size(); ++k) {
      double& x = work.beta[work.carrying[k]];
      x = step < 1 ? x + step * (work.solution[static_cast<Index>(k)] - x) : work.solution[static_cast<Index>(k)];
    }
    if (step == 1) return true;
    double largest = 0;
    for (const int ray : work.carrying) largest = std::max(largest, work.beta[ray]);
    std::erase_if(work.carrying, [&](int ray) {
      if (work.beta[ray] > kRounding * largest) return false;
      work.beta[ray] = 0;
      return true;
    });
    factorize(work);
  }
  return true;
}

/// Starts from the active rays of the last call, if all of them are positive.
void start(ForceWorkspace& work) {
  std::erase_if(work.carrying, [&](int ray) { return ray >= count_rays(work); });
  factorize(work);
  solve_carrying(work);
  bool positive = true;
  for (std::size_t k = 0; k < work.carrying.size(); ++k) positive &= work.solution[static_cast<Index>(k)] > 0;
  if (!positive) work.carrying.clear();
  for (std::size_t k = 0; k < work.carrying.size(); ++k) work.beta[work.carrying[k]] = work.solution[static_cast<Index>(k)];
}

/// The ray along which the objective falls most steeply, −1: none.
int find_steepest(ForceWorkspace& work) {
  work.slope = work.linear;
  const Index size = count_rays(work);
  for (const int ray : work.carrying) work.slope.head(size) -= work.beta[ray] * work.gram.col(ray).head(size);
  int best = -1;
  double largest = kRounding * work.linear.cwiseAbs().maxCoeff();
  for (Index j = 0; j < size; ++j) {
    const auto ray = static_cast<int>(j);
    if (!(work.slope[j] > largest) || work.blocked[static_cast<std::size_t>(j)] != 0) continue;
    if (std::find(work.carrying.begin(), work.carrying.end(), ray) != work.carrying.end()) continue;
    largest = work.slope[j];
    best = ray;
  }
  return best;
}

}  // namespace

void solve_forces(const ForceProblem& problem, const FrictionCone& cone, ForceWorkspace& work, ForceSolution& out) {
  fill(problem, cone, work);
  const Index n = count_rays(work), room = work.linear.size(), most = 3 * kMostContacts + 1;  // each block of the Gram matrix has rank 3
  work.beta.setZero(room);
  work.factor.resize(most, most);
  work.solution.resize(std::max(room, most));
  start(work);
  const int most_steps = 10 * static_cast<int>(n);
  for (int step = 0; step < most_steps; ++step) {
    const int ray = find_steepest(work);
    if (ray < 0) break;
    if (!append(work, ray)) {
      work.blocked[static_cast<std::size_t>(ray)] = 1;
      continue;
    }
    if (settle(work, ray)) {
      std::fill(work.blocked.begin(), work.blocked.end(), 0);
    } else {  // by rounding alone
      work.carrying.pop_back();
      work.blocked[static_cast<std::size_t>(ray)] = 1;
    }
  }
  const Index per_contact = cone.ray_matrix().cols();
  work.left = problem.tau;
  out.objective = 0;
  for (int i = 0; i < problem.contacts; ++i) {
    Eigen::Vector3d& f = out.forces_C[static_cast<std::size_t>(i)];
    f = cone.ray_matrix() * work.beta.segment(per_contact * i, per_contact);
    work.left.noalias() -= problem.maps[static_cast<std::size_t>(i)] * f;
    out.objective += problem.prior * f.squaredNorm();
  }
  out.residual = work.left.squaredNorm();
  out.objective += out.residual;
}

}  // namespace stiction::sensing
