#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "stiction/contact/contact.hpp"

namespace stiction::contact {

/// Derivatives of contacts with respect to the configuration. k is the number of coordinates in the support of the pair.
struct ContactDerivatives {
  std::vector<double> D_tau_q;  ///< derivative of τ_c = J_cᵀλ: contact i has k·k numbers from begin[i], row-major
  std::vector<double> D_w_q;    ///< derivative of w_c = φ e₁ + J_c δq: 3·k numbers from Jacobians::begin[i], row-major as J_c
  std::vector<int> begin;       ///< n_c + 1 numbers
  std::vector<double> scratch;
};

/// Computes for each contact the derivatives, through retract, of
///
///     τ_c(q) = J_c(q)ᵀ λ   (k)        w_c(q) = φ(q) e₁ + J_c(q) δq   (3)
///
/// at fixed components of λ and δq: the components turn with the contact frame and with the tangent space at q.
/// The witness points and the normal move with the curvature of both surfaces, the frame with the normal, and the joint axes with the
/// bodies that carry them. The cost is O(k²) for each contact; no heap use once `out` has its size.
///
/// The result is exact if the distance has second derivatives. At a kink it is the derivative for the feature on which the witness point
/// lies (a vertex before an edge before a face). If two flat features lie on each other without a patch, the witness point stays fixed on A
/// and the normal stays fixed to B. Points of patches move according to their PatchPoint.
/// @param J       Jacobians of the same contacts
/// @param lambda  impulse of each contact (n, t1, t2)
/// @param delta   δq (n_v)
/// @param wanted  flag per contact: which to compute, empty for all; the numbers of the others are left unchanged
/// @throws core::InvalidInput: sizes that do not fit
/// Source: docs/theory/contact.md §8. Tests: tests/contact/derivatives_test.cpp
void calc_derivatives(const world::Model& model, const world::Kinematics& kinematics, std::span<const Contact> contacts, const Jacobians& J,
                      std::span<const Eigen::Vector3d> lambda, const Eigen::VectorXd& delta, std::span<const char> wanted, Workspace& work,
                      ContactDerivatives& out);

}  // namespace stiction::contact
