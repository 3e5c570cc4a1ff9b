#pragma once

#include <cstddef>

#include "stiction/cone/arrangement.hpp"
#include "stiction/cone/rows.hpp"
#include "stiction/cone/scaling.hpp"

// Internal to the layer: one attempt of the interior-point method from one start. Starts are in start.cpp, Newton directions and steps in
// direction.cpp, residuals, shifts and the loop in solver.cpp.

namespace stiction::cone::detail {

inline constexpr double kColdSlack = 3e-3;  // smallest slack of w, in lengths of the row

inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

template <class B, class F>
inline void each_group(B& bank, F&& f) {
  auto* group = bank.group.data();
  for (const auto* end = group + bank.groups; group != end; ++group) f(*group);
}

class Attempt {
 public:
  Attempt(const Problem& problem, const Options& options, State& s)
      : problem_(problem),
        options_(options),
        s_(s),
        layout_(*s.layout),
        smoothed_(options.mode == Mode::Smoothed),
        n_rows_(problem.n_cones() + problem.n_half_lines() + problem.n_bounds()) {
    const double *b = problem.b_padded(), *unit = problem.gradient_padded();
    for (int i = 0; i < layout_.padded_size(); ++i) impulse_ = std::max(impulse_, std::abs(b[i]) / unit[i]);
    impulse_ = std::exp2(std::floor(std::log2(impulse_)));  // constant in b almost everywhere, as derivatives need
  }

  /// @param careful  refine every direction (slower)
  void start_cold(double least_slack, bool careful);
  bool try_start_warm();
  bool try_start_at(const Eigen::VectorXd& x);  ///< Smoothed: starts at x with each row on its central path
  core::Status run(int& iterations);
  void leave_factor();
  const Residuals& residuals() const { return residuals_; }
  bool infeasible_proved() const { return infeasible_; }

 private:
  template <class F>
  void for_each_group(F&& f) {
    each_group(s_.cones, f);
    each_group(s_.lines, f);
    each_group(s_.bounds, f);
  }
  void start_giving(int bound, double gx, double centre);
  template <class Visit>
  void start_at_x(double centre, Visit&& visit);
  void blunt();
  bool sharpen();
  Spread scale();
  void build();
  void calc_gradient();
  void subtract_product(const double* v, double* out) const;
  bool factorise();
  template <class Member>
  void add_all_transposed(Member&& member, double* out) const;
  template <class F>
  void for_each_product(const double* dx, F&& f);
  void refine(double* dx);
  void set_rhs(double t, bool corrector, double reduction);
  double finish_direction(double t, bool corrector, double reduction);
  double calc_direction(double t, bool corrector, double reduction);
  double shorten(double alpha, double t);
  void move(double alpha, double reduction);
  void release_residual();
  void follow_tangents();
  void anticipate_tangents(double alpha);
  bool measure();
  bool prove_infeasible();
  bool step();
  void remember_z();

  const Problem& problem_;
  const Options& options_;
  State& s_;
  const Layout& layout_;
  bool smoothed_;
  int n_rows_;
  double t_ = 0;        // position of the iterate on the central path: mean of wᵀz / weight
  double t_end_ = 0;    // target of t_
  double impulse_ = 1;  // S = max(1, ‖b/unit‖∞) rounded down to a power of 2, the scale of complementarity in Exact mode
  double primal_ = 0;   // r_p = primal_ · (stored r_p)
  // Share of Mehrotra's second-order term in the corrector. The term belongs to a whole predictor step. After short ones all of it can make the iterates
  // cycle, so a careful attempt takes the share of the step.
  double second_order_ = 1;
  Residuals residuals_;
  bool infeasible_ = false;
  bool careful_ = false;
  bool centred_ = false;    // the last step was a centring step of good length
  bool following_ = false;  // shifts follow the iterates
  double sharpness_ = 0;    // Smoothed: smallest σ of soft bounds
};

}  // namespace stiction::cone::detail
