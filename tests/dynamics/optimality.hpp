#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "stiction/contact/contact.hpp"
#include "stiction/dynamics/step.hpp"

namespace stiction::dynamics::test {

/// max_j |∇E(δq) − Σ Jᵀλ|_j with E of (S.1) and the reported torques of the motors, and the worst violation of the cones, recomputed from kinematics, contacts and
/// forces. Motors: largest difference of a torque from K(u − q⁺) cut off at the effort (S.15), as a stretch of the spring [rad, m].
struct Optimality {
  double stationarity = 0, primal = 0, dual = 0, complementarity = 0, motors = 0;
};

inline Optimality recompute(const world::Model& model, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const StepOptions& options,
                            const StepResult& r) {
  world::KinematicsWorkspace kinematics_work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, kinematics_work, kinematics);
  Eigen::VectorXd residual = Eigen::VectorXd::Zero(model.n_v());
  Eigen::VectorXd tau_u(model.n_vu());
  world::calc_gravity(model, kinematics, tau_u);
  residual.head(model.n_vu()) = -options.h * tau_u;
  for (std::size_t o = 0; o < model.objects().size(); ++o) {
    const auto& object = model.objects()[o];
    Eigen::MatrixXd M(object.n_v, object.n_v);
    world::calc_object_mass(model, kinematics, static_cast<int>(o), M);
    residual.segment(object.v_begin, object.n_v) +=
        r.epsilon[static_cast<Eigen::Index>(o)] / options.h * M * r.delta.segment(object.v_begin, object.n_v);
  }
  const Eigen::VectorXd q_a = q.tail(model.n_a());
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(model.n_v());  // of the terms that cancel, as in the solver's own residual
  Optimality out;
  for (int j = 0; j < model.n_a(); ++j) {
    const double limit = options.effort_limits ? model.effort()[j] : std::numeric_limits<double>::infinity();
    const double pull = model.stiffness()[j] * (u[j] - q_a[j] - r.delta[model.n_vu() + j]);
    residual[model.n_vu() + j] -= options.h * r.torque[j];
    out.motors = std::max(out.motors, std::abs(r.torque[j] - std::clamp(pull, -limit, limit)) / model.stiffness()[j]);
  }
  if (r.joint_friction.size() > 0) residual.head(model.n_vu()) -= options.h * r.joint_friction;
  for (const auto& c : r.contacts) {
    const auto& variables = model.supports()[static_cast<std::size_t>(model.pairs()[static_cast<std::size_t>(c.contact.pair)].support)];
    const auto k = variables.size();
    std::vector<double> J(3 * k);
    contact::calc_jacobian(model, kinematics, c.contact, J.data());
    Eigen::Vector3d v(c.contact.phi, 0, 0);
    for (std::size_t i = 0; i < k; ++i) {
      for (std::size_t row = 0; row < 3; ++row) {
        scale[variables[i]] += std::abs(J[row * k + i] * c.lambda[static_cast<Eigen::Index>(row)]);
        residual[variables[i]] -= J[row * k + i] * c.lambda[static_cast<Eigen::Index>(row)];
        v[static_cast<Eigen::Index>(row)] += J[row * k + i] * r.delta[variables[i]];
      }
    }
    const double mu = c.contact.friction * options.friction_scale;
    const bool planar = model.planar_axis().has_value();
    const double slip = planar ? std::abs(v[1]) : v.tail<2>().norm();
    out.primal = std::max(out.primal, mu * slip - v[0]);
    out.dual = std::max(out.dual, (planar ? std::abs(c.lambda[1]) : c.lambda.tail<2>().norm()) - mu * c.lambda[0]);
    const double work = planar ? v[0] * c.lambda[0] + v[1] * c.lambda[1] : v.dot(c.lambda);
    out.complementarity = std::max(out.complementarity, std::abs(work));
  }
  out.stationarity = residual.cwiseQuotient(scale).cwiseAbs().maxCoeff();
  return out;
}

}  // namespace stiction::dynamics::test
