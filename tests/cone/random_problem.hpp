#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "stiction/cone/problem.hpp"
#include "stiction/cone/solver.hpp"

namespace stiction::cone::test {

/// (C) as plain matrices: what the tests build, hand to the solver and recompute residuals from.
struct RawProblem {
  struct Row {
    std::uint64_t id = 0;
    std::vector<int> variables;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> G;  // 3×k, or 1×k for a half-line
    Eigen::VectorXd g;
    double sigma = 1e-3;
    Unit unit{};
  };
  struct Bound {
    std::uint64_t id = 0;
    int variable = 0;
    double sign = 1;
    double offset = 0;
    double sigma = 1e-3;
    Unit unit{};
    double give = 0;
  };
  int n = 0;
  std::vector<std::vector<int>> groups;
  Eigen::MatrixXd Q;
  Eigen::VectorXd b;
  std::vector<Row> cones, lines;
  std::vector<Bound> bounds;
  std::vector<Unit> units = {};  // of x; empty: 1

  /// The same problem in other units: x(j) = of_x(j)·x', w = w'/of_w per row, objective times `work`.
  RawProblem rescaled(const Eigen::VectorXd& of_x, const Eigen::VectorXd& of_w, double work) const;
  Problem make() const;
  /// The same rows and Q, b in an existing problem of the same layout (same supports).
  void fill(Problem& problem) const;
  /// All rows stacked: cones (3 each), half-lines, bounds.
  Eigen::MatrixXd stacked_G() const;
  Eigen::VectorXd stacked_g() const;
  /// Of w = Gx + g + give·z, 0 but for bounds that give.
  Eigen::VectorXd stacked_give() const;
};

/// Stacked as RawProblem::stacked_G.
Eigen::VectorXd stacked_w(const Result& result);
Eigen::VectorXd stacked_z(const Result& result);

/// What is wrong with a solution, from the raw matrices alone; w is recomputed as Gx + g (+ give·z of bounds that give).
struct Kkt {
  double stationarity = 0;     // docs/theory/cone.md eq. 12
  double cone = 0;             // distance of Gx + g outside K / max(1, |g|), and of z outside K
  double consistency = 0;      // |w − Gx − g| / max(1, |g|)
  double complementarity = 0;  // Exact: max wᵀz / max(1, ‖b‖∞). Smoothed: max ‖w∘z − σe‖∞/σ. With the returned w.
};
Kkt recompute(const RawProblem& raw, const Result& result, Mode mode);

/// −gᵀz − 10‖Gᵀz‖₁ (+ 1e-6 Σz₀ in Smoothed mode) of the returned z relative to |g|ᵀ|z|, and how far z leaves the cones; without bounds that give.
struct Certificate {
  double margin = 0;
  double cone = 0;
};
Certificate check_certificate(const RawProblem& raw, const Result& result, Mode mode);

struct RandomOptions {
  int max_contacts = 60;
  double mass_decades = 6;  // objects weigh 10^±(decades/2) kg
  double deep = 0.1;        // part of contacts that start in deep penetration (to −0.2 m)
  double duplicate = 0.15;  // part of contacts that repeat an earlier one
  double frictionless = 0.1;
  bool planar = true;  // also problems whose contacts are pairs of half-lines
  bool cones = true;
  double saturating = 0;  // part of springs whose pull is bounded on one side
};
/// Robots (springs) and free bodies with random contacts, joint limits, redundancy and degeneracy.
RawProblem make_random(std::uint64_t seed, const RandomOptions& options = {});

}  // namespace stiction::cone::test
