#include "stiction/dynamics/linearisation.hpp"

#include <Eigen/Geometry>

#include "stiction/dynamics/so3.hpp"

namespace stiction::dynamics::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using world::Model;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// From the tangent space at q, where δq lives, to the one at q ⊕ δq: rows of free rotations get J_r.
template <class Visit>
void for_each_free_rotation(const Model& model, const Eigen::VectorXd& delta, Visit&& visit) {
  for (const auto& object : model.objects()) {
    if (object.n_v == 6) visit(object.v_begin + 3, So3(delta.segment<3>(object.v_begin + 3)));
  }
}

void transport(const Model& model, const Eigen::VectorXd& delta, Eigen::MatrixXd& D) {
  for_each_free_rotation(model, delta, [&](int row, const So3& so3) {
    for (Eigen::Index j = 0; j < D.cols(); ++j) {
      const Vector3d column = D.block<3, 1>(row, j);
      D.block<3, 1>(row, j) = so3.right_jacobian * column;
    }
  });
}

/// λ and S = −∂λ/∂w_c of every contact at the solution, with w_c = φe₁ + J_c δq (S.7); both 0 where the rows are not in the program.
void fill_loads(const SolvedStep& step, const StepResult& out, std::vector<contact::ContactLoad>& loads) {
  int cone = 0, half = 0;
  loads.assign(out.contacts.size(), {});
  for (std::size_t i = 0; i < loads.size(); ++i) {
    if (!step.included[i]) continue;
    const double mu = out.contacts[i].contact.friction * step.options.friction_scale;
    contact::ContactLoad& load = loads[i];
    load.lambda = out.contacts[i].lambda;
    Matrix3d& S = load.stiffness;
    if (!step.rays.empty()) {
      for (const auto& d : step.rays) {
        const Vector3d row(1, mu * d.x(), mu * d.y());
        S += cone::D_half_line(step.solver, half++) * row * row.transpose();
      }
    } else if (mu == 0) {
      S(0, 0) = cone::D_half_line(step.solver, half++);
    } else {
      const Vector3d scale(1, mu, mu);
      S = scale.asDiagonal() * cone::D_cone(step.solver, cone++) * scale.asDiagonal();
    }
  }
}

/// −∂(Qδq + b)/∂q (S.8). Robots: b = −hK_a(u − qᵃ). Objects: mass matrix and gravity of one whose centre of mass turns about its axis;
/// a free object turns about its centre of mass.
void subtract_objective(const SolvedStep& step, const StepResult& out, Eigen::MatrixXd& R) {
  const Model& model = step.model;
  const double h = step.options.h;
  for (int j = 0; j < model.n_a(); ++j) R(model.n_vu() + j, model.n_vu() + j) -= h * model.stiffness()[j];
  const auto objects = model.objects();
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const auto& object = objects[o];
    const int turn = object.v_begin + object.n_v - 1;  // the only one there may be
    if (object.n_v == 6 || model.dofs()[at(turn)].kind != world::DofKind::Revolute) continue;
    const Vector3d axis = step.kinematics.axis_W.col(turn);
    const Vector3d arm = step.kinematics.X_WB[at(object.body)] * model.scene().objects[o].p_BCom - step.kinematics.origin_W.col(turn);
    const Vector3d lever = axis.cross(arm), d_lever = axis.cross(lever);
    const double m = out.epsilon[static_cast<Eigen::Index>(o)] / h * object.mass;
    Vector3d velocity = out.delta[turn] * lever;  // of the centre of mass
    for (int i = object.v_begin; i < turn; ++i) {
      const Vector3d slide = step.kinematics.axis_W.col(i);
      velocity += out.delta[i] * slide;
      R(i, turn) -= m * slide.dot(d_lever) * out.delta[turn];
    }
    R(turn, turn) -= m * (d_lever.dot(velocity) + lever.dot(d_lever) * out.delta[turn]);
    R(turn, turn) += h * object.mass * d_lever.dot(model.scene().gravity);
  }
}

/// dλ = −S (D_w_q dq + J_c D_δq) (S.9), for D_δq (n_v × n) of all coordinates; D_w_q null where w_c is not moved by itself.
void calc_impulses(const SolvedStep& step, const StepResult& out, const LinearisationWorkspace& work, const Eigen::MatrixXd& D_delta,
                   bool with_q, ImpulseDerivatives& D_lambda) {
  using RowMajor = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
  const Model& model = step.model;
  D_lambda.resize(out.contacts.size(), D_delta.cols());
  for (std::size_t i = 0; i < out.contacts.size(); ++i) {
    auto D = D_lambda[i];
    D.setZero();
    if (!step.included[i]) continue;
    const auto& support = model.supports()[at(model.pairs()[at(out.contacts[i].contact.pair)].support)];
    const auto k = static_cast<Eigen::Index>(support.size());
    const Eigen::Map<const RowMajor> J(step.J.values.data() + step.J.begin[i], 3, k);
    for (Eigen::Index j = 0; j < D.cols(); ++j) {
      Vector3d dw = Vector3d::Zero();
      for (Eigen::Index c = 0; c < k; ++c) dw += J.col(c) * D_delta(support[static_cast<std::size_t>(c)], j);
      D.col(j) = dw;
    }
    if (with_q) {
      const Eigen::Map<const RowMajor> D_w(work.derivatives.D_w_q.data() + step.J.begin[i], 3, k);
      for (Eigen::Index c = 0; c < k; ++c) D.col(support[static_cast<std::size_t>(c)]) += D_w.col(c);
    }
    const Matrix3d& S = work.loads[i].stiffness;
    for (Eigen::Index j = 0; j < D.cols(); ++j) D.col(j) = -(S * Vector3d(D.col(j))).eval();
  }
}

/// R = −∂/∂q of the stationarity condition Qδq + b − Σ J_cᵀλ at fixed components of δq, λ following w_c (S.8).
void calc_stationarity(const SolvedStep& step, contact::Workspace& contact_work, LinearisationWorkspace& work, const StepResult& out,
                       Eigen::MatrixXd& R) {
  const Model& model = step.model;
  R.setZero(model.n_v(), model.n_v());
  work.contacts.resize(out.contacts.size());
  for (std::size_t i = 0; i < out.contacts.size(); ++i) work.contacts[i] = out.contacts[i].contact;
  contact::calc_derivatives(model, step.kinematics, work.contacts, step.J, work.loads, out.delta, contact_work, work.derivatives);
  for (std::size_t i = 0; i < out.contacts.size(); ++i) {
    if (!step.included[i]) continue;
    const auto& support = model.supports()[at(model.pairs()[at(work.contacts[i].pair)].support)];
    const double* D = work.derivatives.D_tau_q.data() + work.derivatives.begin[i];
    for (const int j : support) {
      for (const int row : support) R(row, j) += *D++;
    }
  }
  for (std::size_t i = 0; i < step.bound_variables.size(); ++i) {
    const int variable = step.bound_variables[i];
    R(variable, variable) -= cone::D_bound(step.solver, static_cast<int>(i));
  }
  subtract_objective(step, out, R);
}

/// A = T + J_r H⁻¹R, T the transport of the tangent space: exp(δθ)ᵀ for free rotations, else 1 (S.10).
void calc_A(const SolvedStep& step, contact::Workspace& contact_work, LinearisationWorkspace& work, StepResult& out) {
  calc_stationarity(step, contact_work, work, out, out.A);
  cone::apply_inverse(step.solver, out.A);
  if (step.options.with_force_derivatives) calc_impulses(step, out, work, out.A, true, out.D_lambda_q);
  transport(step.model, out.delta, out.A);
  out.A.diagonal().array() += 1.0;
  for_each_free_rotation(step.model, out.delta,
                         [&](int row, const So3& so3) { out.A.block<3, 3>(row, row) += so3.exp.transpose() - Matrix3d::Identity(); });
}

/// B = J_r H⁻¹ [0; hK_a] (S.5).
void calc_B(const SolvedStep& step, LinearisationWorkspace& work, StepResult& out) {
  const Model& model = step.model;
  work.actuated.resize(at(model.n_a()));
  work.h_stiffness.resize(at(model.n_a()));
  for (int j = 0; j < model.n_a(); ++j) {
    work.actuated[at(j)] = model.n_vu() + j;
    work.h_stiffness[at(j)] = step.options.h * model.stiffness()[j];
  }
  out.B.resize(model.n_v(), model.n_a());
  cone::calc_inverse_columns(step.solver, work.actuated, work.h_stiffness, out.B);
  if (step.options.with_force_derivatives) calc_impulses(step, out, work, out.B, false, out.D_lambda_u);
  transport(model, out.delta, out.B);
}

}  // namespace

void linearise(const SolvedStep& step, contact::Workspace& contact_work, LinearisationWorkspace& work, StepResult& out) {
  if (step.options.with_A || step.options.with_force_derivatives) fill_loads(step, out, work.loads);
  if (step.options.with_A) calc_A(step, contact_work, work, out);
  if (step.options.with_B) calc_B(step, work, out);
}

}  // namespace stiction::dynamics::detail
