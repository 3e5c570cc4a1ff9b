#pragma once

#include <Eigen/Core>
#include <atomic>
#include <memory>
#include <span>

#include "stiction/cone/columns.hpp"
#include "stiction/cone/problem.hpp"
#include "stiction/core/status.hpp"

namespace stiction::cone {

/// Where to stop on the central path. Exact: at σ → 0, ignoring the σ of the rows. Smoothed: at the σ of each row.
enum class Mode {
  Exact,
  Smoothed
};

struct Options {
  Mode mode = Mode::Exact;
  /// Exact: largest wᵢᵀzᵢ / S in units of work of the row (Unit) [-], in [1e-12, 1e-2]; S = max(1, ‖b‖∞ in its units) rounded down to a
  /// power of 2. Smoothed: largest ‖wᵢ∘zᵢ − σᵢe‖∞/σᵢ [-]; up to ten times that is accepted if rounding stops Newton's method.
  double tol_complementarity = 1e-9;
  double tol_kkt = 1e-8;    ///< largest scaled stationarity and primal residual [-], in [1e-12, 1e-2]
  int max_iterations = 80;  ///< factorisations per attempt (there are at most three attempts: warm, cold, far), ≥ 1
  bool warm_start = true;   ///< start from the values that the Workspace remembers for rows with the same id
  /// Smoothed: start at this x instead of the remembered values; null: not given. A start at the solution itself leaves nothing to do.
  const Eigen::VectorXd* x_near = nullptr;
  /// Leave a factor of H at the returned point, for apply_inverse and D_*. In Exact mode this also centres the point at
  /// wᵢ∘zᵢ = θᵢ·S·tol_complementarity/20 (in units of work), which costs one or two iterations and makes x a smooth function of the data.
  bool sensitivities = true;
  /// Exact: uses Gx + g + ‖(w₁, w₂)‖e₀ instead of Gx + g in every cone, De Saxcé's change of variables (docs/theory/cone.md, eq. 18). The
  /// shift follows the iterates and is constant at the end. The result solves the convex program with Result::shift_cone to tolerance. The
  /// caller must judge how far shift_cone is from ‖(w₁, w₂)‖. Derivatives treat the shift as constant.
  bool shift_by_tangent = false;
  double infeasible_radius = 10;  ///< Infeasible means: no feasible x with ‖x‖∞ ≤ this, x in its units [-], > 0
  const std::atomic<bool>* cancel = nullptr;
  void validate() const;  ///< @throws InvalidInput naming the field
};

/// Residuals, recomputed from the raw data at the returned point (docs/theory/cone.md, eq. 12–15).
struct Residuals {
  double stationarity = 0;     ///< max_j |Qx + b − Gᵀz|ⱼ / max(1, |b|ⱼ, |Qx|ⱼ, Σᵢ|Gᵢⱼzᵢ|), in units of row j
  double primal = 0;           ///< max |w − Gx − g| / max(1, |g|), in lengths of the row
  double complementarity = 0;  ///< as Options::tol_complementarity
  double cone = 0;             ///< largest distance by which w or z leaves its cone (0 for an interior point)
};

struct Result {
  core::Status status = core::Status::NumericalFailure;
  Eigen::VectorXd x;          ///< n
  Columns<3> w_cone, z_cone;  ///< 3 × n_cones; w = Gx + g and its multiplier, in order of adding
  Numbers shift_cone;         ///< n_cones; w₀ − (Gx + g)₀; 0 without Options::shift_by_tangent
  Numbers w_half_line, z_half_line;
  Numbers w_bound, z_bound;
  Residuals residuals;
  int iterations = 0;         ///< factorisations, all attempts together
  bool warm_started = false;  ///< the successful attempt started from remembered rows
};

namespace detail {
struct State;
}

/// Scratch, factor and warm-start memory of one thread. No heap use in solve() once it has seen the largest problem.
class Workspace {
 public:
  explicit Workspace(std::shared_ptr<const Layout> layout);
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

  /// Drops the memory for warm starts.
  void forget();

  const Layout& layout() const;
  detail::State& state() { return *state_; }              ///< for the implementation
  const detail::State& state() const { return *state_; }  ///< for the implementation

 private:
  std::unique_ptr<detail::State> state_;
};

/// Solves (C):  min ½xᵀQx + bᵀx  s.t.  wᵢ = Gᵢx + gᵢ ∈ Kᵢ,  by following its central path
///   Qx + b − ΣGᵢᵀzᵢ = 0,  wᵢ∘zᵢ = σᵢe,  wᵢ, zᵢ ∈ Kᵢ                                                              (P)
/// to σ → 0 (Exact) or to the σ of each row (Smoothed).
///
/// @param work  workspace with the same Layout as the problem
/// @returns Solved: residuals within tolerance. MaxIterations, Cancelled: `result` is the last iterate, residuals say how good.
///          Infeasible: result.z_* is a certificate, z ∈ K with −gᵀz > radius·‖Gᵀz‖₁, so no ‖x‖∞ ≤ radius is feasible;
///          in Smoothed mode −gᵀz > radius·‖Gᵀz‖₁ − 1e-6·Σz₀ℓ: no such x has all slacks above 1e-6 lengths ℓ, so there is no central path.
///          NumericalFailure: Q not positive definite on the rows' null space, or arithmetic broke down.
/// @throws InvalidInput: options out of range, layouts differ, or a row with sigma = 0 in Smoothed mode
/// Limits:  no rows → x = −Q⁻¹b in one iteration; one spring k against a wall, smoothed: w(w + u) = σ/k (tests/cone/analytic_test.cpp)
/// Source:  docs/theory/cone.md; Nesterov & Todd 1997; Vandenberghe 2010
[[nodiscard]] core::Status solve(const Problem& problem, const Options& options, Workspace& work, Result& result);

/// X ← H⁻¹X with H = Q + Σ GᵢᵀDᵢGᵢ at the point of the last solve, Dᵢ = −∂zᵢ/∂wᵢ on (P) (docs/theory/cone.md, eq. 16).
/// @param X  n × k. No heap use.
/// @throws InvalidInput: wrong number of rows, or the last solve was not Solved with Options::sensitivities
void apply_inverse(const Workspace& work, Eigen::Ref<Eigen::MatrixXd> X);

/// out.col(k) = scale[k] · H⁻¹ e_{variables[k]}; cheaper than apply_inverse on a matrix of unit vectors.
/// @param out  n × variables.size()
void calc_inverse_columns(const Workspace& work, std::span<const int> variables, std::span<const double> scale,
                          Eigen::Ref<Eigen::MatrixXd> out);

/// D = −∂z/∂w ⪰ 0 of a cone, in two parts. In an exact solve s sᵀ grows with z²/σ, so the other part would lose its digits if both were
/// stored in one matrix (docs/theory/cone.md, eq. 17).
struct ConeDerivative {
  Eigen::Vector3d sharp;  ///< s = z√(2/wᵀz)
  double round = 0;       ///< z₀/w₀
  Eigen::Matrix3d matrix() const {
    return sharp * sharp.transpose() - Eigen::Matrix3d(Eigen::Vector3d(round, -round, -round).asDiagonal());
  }
};

/// Dᵢ = −∂zᵢ/∂wᵢ of a row at the point of the last solve. Rows are numbered in order of adding. @throws as apply_inverse
ConeDerivative D_cone(const Workspace& work, int cone);
double D_half_line(const Workspace& work, int half_line);
double D_bound(const Workspace& work, int bound);

}  // namespace stiction::cone
