#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "stiction/cone/simd.hpp"
#include "stiction/cone/solver.hpp"
#include "stiction/cone/state.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::cone {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void require_factor(const detail::State& s) {
  if (!s.has_factor) core::throw_invalid("work", "no factor", "a workspace after a Solved solve with Options::sensitivities");
}

void require_row(const char* name, int i, int n) {
  if (i < 0 || i >= n) core::throw_invalid(name, std::to_string(i), "a row in 0 … " + std::to_string(n - 1));
}

struct alignas(64) Batch {
  double x[kMaxTiles * kTile * 4];
};

}  // namespace

void apply_inverse(const Workspace& work, Eigen::Ref<Eigen::MatrixXd> X) {
  const detail::State& s = work.state();
  require_factor(s);
  const Layout& layout = *s.layout;
  core::require_size("X rows", X.rows(), layout.size());
  Batch batch;
  for (Eigen::Index first = 0; first < X.cols(); first += 4) {
    const int width = static_cast<int>(std::min<Eigen::Index>(4, X.cols() - first));
    std::fill_n(batch.x, layout.padded_size() * 4, 0.0);
    for (int c = 0; c < width; ++c) {
      for (int i = 0; i < layout.size(); ++i) batch.x[4 * layout.position(i) + c] = X(i, first + c);
    }
    s.factor.solve4(batch.x, 0);
    for (int c = 0; c < width; ++c) {
      for (int i = 0; i < layout.size(); ++i) X(i, first + c) = batch.x[4 * layout.position(i) + c];
    }
  }
}

void calc_inverse_columns(const Workspace& work, std::span<const int> variables, std::span<const double> scale,
                          Eigen::Ref<Eigen::MatrixXd> out) {
  const detail::State& s = work.state();
  require_factor(s);
  const Layout& layout = *s.layout;
  const int n = static_cast<int>(variables.size());
  core::require_size("scale", static_cast<long>(scale.size()), n);
  core::require_size("out rows", out.rows(), layout.size());
  core::require_size("out columns", out.cols(), n);
  for (const int v : variables) require_row("variables", v, layout.size());
  Batch batch;
  for (int first = 0; first < n; first += 4) {
    const int width = std::min(4, n - first);
    std::fill_n(batch.x, layout.padded_size() * 4, 0.0);
    int tile = layout.tiles();
    for (int c = 0; c < width; ++c) {
      const int v = variables[at(first + c)];
      batch.x[4 * layout.position(v) + c] = scale[at(first + c)];
      tile = std::min(tile, layout.tile(v));
    }
    s.factor.solve4(batch.x, tile);
    for (int c = 0; c < width; ++c) {
      for (int i = 0; i < layout.size(); ++i) out(i, first + c) = batch.x[4 * layout.position(i) + c];
    }
  }
}

ConeDerivative D_cone(const Workspace& work, int cone) {
  const detail::State& s = work.state();
  require_factor(s);
  require_row("cone", cone, s.n_cones);
  const int i = s.cone_place[at(cone)];
  const auto of = [i](const auto* member) {
    const double* v = detail::lane(member, i);
    return Eigen::Vector3d(v[0], v[4], v[8]);
  };
  const auto& group = s.cones.of(i);
  const double wz = of(group.lambda).squaredNorm();  // the scaled point has the digits that w₀z₀ + w₁ᵀz₁ loses at the boundary
  return {of(group.z) * std::sqrt(2 / wz), *detail::lane(group.z, i) / *detail::lane(group.w, i)};
}

double D_half_line(const Workspace& work, int half_line) {
  const detail::State& s = work.state();
  require_factor(s);
  require_row("half_line", half_line, s.n_lines);
  const int i = s.line_place[at(half_line)];
  const double v = *detail::lane(s.lines.of(i).v, i);
  return v * v;
}

double D_bound(const Workspace& work, int bound) {
  const detail::State& s = work.state();
  require_factor(s);
  require_row("bound", bound, s.n_bounds);
  const int i = s.bound_slot[at(bound)];
  const double v = *detail::lane(s.bounds.of(i).v, i);
  return v * v * *detail::lane(&s.bounds.of(i).hold, i);
}

}  // namespace stiction::cone
