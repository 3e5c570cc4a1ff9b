#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "stiction/cone/aligned.hpp"
#include "stiction/cone/layout.hpp"

namespace stiction::cone {

/// Units in which a row or a variable is measured, so that all numbers inside the method are dimensionless. Use powers of two; otherwise
/// the same problem in other units is rounded differently.
struct Unit {
  double length = 1;  ///< unit of w, or of x [unit of w or x]
  double work = 1;    ///< unit of wᵀz; work/length is the unit of z, and of Qx + b
};

/// The data of (C):  min ½xᵀQx + bᵀx  subject to  wᵢ = Gᵢx + gᵢ ∈ Kᵢ,  refilled at each step.
///
/// Kᵢ is the Lorentz cone L³ = {w₀ ≥ ‖(w₁,w₂)‖} (add_cone) or the half-line w ≥ 0 (add_half_line, and add_bound for a row with
/// a single ±1). Each row has an id, by which warm starts find it again, and the σ of its smoothed complementarity
/// w ∘ z = σe. No heap use while the row counts stay within the largest seen so far. Copyable.
/// Checked in tests/cone/problem_test.cpp.
class Problem {
 public:
  /// @param max_cones, max_half_lines  rows to reserve memory for, ≥ 0; more rows are accepted later and counted in growths()
  Problem(std::shared_ptr<const Layout> layout, int max_cones, int max_half_lines);

  const Layout& layout() const { return *layout_; }
  const std::shared_ptr<const Layout>& layout_ptr() const { return layout_; }

  /// Removes all rows and sets Q = 0, b = 0.
  void clear();

  /// Q(i,j) = Q(j,i) = v. @throws InvalidInput: index out of range, v not finite, or i and j in different groups
  void set_Q(int i, int j, double v);
  /// b(i) = v. @throws InvalidInput: index out of range or v not finite
  void set_b(int i, double v);

  /// Unit of x(i); kept by clear(), 1 before it is set. @throws InvalidInput: index out of range, or a unit not finite and > 0
  void set_unit(int i, Unit unit);

  /// Adds the row block Gx + g ∈ L³.
  /// @param id       stable name of the row between solves (warm start)
  /// @param support  index from Layout::add_support, of k variables
  /// @param G        3×k, row-major, columns in the order of the support
  /// @param g        3
  /// @param sigma    ≥ 0, w ∘ z = (σ,0,0) in Smoothed mode (= 2/κ for a barrier weight κ on the objective)
  /// @param unit     unit of the row; in Exact mode w∘z of the rows goes to 0 in proportion to their unit of work
  /// @returns        index among the cones, in order of adding
  /// @throws InvalidInput: unknown support, numbers not finite, sigma < 0, a unit not finite and > 0
  int add_cone(std::uint64_t id, int support, const double* G, const double* g, double sigma, Unit unit = {});
  /// Adds the row Gx + g ≥ 0; G is 1×k. sigma = 1/κ. Otherwise as add_cone. @returns index among the half-lines
  int add_half_line(std::uint64_t id, int support, const double* G, double g, double sigma, Unit unit = {});
  /// Adds sign·x(variable) + offset ≥ 0, sign = ±1. With give > 0 the bound is soft, sign·x + offset + give·z ≥ 0: a violation costs
  /// (·)²/(2 give) instead of being forbidden (docs/theory/soft_bounds.md, eq. 20).
  /// @param give  ≥ 0 [unit of w over that of z]
  /// @returns index among the bounds @throws InvalidInput: as add_cone, give < 0 or not finite
  int add_bound(std::uint64_t id, int variable, double sign, double offset, double sigma, Unit unit = {}, double give = 0);

  int n_cones() const { return cones_.n; }
  int n_half_lines() const { return lines_.n; }
  int n_bounds() const { return n_bounds_; }
  int growths() const { return growths_; }  ///< how often a buffer had to be enlarged after construction

  /// Rows of one kind with R components each, in order of adding. G of row i is [tile of its support][R][kTile] from
  /// G[offset[i]] on, with zeros at variables outside the support.
  struct Rows {
    int n = 0;
    std::vector<std::uint64_t> id;
    std::vector<int> support;
    std::vector<int> offset;
    std::vector<double> g;  ///< R per row
    std::vector<double> sigma;
    std::vector<Unit> unit;
    AlignedVector G;
    int used = 0;  ///< doubles used in G
  };
  /// Bounds of one tile, at most one per lane; lanes without a bound have sign 0.
  struct BoundGroup {
    int tile = 0;
    double sign[kTile] = {};
    double offset[kTile] = {};
    double sigma[kTile] = {};
    double give[kTile] = {};
    Unit unit[kTile] = {};
    int index[kTile] = {-1, -1, -1, -1};  ///< index of the bound, in order of adding
  };
  const Rows& cones() const { return cones_; }
  const Rows& half_lines() const { return lines_; }
  const std::vector<BoundGroup>& bound_groups() const { return bound_groups_; }
  int n_bound_groups() const { return n_bound_groups_; }
  std::uint64_t bound_id(int i) const { return bound_id_[static_cast<std::size_t>(i)]; }
  const double* Q_tiles() const { return Q_.data(); }  ///< as Layout::q_tiles(), each column-major; unit diagonal at padding
  const double* b_padded() const { return b_.data(); }
  const double* length_padded() const { return length_.data(); }      ///< units of x
  const double* gradient_padded() const { return gradient_.data(); }  ///< units of Qx + b

 private:
  int add_row(Rows& rows, int components, std::uint64_t id, int support, const double* G, const double* g, double sigma, Unit unit);

  std::shared_ptr<const Layout> layout_;
  AlignedVector Q_;
  AlignedVector b_, length_, gradient_;
  Rows cones_;
  Rows lines_;
  std::vector<BoundGroup> bound_groups_;
  int n_bound_groups_ = 0;
  std::vector<std::uint64_t> bound_id_;
  int n_bounds_ = 0;
  int growths_ = 0;
};

}  // namespace stiction::cone
