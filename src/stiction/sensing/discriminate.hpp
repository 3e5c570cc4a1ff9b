#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "stiction/core/status.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::sensing {

/// Options of discriminate(), which seeks a small joint motion that pulls away from some of the contact candidates and pushes into the
/// others, so that the change of the torques refutes one of the two groups. Lengths are motions of a point along its normal.
struct DiscriminationOptions {
  double joint_step = 0.05;        ///< δ_q^max (4.13e) [rad or m], > 0
  std::optional<double> travel{};  ///< largest motion at a contact [m], > 0; nullopt: a tenth of joint_step times the longest reach
  double least = 0.1;              ///< ε^min of pulling and pushing, share of travel, in (0, 1)
  double sideways = 0.5;           ///< r_orth (4.13d), share of travel, > 0
  void validate() const;           ///< @throws core::InvalidInput naming the field
};

/// Two-sided rows lower ≤ C x ≤ upper.
struct LinearRows {
  Eigen::MatrixXd C;
  Eigen::VectorXd lower, upper;
};

/// A point that satisfies the rows, or Farkas weights y that prove there is none: Cᵀy = 0 and
/// Σ_{y>0} y_i lower_i + Σ_{y<0} y_i upper_i > 0, although the sum would be ≤ yᵀC x = 0 for every point that satisfies the rows.
/// Found as the minimum of half the sum of squared violations, a convex piecewise quadratic function, by Newton's method; at a minimum > 0
/// the violations themselves are such weights.  (Y.7)
struct Feasibility {
  bool feasible = false;
  Eigen::VectorXd x;
  Eigen::VectorXd weights;  ///< y, if not feasible
};
/// Solves (Y.7). @param tolerance  violations up to this share of the largest bound count as none
Feasibility find_feasible(const LinearRows& rows, double tolerance = 1e-9);

/// Signs b_i that no allowed motion produces; −1: still open.
struct RefutedSigns {
  std::vector<int> signs;
  Eigen::VectorXd weights;  ///< Farkas weights of its rows
};

/// Rows (4.13b) to (4.13e) of signs b_i ∈ {0, 1, −1 open} in units of travel and joint_step: d_i = n_iᵀ J_i δq of each contact, the three
/// components of its sideways motion, the joints.
LinearRows make_rows(const Eigen::Matrix3Xd& normals, std::span<const Eigen::Matrix3Xd> jacobians, double travel,
                     const DiscriminationOptions& options, std::span<const int> signs);

struct Discrimination {
  core::Status status = core::Status::NumericalFailure;
  Eigen::VectorXd dq;                     ///< δq (n_a)
  std::vector<int> pull;                  ///< b_i: 1 pull away, 0 push into
  int objective = 0;                      ///< |Σ b_i − ⌊N/2⌋| (4.13a)
  long nodes = 0;                         ///< number of linear programs solved
  std::vector<RefutedSigns> certificate;  ///< proofs for the excluded signs; if Infeasible they cover every informative b
};

/// The program (4.13) by branch and bound over b, exact: sums Σ b_i in the order of the objective (4.13a), each a tree over signs whose nodes
/// are linear programs, with the rows of contacts not yet decided relaxed to −ε_pull^max ≤ d_i ≤ ε_push^max. For N ≥ 2
/// contacts, a motion must pull from at least one and push into at least one; other motions carry no information.
/// @param normals  outward, in W (3 × N)  @param jacobians  point Jacobians in W (3 × n_a), N of them
/// @returns Solved, or Infeasible: `certificate` then proves it
core::Status discriminate(const Eigen::Matrix3Xd& normals, std::span<const Eigen::Matrix3Xd> jacobians, double travel,
                          const DiscriminationOptions& options, Discrimination& out);

/// The same for candidates of sense() at q.
core::Status discriminate(const Sensor& sensor, VectorRef q, std::span<const Candidate> candidates, const DiscriminationOptions& options,
                          Discrimination& out);

}  // namespace stiction::sensing
