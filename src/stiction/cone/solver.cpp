#include "stiction/cone/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "stiction/cone/attempt.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::cone {
namespace detail {
namespace {

constexpr double kFarSlack = 1.0;          // slack of the retry
constexpr double kWarmMemory = 1e-5;       // z is remembered when t falls below this
constexpr double kNoInterior = 1e-6;       // smallest slack that counts as an interior, in lengths of the row
constexpr double kCentreTolerance = 1e-7;  // relative, of the centred end point in Exact mode
constexpr double kShiftEnd = 100;          // shifts follow the iterates until t falls below this times the tolerance
constexpr double kLeastShiftEnd = 1e-7;    // smallest t at which the shifts stop following
constexpr int kShiftIterations = 30;       // largest number of iterations for which the shifts follow
constexpr double kShiftSlack = 0.5;        // part of the slack that a decreasing shift may take from w; r_p takes the rest
constexpr double kSharpenFrom = 0.5;       // largest relative distance from the centre at which σ of soft bounds is reduced
constexpr double kSharpen = 0.1;           // factor of this reduction
constexpr double kExactEnd = 0.05;         // centred end point in Exact mode, as a part of the tolerance

}  // namespace

using core::Status;

/// Computes the residuals from raw data. @returns true if stationarity and primal residual are within tolerance. If the primal residual is
/// not, r_p is set from the raw data.
bool Attempt::measure() {
  const int padded = layout_.padded_size();
  std::ranges::fill(s_.scratch, 0.0);
  std::ranges::fill(s_.scale, 0.0);
  double* gtz = s_.scratch.data();
  double* size = s_.scale.data();
  V4 primal_lanes{};
  const auto look = [&primal_lanes]<int R>(Group<R>& group, const Element<R>& gx) {
    V4 scale = group.length, largest_off{};
    for (int r = 0; r < R; ++r) {
      scale = max(abs(group.g[r]), scale);
      const V4 off = (group.w[r] - (gx.e[r] + group.g[r])) * group.live;
      group.r_p[r] = off;
      largest_off = max(largest_off, abs(off));
    }
    primal_lanes = max(primal_lanes, largest_off / scale);
  };
  const auto general = [&]<int R>(GeneralBank<R>& b, const Problem::Rows& rows) {
    for (int g = 0; g < b.groups; ++g) look(b.group[at(g)], multiply_raw_group<R>(b, rows, g, s_.x.data()));
    for (int i = 0; i < b.n; ++i) add_transposed_raw<R>(b, rows, i, gtz, size);
  };
  general(s_.cones, problem_.cones());
  general(s_.lines, problem_.half_lines());
  for (int g = 0; g < s_.bounds.groups; ++g) {
    Group<1>& group = s_.bounds.group[at(g)];
    const int position = 4 * s_.bound_tile[at(g)];
    const V4 sign = load(s_.bound_sign.data() + 4 * g);
    look(group, Element<1>{{sign * load(s_.x.data() + position) + group.give * group.z[0]}});
    store(gtz + position, load(gtz + position) + sign * group.z[0]);
    store(size + position, load(size + position) + group.live * group.z[0]);
  }
  V4 stationarity_lanes{};
  for (int i = 0; i < padded; i += 4) {
    const V4 b = load(problem_.b_padded() + i);
    const V4 minus = load(s_.gradient.data() + i);  // −(Qx + b)
    const V4 scale = max(max(abs(b), abs(minus + b)), max(load(size + i), load(problem_.gradient_padded() + i)));
    stationarity_lanes = max(stationarity_lanes, abs(minus + load(gtz + i)) / scale);
  }
  const double stationarity = largest(stationarity_lanes), primal = largest(primal_lanes);
  residuals_.stationarity = stationarity;
  residuals_.primal = primal;
  primal_ = primal > 0 ? 1.0 : 0.0;
  return stationarity <= options_.tol_kkt && primal <= options_.tol_kkt;
}

/// True if −gᵀz > radius·‖Gᵀz‖₁: no x with ‖x‖∞ ≤ radius is feasible (eq. 11). In Smoothed mode it is enough that no such x has all slacks
/// above 1e-6 of the row's length, because the central path needs an interior. Soft bounds are always feasible and are left out. Call this
/// after measure(), which leaves Gᵀz in scratch.
bool Attempt::prove_infeasible() {
  double gz = 0, norm = 0, size = 0;  // size: Σ z₀ℓ
  for (int i = 0; i < s_.n_cones; ++i) {
    const double* z = lane(s_.cones.of(i).z, i);
    for (int r = 0; r < 3; ++r) gz += problem_.cones().g[at(3 * s_.cones.order[at(i)] + r)] * z[4 * r];
    size += z[0] * *lane(&s_.cones.of(i).length, i);
  }
  for (int i = 0; i < s_.n_lines; ++i) {
    const double z = *lane(s_.lines.of(i).z, i);
    gz += problem_.half_lines().g[at(s_.lines.order[at(i)])] * z;
    size += z * *lane(&s_.lines.of(i).length, i);
  }
  for (int k = 0; k < s_.n_bounds; ++k) {
    const int i = s_.bound_slot[at(k)];
    const double z = *lane(s_.bounds.of(i).z, i);
    if (*lane(&s_.bounds.of(i).give, i) > 0) {
      s_.scratch[at(4 * s_.bound_tile[at(i / 4)] + i % 4)] -= s_.bound_sign[at(i)] * z;
      continue;
    }
    gz += problem_.bound_groups()[at(i / 4)].offset[i % 4] * z;
    size += z * *lane(&s_.bounds.of(i).length, i);
  }
  for (int i = 0; i < layout_.padded_size(); ++i) norm += std::abs(s_.scratch[at(i)]) * problem_.length_padded()[i];
  return -gz > options_.infeasible_radius * norm - (smoothed_ ? kNoInterior * size : 0.0);
}

void Attempt::remember_z() {
  for_each_group([&]<int R>(Group<R>& group) {
    for (int r = 0; r < R; ++r) group.z_saved[r] = group.z[r];
  });
}

/// Stores r_p itself, primal_ = 1.
void Attempt::release_residual() {
  for_each_group([&]<int R>(Group<R>& group) {
    for (auto& r : group.r_p) r *= all(primal_);
  });
  primal_ = 1.0;
}

/// Sets the shift to ‖(w₁, w₂)‖ in every cone (eq. 18). If the shift grows, w₀ grows by the same amount, and the point stays interior and
/// feasible. If the shift shrinks, w₀ shrinks as far as the slack allows, and the rest becomes primal residual.
void Attempt::follow_tangents() {
  const bool feasible = primal_ == 0;
  release_residual();
  V4 off{};
  each_group(s_.cones, [&off](Group<3>& group) {
    const V4 tangent = sqrt(group.w[1] * group.w[1] + group.w[2] * group.w[2]);
    const V4 change = (tangent - group.shift) * group.live;
    const V4 taken = max(change, (tangent - group.w[0]) * all(kShiftSlack));
    group.shift += change;
    group.g[0] += change;
    group.w[0] += taken;
    group.r_p[0] += taken - change;
    off = max(off, abs(group.r_p[0]));
  });
  if (feasible && !(largest(off) > 0)) primal_ = 0.0;
}

/// Sets the shift of every cone to ‖(w₁, w₂)‖ after a step α along the predictor, now in u. The corrector then aims for the shift that its
/// own step will need. The point and its scaling stay; the change of the shift becomes primal residual.
void Attempt::anticipate_tangents(double alpha) {
  release_residual();
  each_group(s_.cones, [alpha](Group<3>& group) {
    const auto du = apply<-1>(group.v, load_element<3>(group.u));
    const V4 r = group.ratio * alpha;
    const V4 w1 = group.w[1] + r * du.e[1], w2 = group.w[2] + r * du.e[2];
    const V4 change = (sqrt(w1 * w1 + w2 * w2) - group.shift) * group.live;
    group.shift += change;
    group.g[0] += change;
    group.r_p[0] -= change;
  });
  for_each_group([]<int R>(Group<R>& group) { scale_primal_residual<R>(group, 1.0); });
}

/// Smoothed: σ of soft bounds starts at the largest σ of all rows, where the central path is easy to follow. sharpen() reduces it later.
void Attempt::blunt() {
  if (!smoothed_ || !s_.gives) return;
  V4 largest_weight{};
  for_each_group([&](const auto& group) { largest_weight = max(largest_weight, group.weight); });
  sharpness_ = largest(largest_weight) / kSharpen;
  sharpen();
}

/// Smoothed: reduces σ of soft bounds. @returns false when every row has its own σ
bool Attempt::sharpen() {
  if (sharpness_ == 0) return false;
  sharpness_ *= kSharpen;
  bool any = false;
  for (int k = 0; k < s_.n_bounds; ++k) {
    const int i = s_.bound_slot[at(k)];
    Group<1>& group = s_.bounds.of(i);
    if (*lane(&group.give, i) == 0) continue;
    const double own = problem_.bound_groups()[at(i / 4)].sigma[i % 4];
    *lane(&group.weight, i) = std::max(own, sharpness_);
    *lane(&group.inv_weight, i) = 1 / *lane(&group.weight, i);
    any = any || sharpness_ > own;
  }
  if (!any) sharpness_ = 0;
  return any;
}

Status Attempt::run(int& iterations) {
  const bool centred = smoothed_ || options_.sensitivities || careful_;
  t_end_ = smoothed_ ? 1.0 : (centred ? kExactEnd * options_.tol_complementarity * impulse_ : 0.0);
  const double tolerance = options_.tol_complementarity, shift_end = std::max(kLeastShiftEnd, kShiftEnd * tolerance);
  remember_z();
  calc_gradient();
  centred_ = false;
  int polish = 0;
  double last_off = std::numeric_limits<double>::infinity();
  for (int iteration = 0;; ++iteration) {
    following_ = options_.shift_by_tangent && iteration <= kShiftIterations && (iteration == 0 || t_ >= shift_end * impulse_);
    if (following_ && iteration > 0) follow_tangents();
    Spread spread = scale();
    if (sharpness_ > 0 && largest(spread.off) <= kSharpenFrom) {
      sharpen();
      spread = scale();
    }
    t_ = n_rows_ > 0 ? sum(spread.mean) / n_rows_ : 0.0;
    const double worst = largest(spread.worst) / impulse_;
    const double off = largest(spread.off);
    residuals_.complementarity = smoothed_ ? off : worst;
    if (!(t_ >= 0) || !std::isfinite(t_) || !std::isfinite(largest(spread.off))) return Status::NumericalFailure;
    if (!smoothed_ && t_ >= kWarmMemory * impulse_) remember_z();
    // Rounding of w∘z can keep a sharp row just above the tolerance. Two iterates within ten times the tolerance are then accepted.
    const bool close = smoothed_ ? sharpness_ == 0 && (off <= tolerance || std::max(off, last_off) <= 10 * tolerance) : worst <= tolerance;
    last_off = off;
    const bool good = close && measure();
    if (good) {
      const bool at_centre = smoothed_ || !centred || n_rows_ == 0 || off <= kCentreTolerance * t_end_;
      if (at_centre || ++polish > 6) return Status::Solved;
    }
    if (options_.cancel != nullptr && options_.cancel->load(std::memory_order_relaxed)) {
      (void)measure();
      return Status::Cancelled;
    }
    if (iteration >= 8 && primal_ != 0 && iteration % 2 == 0) {
      (void)measure();
      if (prove_infeasible()) {
        infeasible_ = true;
        return Status::Infeasible;
      }
    }
    if (iteration == options_.max_iterations) {
      (void)measure();
      return Status::MaxIterations;
    }
    build();
    set_rhs(t_end_, false, 1.0);
    ++iterations;
    if (!factorise() || !step()) return good ? Status::Solved : Status::NumericalFailure;
  }
}

/// Factorises H at the final point, in the scaling that scale() has just computed.
void Attempt::leave_factor() {
  build();
  std::ranges::fill(s_.dx, 0.0);
  s_.has_factor = factorise();
}

}  // namespace detail

void Options::validate() const {
  const auto text = [](double x) {
    std::ostringstream out;
    out << x;
    return out.str();
  };
  const auto in = [&](const char* field, double value, double low, double high) {
    if (!(value >= low && value <= high)) {
      core::throw_invalid(field, text(value), "a number in [" + text(low) + ", " + text(high) + "]");
    }
  };
  in("tol_complementarity", tol_complementarity, 1e-12, 1e-2);
  in("tol_kkt", tol_kkt, 1e-12, 1e-2);
  if (shift_by_tangent && mode != Mode::Exact) core::throw_invalid("shift_by_tangent", "true", "false in Smoothed mode");
  if (max_iterations < 1) core::throw_invalid("max_iterations", std::to_string(max_iterations), "at least 1");
  core::require_positive("infeasible_radius", infeasible_radius);
}

core::Status solve(const Problem& problem, const Options& options, Workspace& work, Result& result) {
  using core::Status;
  options.validate();
  detail::State& s = work.state();
  if (problem.layout_ptr() != s.layout) core::throw_invalid("work", "a workspace of another layout", "the layout of the problem");
  s.has_factor = false;
  detail::prepare(problem, options, s);
  detail::Attempt attempt(problem, options, s);
  result.iterations = 0;
  result.warm_started = options.x_near != nullptr ? attempt.try_start_at(*options.x_near) : options.warm_start && attempt.try_start_warm();
  Status status = Status::NumericalFailure;
  const auto done = [&status] { return status == Status::Solved || status == Status::Cancelled; };
  if (result.warm_started) {
    status = attempt.run(result.iterations);
    if (!done()) result.warm_started = false;
  }
  for (const double slack : {detail::kColdSlack, detail::kFarSlack}) {
    if (done()) break;
    attempt.start_cold(slack, slack == detail::kFarSlack);
    status = attempt.run(result.iterations);
    if (status == Status::Infeasible) break;
  }
  if (status == Status::Solved) {
    if (options.sensitivities) attempt.leave_factor();
    detail::remember(problem, options, s);
  } else {
    s.memory.valid = false;
  }
  result.residuals = attempt.residuals();
  result.residuals.cone = std::max(0.0, detail::write_result(problem, s, result));
  result.status = status;
  return status;
}

}  // namespace stiction::cone
