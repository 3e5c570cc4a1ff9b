#include "stiction/sensing/descent.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void require_point(const Sensor& sensor, const char* field, const ContactPoint& point) {
  const auto links = static_cast<int>(sensor.links().size());
  if (point.link < 0 || point.link >= links)
    core::throw_invalid(field, fmt::format("a contact on link {} of {}", point.link, links), "contacts of the same sensor");
  const SensedLink& link = sensor.links()[static_cast<std::size_t>(point.link)];
  const Eigen::Index triangles = link.surface.normals.cols();
  if (point.triangle < 0 || point.triangle >= triangles)
    core::throw_invalid(field,
                        fmt::format("a contact on triangle {} of {} of '{}'", point.triangle, triangles, sensor.link_name(point.link)),
                        "contacts of the same sensor");
  if (!point.p_L.allFinite()) core::throw_invalid(field, "a contact at a point that is not finite", "finite points");
}

ContactPoint evaluate(const DescentProblem& problem, int triangle, const Vector3d& p) {
  ContactPoint out;
  out.link = problem.index;
  out.triangle = triangle;
  out.p_L = p;
  out.n_L = problem.link.surface.normal(triangle, p, problem.normals);
  const Matrix3d R_LC = make_contact_frame(out.n_L);
  const Residual r = calc_residual(problem.torque, p, R_LC, problem.cone);
  out.f_L = R_LC * r.force_C;
  out.residual = r.value;
  return out;
}

ContactPoint retract(const DescentProblem& problem, const Vector3d& p, int guess) {
  const TriangleTree::Closest closest = problem.link.surface.tree.closest(p, guess);
  return evaluate(problem, closest.triangle, closest.point);
}

namespace {

bool is_explained(const DescentProblem& problem, double residual) {
  return residual <= problem.tolerance * problem.tolerance * problem.torque.tau_tau;
}

/// Whether two steps a → b → c return so nearly to the start that all allowed steps together would progress by less than one step: two
/// facets send the point to each other.
bool returns(const ContactPoint& a, const ContactPoint& b, const ContactPoint& c, int max_steps) {
  return a.triangle == c.triangle && max_steps * (c.p_L - a.p_L).norm() < (c.p_L - b.p_L).norm();
}

}  // namespace

bool descend(const DescentProblem& problem, const SteepestDescent& options, ContactPoint& point) {
  const double size = problem.link.surface.size, start = point.residual;
  const double least_gradient = options.tol_gradient * problem.torque.tau_tau / size;
  ContactPoint before = point;
  for (int step = 0; step < options.max_steps; ++step) {
    if (is_explained(problem, point.residual)) return point.residual < start || step == 0;
    const Vector3d gradient = 0.5 * calc_gradient(problem.torque, point.p_L, point.f_L);  // of l/2, as in the thesis's figures
    const Vector3d t = gradient - point.n_L.dot(gradient) * point.n_L;
    const double length = t.norm();
    if (length <= least_gradient) return point.residual < start || step == 0;

    // Line search in the tangent plane, with the normal held.
    const Matrix3d R_LC = make_contact_frame(point.n_L);
    double a = std::min(options.max_step * size / length, 1.0);
    int tries = 0;
    const auto decreases = [&] {
      const double l = calc_residual(problem.torque, point.p_L - a * t, R_LC, problem.cone).value;
      return 0.5 * l < 0.5 * point.residual - options.armijo * a * length * length;
    };
    while (!decreases()) {
      if (++tries > options.max_backtracks) return false;
      a *= options.backtrack;
    }
    const ContactPoint next = retract(problem, point.p_L - a * t, point.triangle);
    if ((next.p_L - (point.p_L - a * t)).norm() > options.max_step * size) return false;  // left the surface
    if (step > 0 && returns(before, point, next, options.max_steps)) return false;
    before = point;
    point = next;
  }
  return false;
}

namespace {

using Wrench = Eigen::Matrix<double, 6, 1>;

/// Columns (m; f) of the wrenches about the link's origin that a change of the unknowns makes: force coordinates on the active face,
/// then the two tangential coordinates. With torques (Y.1) these are the columns of the Jacobian of r. @returns how many
int fill_columns(const ContactPoint& point, const Residual& r, const Matrix3d& R_LC, const FrictionCone& cone,
                 Eigen::Matrix<double, 6, 5>& W) {
  int n = 0;
  const auto add_force = [&](const Vector3d& direction_C) {
    const Vector3d d = R_LC * direction_C;
    W.col(n++) << point.p_L.cross(d), d;
  };
  if (r.face == ConeFace::Interior) {
    for (int k = 0; k < 3; ++k) add_force(Vector3d::Unit(k));
  } else if (r.face == ConeFace::Facet && cone.is_lorentz()) {  // along the boundary: the force itself, and around the cone
    add_force(r.force_C.normalized());
    add_force(Vector3d(0, -r.force_C[2], r.force_C[1]).normalized());
  } else {
    add_force(cone.ray_matrix().col(r.ray));
    if (r.face == ConeFace::Facet) add_force(cone.ray_matrix().col((r.ray + 1) % cone.rays()));
  }
  for (int k = 1; k < 3; ++k) W.col(n++) << R_LC.col(k).cross(point.f_L), Vector3d::Zero();
  return n;
}

/// Products of the directions of the force coordinates, weighted by ρ; they are the lower halves of the columns of fill_columns.
void add_prior(double prior, const Eigen::Matrix<double, 6, 5>& W, int forces, Eigen::Matrix<double, 5, 5>& N) {
  N.topLeftCorner(forces, forces) += prior * W.block(3, 0, 3, forces).transpose() * W.block(3, 0, 3, forces);
}

/// Tangential step of the damped normal equations (Y.4).
Vector3d calc_step(const DescentProblem& problem, const ContactPoint& point, double damping) {
  const Matrix3d R_LC = make_contact_frame(point.n_L);
  const Residual r = calc_residual(problem.torque, point.p_L, R_LC, problem.cone);
  Eigen::Matrix<double, 6, 5> W;
  const int n = fill_columns(point, r, R_LC, problem.cone, W);
  const LinkTorque& link = problem.torque;
  Eigen::Matrix<double, LinkTorque::kSize, 6> R;
  R << link.R_w, link.R_v;
  Eigen::Matrix<double, LinkTorque::kSize, 5> D = Eigen::Matrix<double, LinkTorque::kSize, 5>::Zero();
  D.leftCols(n) = R * W.leftCols(n);
  Wrench force;
  force << point.p_L.cross(point.f_L), point.f_L;
  const Eigen::Matrix<double, LinkTorque::kSize, 1> residual = R * force - link.R_tau;
  Eigen::Matrix<double, 5, 5> N = D.transpose() * D;
  add_prior(link.prior, W, n - 2, N);
  for (int k = 0; k < 5; ++k) N(k, k) = k < n ? N(k, k) * (1 + damping) + 1e-300 : 1;
  Eigen::Matrix<double, 5, 1> gradient = D.transpose() * residual;
  gradient.head(n - 2) += link.prior * W.block(3, 0, 3, n - 2).transpose() * point.f_L;
  const Eigen::Matrix<double, 5, 1> x = N.ldlt().solve(-gradient);
  return x[n - 2] * R_LC.col(1) + x[n - 1] * R_LC.col(2);
}

/// Whether an earlier descent ended nearby with an l that is not larger.
bool is_known(const DescentProblem& problem, const ContactPoint& point) {
  return std::any_of(problem.ends.begin(), problem.ends.end(), [&](const ContactPoint& end) {
    return end.link == point.link && end.residual <= point.residual && (end.p_L - point.p_L).squaredNorm() < problem.near * problem.near;
  });
}

}  // namespace

bool descend(const DescentProblem& problem, const GaussNewton& options, ContactPoint& point) {
  const double size = problem.link.surface.size;
  const double settled = std::max(1e-12 * problem.torque.tau_tau, problem.settle);
  double damping = options.damping;
  for (int step = 0; step < options.max_steps; ++step) {
    if (point.f_L.isZero(0)) return false;  // no force lowers the residual, which is constant here
    Vector3d move = calc_step(problem, point, damping);
    if (!move.allFinite()) return false;
    const double length = move.norm();
    if (length <= options.tol_step * size) return true;
    if (length > options.max_step * size) move *= options.max_step * size / length;
    const ContactPoint next = retract(problem, point.p_L + move, point.triangle);
    if (next.residual < point.residual) {
      const bool is_settled = point.residual - next.residual <= settled;
      point = next;
      damping = std::max(options.damping, 0.1 * damping);
      if (is_settled) return true;
      if (is_known(problem, point)) return false;
    } else {
      if (next.residual <= point.residual + 1e-14 * problem.torque.tau_tau) return true;
      damping = std::max(10 * damping, 1e-3);
      if (damping > 100) return true;  // at a crease: no tangential step goes down
    }
  }
  return is_explained(problem, point.residual);
}

}  // namespace stiction::sensing
