#include "stiction/dynamics/linearisation.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "stiction/dynamics/rim.hpp"
#include "stiction/dynamics/so3.hpp"
#include "stiction/world/object_derivatives.hpp"

namespace stiction::dynamics::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using world::Model;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Transports D from the tangent space at q, where δq lives, to the tangent space at q ⊕ δq: J_r multiplies the rows of free rotations.
void transport(const Model& model, const Eigen::VectorXd& delta, Eigen::MatrixXd& D) {
  for_each_free_rotation(model, [&](int row) {
    const So3 so3(delta.segment<3>(row));
    for (Eigen::Index j = 0; j < D.cols(); ++j) {
      const Vector3d column = D.block<3, 1>(row, j);
      D.block<3, 1>(row, j) = so3.right_jacobian * column;
    }
  });
}

/// Computes λ and S = −∂λ/∂w_c of every contact at the solution, with w_c = φe₁ + J_c δq (S.7). Both are 0 for contacts without rows.
void fill_impulses(const SolvedStep& step, const StepResult& out, LinearisationWorkspace& work) {
  int cone = 0, half = 0;
  work.lambda.assign(out.contacts.size(), Vector3d::Zero());
  work.stiffness.assign(out.contacts.size(), ContactStiffness{});
  for (std::size_t i = 0; i < out.contacts.size(); ++i) {
    if (!step.included[i]) continue;
    const double mu = out.contacts[i].contact.friction * step.options.friction_scale;
    work.lambda[i] = out.contacts[i].lambda;
    ContactStiffness& S = work.stiffness[i];
    if (!step.rays.empty()) {
      for (const auto& d : step.rays) {
        const Vector3d row(1, mu * d.x(), mu * d.y());
        S.rest += cone::D_half_line(step.solver, half++) * row * row.transpose();
      }
    } else if (mu == 0) {
      S.sharp[0] = std::sqrt(cone::D_half_line(step.solver, half++));
    } else {
      const cone::ConeDerivative D = cone::D_cone(step.solver, cone++);
      S.sharp = D.sharp.cwiseProduct(Vector3d(1, mu, mu));
      S.rest.diagonal() = -D.round * Vector3d(1, -mu * mu, -mu * mu);
    }
  }
}

/// S y of one contact.
Vector3d multiply(const ContactStiffness& S, const Vector3d& y) { return S.sharp * S.sharp.dot(y) + S.rest * y; }

/// Adds −∂(Qδq + b)/∂q to R (S.8). Robots: b = −hK_a(u − qᵃ), which is constant for a saturated spring (S.15). Objects: the mass matrix and
/// gravity depend on q if the centre of mass turns about an axis away from it. A free object that carries nothing and has its frame at the
/// centre of mass needs no such term.
void subtract_objective(const SolvedStep& step, const StepResult& out, LinearisationWorkspace& work, Eigen::MatrixXd& R) {
  const Model& model = step.model;
  const double h = step.options.h;
  for (int j = 0; j < model.n_a(); ++j) {
    if (step.motor_bound[at(j)] < 0) R(model.n_vu() + j, model.n_vu() + j) -= h * model.stiffness()[j];
  }
  for (int v = 0; v < model.n_vu(); ++v) R(v, v) -= h * model.dofs()[at(v)].spring;
  work.D_momentum.resize(6, model.n_vu());
  work.D_gravity.resize(6, model.n_vu());
  const auto objects = model.objects();
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const auto& object = objects[o];
    if (object.n_v == 6 && object.carried_mass == object.mass && model.inertias()[at(object.body)].p_BCom.isZero(0)) continue;
    auto D_momentum = work.D_momentum.topRows(object.n_v), D_gravity = work.D_gravity.topRows(object.n_v);
    world::calc_object_derivatives(model, step.kinematics, static_cast<int>(o), out.delta.segment(object.v_begin, object.n_v), D_momentum,
                                   D_gravity);
    R.block(object.v_begin, 0, object.n_v, model.n_vu()) -= out.epsilon[static_cast<Eigen::Index>(o)] / h * D_momentum - h * D_gravity;
  }
}

/// Coordinates and Jacobian of one contact.
struct Rows {
  Rows(const SolvedStep& step, const StepResult& out, std::size_t i)
      : support(step.model.supports()[at(step.model.pairs()[at(out.contacts[i].contact.pair)].support)]),
        J(step.J.values.data() + step.J.begin[i], 3, static_cast<Eigen::Index>(support.size())) {}
  using Matrix = Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>>;
  const std::vector<int>& support;
  Matrix J;
};

/// dλ −= S (D_w_q + J_c X) for every contact, X (n_v × n). D_w_q is left out unless with_D_w.
void subtract_answers(const SolvedStep& step, const StepResult& out, bool with_D_w, const RowMatrix& X, LinearisationWorkspace& work,
                      ImpulseDerivatives& D_lambda) {
  work.motion.resize(3, step.model.n_v());
  auto motion = work.motion.leftCols(X.cols());
  for (std::size_t i = 0; i < out.contacts.size(); ++i) {
    if (!step.included[i]) continue;
    const Rows rows(step, out, i);
    const auto k = static_cast<Eigen::Index>(rows.support.size());
    motion.setZero();
    if (with_D_w) {
      const Rows::Matrix D_w(work.derivatives.D_w_q.data() + step.J.begin[i], 3, k);
      for (Eigen::Index c = 0; c < k; ++c) motion.col(rows.support[static_cast<std::size_t>(c)]) = D_w.col(c);
    }
    for (Eigen::Index c = 0; c < k; ++c) {
      const auto x = X.row(rows.support[static_cast<std::size_t>(c)]);
      for (int r = 0; r < 3; ++r) motion.row(r) += rows.J(r, c) * x;
    }
    auto D = D_lambda[i];
    const ContactStiffness& S = work.stiffness[i];
    for (Eigen::Index j = 0; j < D.cols(); ++j) D.col(j) -= multiply(S, motion.col(j));
  }
}

/// dλ = −S (D_w_q + J_c X) (S.9) for every contact, with X the derivative of δq. Derivatives by u have no D_w_q.
void calc_impulses(const SolvedStep& step, const StepResult& out, bool by_q, LinearisationWorkspace& work, ImpulseDerivatives& D_lambda) {
  const RowMatrix& X = by_q ? work.by_q.X : work.by_u.X;
  D_lambda.resize(out.contacts.size(), X.cols());
  for (std::size_t i = 0; i < out.contacts.size(); ++i) D_lambda[i].setZero();
  subtract_answers(step, out, by_q, X, work, D_lambda);
}

/// R += J_cᵀ dλ over all contacts.
void add_impulses(const SolvedStep& step, const StepResult& out, const ImpulseDerivatives& D_lambda, RowMatrix& R) {
  for (std::size_t i = 0; i < out.contacts.size(); ++i) {
    if (!step.included[i]) continue;
    const Rows rows(step, out, i);
    const auto D = D_lambda[i];
    for (std::size_t c = 0; c < rows.support.size(); ++c) {
      const auto j = static_cast<Eigen::Index>(c);
      R.row(rows.support[c]) += rows.J(0, j) * D.row(0) + rows.J(1, j) * D.row(1) + rows.J(2, j) * D.row(2);
    }
  }
}

/// R += J_cᵀ dλ for dλ = −S D_w_q, the change of the impulses at constant δq.
void add_first_impulses(const SolvedStep& step, const StepResult& out, const LinearisationWorkspace& work, Eigen::MatrixXd& R) {
  for (std::size_t i = 0; i < out.contacts.size(); ++i) {
    if (!step.included[i]) continue;
    const Rows rows(step, out, i);
    const auto k = static_cast<Eigen::Index>(rows.support.size());
    const Rows::Matrix D_w(work.derivatives.D_w_q.data() + step.J.begin[i], 3, k);
    for (Eigen::Index j = 0; j < k; ++j) {
      const Vector3d d = multiply(work.stiffness[i], D_w.col(j));
      double* column = R.col(rows.support[static_cast<std::size_t>(j)]).data();
      for (Eigen::Index c = 0; c < k; ++c) column[rows.support[static_cast<std::size_t>(c)]] -= rows.J.col(c).dot(d);
    }
  }
}

/// Refines the solution of the two equations H X = fixed + J_cᵀdλ and dλ = −S (D_w_q + J_c X). S has entries of the size λ²/σ. The factor
/// of H has lost their digits, and recomputing dλ from the better X would lose them again. One round is enough for X. dλ needs a second
/// round if more contacts press than J_c has rank.
void refine(const SolvedStep& step, const StepResult& out, LinearisationWorkspace& work, bool by_q, Eigen::MatrixXd& X) {
  LinearSystem& system = by_q ? work.by_q : work.by_u;
  ImpulseDerivatives& D_lambda = by_q ? work.D_lambda_q : work.D_lambda_u;
  system.X = X;
  calc_impulses(step, out, by_q, work, D_lambda);
  const int rounds = step.options.with_force_derivatives ? 2 : 1;
  for (int round = 1; round <= rounds; ++round) {
    system.X = X;
    system.residual = system.fixed;
    add_impulses(step, out, D_lambda, system.residual);
    for (const QEntry& e : step.Q) {
      system.residual.row(e.row) -= e.value * system.X.row(e.column);
      if (e.row != e.column) system.residual.row(e.column) -= e.value * system.X.row(e.row);
    }
    for (std::size_t i = 0; i < step.bound_variables.size(); ++i) {
      const int v = step.bound_variables[i];
      const double D = cone::D_bound(step.solver, static_cast<int>(i));
      system.residual.row(v) -= D * system.X.row(v);
      if (by_q && i < step.moving_bounds) system.residual(v, v) -= D;
    }
    system.correction = system.residual;
    cone::apply_inverse(step.solver, system.correction);
    X += system.correction;
    if (!step.options.with_force_derivatives) return;
    system.X = system.correction;
    subtract_answers(step, out, false, system.X, work, D_lambda);
  }
}

/// −∂/∂q of Qδq + b − Σ J_cᵀλ at fixed components of δq and λ (S.8).
void calc_fixed(const SolvedStep& step, contact::Workspace& contact_work, LinearisationWorkspace& work, const StepResult& out) {
  const Model& model = step.model;
  work.by_q.fixed.setZero(model.n_v(), model.n_v());
  work.contacts.resize(out.contacts.size());
  for (std::size_t i = 0; i < out.contacts.size(); ++i) work.contacts[i] = out.contacts[i].contact;
  contact::calc_derivatives(model, step.kinematics, work.contacts, step.J, work.lambda, out.delta, step.included, contact_work,
                            work.derivatives);
  for (std::size_t i = 0; i < out.contacts.size(); ++i) {
    if (!step.included[i]) continue;
    const Rows rows(step, out, i);
    const double* D = work.derivatives.D_tau_q.data() + work.derivatives.begin[i];
    for (const int row : rows.support) {
      for (const int j : rows.support) work.by_q.fixed(row, j) += *D++;
    }
  }
  subtract_objective(step, out, work, work.by_q.fixed);
}

/// Calls visit(i, g) with g = ∂ ln σ/∂q for every contact whose σ changes with q (S.17). At constant w, λ is proportional to σ: ∂λ = λ gᵀ.
template <class Visit>
void for_each_slope(const SolvedStep& step, const StepResult& out, LinearisationWorkspace& work, Visit&& visit) {
  if (std::holds_alternative<Exact>(step.options.smoothing) || !step.shares) return;
  for (std::size_t i = 0; i < out.contacts.size(); ++i) {
    if (step.included[i] && calc_share_slope(step.model, step.kinematics, out.contacts[i].contact, work.slope)) visit(i, work.slope);
  }
}

/// A = T + J_r D_δq_q, where T transports the tangent space: exp(δθ)ᵀ for free rotations, otherwise 1 (S.10).
void calc_A(const SolvedStep& step, contact::Workspace& contact_work, LinearisationWorkspace& work, StepResult& out) {
  calc_fixed(step, contact_work, work, out);
  for_each_slope(step, out, work, [&](std::size_t i, const Eigen::VectorXd& slope) {
    const Rows rows(step, out, i);
    for (std::size_t c = 0; c < rows.support.size(); ++c)
      work.by_q.fixed.row(rows.support[c]) += rows.J.col(static_cast<Eigen::Index>(c)).dot(out.contacts[i].lambda) * slope.transpose();
  });
  out.A = work.by_q.fixed;
  add_first_impulses(step, out, work, out.A);
  for (std::size_t i = 0; i < step.moving_bounds; ++i) {
    const int v = step.bound_variables[i];
    out.A(v, v) -= cone::D_bound(step.solver, static_cast<int>(i));
  }
  cone::apply_inverse(step.solver, out.A);
  if (std::holds_alternative<Exact>(step.options.smoothing)) {
    refine(step, out, work, true, out.A);
    if (step.options.with_force_derivatives) out.D_lambda_q = work.D_lambda_q;
  } else if (step.options.with_force_derivatives) {
    work.by_q.X = out.A;
    calc_impulses(step, out, true, work, out.D_lambda_q);
    for_each_slope(step, out, work,
                   [&](std::size_t i, const Eigen::VectorXd& slope) { out.D_lambda_q[i] += out.contacts[i].lambda * slope.transpose(); });
  }
  transport(step.model, out.delta, out.A);
  out.A.diagonal().array() += 1.0;
  for_each_free_rotation(
      step.model, [&](int row) { out.A.block<3, 3>(row, row) += exp_so3(out.delta.segment<3>(row)).transpose() - Matrix3d::Identity(); });
}

/// B = J_r D_δq_u (S.5).
void calc_B(const SolvedStep& step, LinearisationWorkspace& work, StepResult& out) {
  const Model& model = step.model;
  work.actuated.resize(at(model.n_a()));
  work.h_stiffness.resize(at(model.n_a()));
  for (int j = 0; j < model.n_a(); ++j) {
    work.actuated[at(j)] = model.n_vu() + j;
    const int bound = step.motor_bound[at(j)];
    work.h_stiffness[at(j)] = bound < 0 ? step.options.h * model.stiffness()[j] : cone::D_bound(step.solver, bound);
  }
  out.B.resize(model.n_v(), model.n_a());
  cone::calc_inverse_columns(step.solver, work.actuated, work.h_stiffness, out.B);
  if ((step.options.with_A || step.options.with_force_derivatives) && std::holds_alternative<Exact>(step.options.smoothing)) {
    work.by_u.fixed.setZero(model.n_v(), model.n_a());
    for (int j = 0; j < model.n_a(); ++j) work.by_u.fixed(work.actuated[at(j)], j) = work.h_stiffness[at(j)];
    refine(step, out, work, false, out.B);
    if (step.options.with_force_derivatives) out.D_lambda_u = work.D_lambda_u;
  } else if (step.options.with_force_derivatives) {
    work.by_u.X = out.B;
    calc_impulses(step, out, false, work, out.D_lambda_u);
  }
  transport(model, out.delta, out.B);
}

}  // namespace

void linearise(const SolvedStep& step, contact::Workspace& contact_work, LinearisationWorkspace& work, StepResult& out) {
  out.D_lambda_q.resize(0, 0);
  out.D_lambda_u.resize(0, 0);
  if (step.options.with_A || step.options.with_force_derivatives) fill_impulses(step, out, work);
  if (step.options.with_A) calc_A(step, contact_work, work, out);
  if (step.options.with_B) calc_B(step, work, out);
}

}  // namespace stiction::dynamics::detail
