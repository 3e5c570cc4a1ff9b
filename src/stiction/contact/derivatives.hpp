#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/contact/contact.hpp"

namespace stiction::contact {

/// Derivatives of contacts by the configuration, with k the number of coordinates in the support of the pair.
struct ContactDerivatives {
  std::vector<double> D_tau_q;  ///< of τ_c = J_cᵀλ: contact i has k·k numbers from begin[i], row-major
  std::vector<double> D_w_q;    ///< of w_c = φ e₁ + J_c δq: 3·k numbers from Jacobians::begin[i], row-major as J_c
  std::vector<int> begin;       ///< n_c + 1 numbers
  std::vector<double> scratch;
};

/// For each contact the derivatives, through retract, of
///
///     τ_c(q) = J_c(q)ᵀ λ   (k)        w_c(q) = φ(q) e₁ + J_c(q) δq   (3)
///
/// at fixed components of λ and δq: the components turn with the contact frame and with the tangent space at q.
/// Witness points and normal move with the curvature of both surfaces, the frame with the normal, the axes with the bodies below them.
/// O(k²) for each contact; no heap use once `out` has its size.
///
/// Exact where the distance has second derivatives. At a kink: the derivative of the feature that the witness point lies on (a vertex
/// before an edge before a face); where two flat features lie on each other without a patch, the point of A stays where it is on A, and
/// the normal stays with B. Points of patches move as their kind says.
/// @param J       of the same contacts
/// @param lambda  impulse of each contact (n, t1, t2)
/// @param delta   δq (n_v)
/// @param wanted  contacts to look at, empty for all; the numbers of the others are left as they are
/// @throws core::InvalidInput: sizes that do not fit
/// Source: docs/theory/contact.md §8. Tests: tests/contact/derivatives_test.cpp
void calc_derivatives(const world::Model& model, const world::Kinematics& kinematics, std::span<const Contact> contacts, const Jacobians& J,
                      std::span<const Eigen::Vector3d> lambda, const Eigen::VectorXd& delta, std::span<const char> wanted, Workspace& work,
                      ContactDerivatives& out);

}  // namespace stiction::contact
