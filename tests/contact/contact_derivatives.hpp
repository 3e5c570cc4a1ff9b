#pragma once

#include <gtest/gtest.h>

#include <array>

#include "contact/scenes.hpp"
#include "stiction/contact/derivatives.hpp"

namespace stiction::contact::test {

inline constexpr double kTolerance = 1e-6;  // of the largest entry

/// The two functions that are differentiated, over all coordinates of the model.
struct Values {
  Eigen::VectorXd tau;  // J_cᵀλ (n_v)
  Vector3d w;           // φ e₁ + J_c δq
  int feature = 0;
};

/// The library's derivatives of one contact over all coordinates.
inline void calc_full(Fixture& s, const Contact& c, const Vector3d& lambda, const Eigen::VectorXd& delta, Eigen::MatrixXd& D_tau,
                      Eigen::MatrixXd& D_w) {
  Jacobians J;
  ContactDerivatives out;
  calc_jacobians(*s.model, s.kinematics, std::array{c}, s.work, J);
  calc_derivatives(*s.model, s.kinematics, std::array{c}, J, std::array{lambda}, delta, {}, s.work, out);
  const std::vector<int>& support = s.model->supports()[s.model->pairs()[c.pair].support];
  const std::size_t k = support.size();
  D_tau = Eigen::MatrixXd::Zero(s.model->n_v(), s.model->n_v());
  D_w = Eigen::MatrixXd::Zero(3, s.model->n_v());
  ASSERT_EQ(out.D_tau_q.size(), k * k);
  ASSERT_EQ(out.D_w_q.size(), 3 * k);
  for (std::size_t j = 0; j < k; ++j) {
    for (std::size_t i = 0; i < k; ++i) D_tau(support[i], support[j]) = out.D_tau_q[k * i + j];
    for (std::size_t r = 0; r < 3; ++r) D_w(static_cast<Eigen::Index>(r), support[j]) = out.D_w_q[r * k + j];
  }
}

inline double largest(const Eigen::MatrixXd& m) { return m.cwiseAbs().maxCoeff(); }

}  // namespace stiction::contact::test
