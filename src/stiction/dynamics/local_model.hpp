#pragma once

#include <cstdint>
#include <memory>

#include "stiction/core/run_control.hpp"
#include "stiction/dynamics/step.hpp"

namespace stiction::dynamics {

/// Gaussian disturbances w = (w_q, w_u) ~ N(0, diag(std²)) of a randomised scheme.
struct Sampling {
  Eigen::VectorXd std_q = Eigen::VectorXd::Zero(1);           ///< std of q in its tangent: n_v numbers or one for all [m, rad], ≥ 0
  Eigen::VectorXd std_u = Eigen::VectorXd::Constant(1, 0.1);  ///< std of u: n_a numbers or one for all [rad or m], ≥ 0
  int samples = 100;                                          ///< N, ≥ 1
  std::uint64_t seed = 0;                                     ///< sample i uses substream i of this seed
};

/// (2.22): the average of exact steps and their derivatives at N disturbed points.
struct RandomizedFirstOrder : Sampling {};

/// (2.23): least-squares fit to exact steps from N disturbed points; no derivatives.
struct RandomizedZerothOrder : Sampling {};

/// Schemes for a local model: (2.9) and the three schemes of §2.4.1.
using LocalModelScheme = std::variant<Exact, Analytic, RandomizedFirstOrder, RandomizedZerothOrder>;

/// @throws InvalidInput: std_q or std_u of wrong size, negative or all zero, samples < 1, too few for a fit, κ ≤ 0
void validate(const world::Model& model, const LocalModelScheme& scheme, bool with_A);

/// q_next(q ⊕ δq, u + δu) ≈ c ⊕ (A δq + B δu).
struct LocalModel {
  core::Status status = core::Status::NumericalFailure;
  Eigen::VectorXd c;  ///< (smoothed) next configuration (n_q)
  Eigen::MatrixXd A;  ///< from the tangent space at q to the tangent space at c (n_v × n_v), when asked for
  Eigen::MatrixXd B;  ///< (n_v × n_a)
  int failed = 0;     ///< samples whose step had no solution; the means leave them out
};

/// Step workspaces of all threads, and the samples. One caller at a time may use it.
class LocalModelWorkspace {
 public:
  /// @param threads  number of threads that share the samples of a randomised scheme, ≥ 1
  explicit LocalModelWorkspace(std::shared_ptr<const world::Model> model, int threads = 1);
  ~LocalModelWorkspace();
  LocalModelWorkspace(LocalModelWorkspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Computes the local model around (q, u) by one of the four schemes. The result has the same bits for any number of threads.
///
/// Randomised: f_ρ(q, u) = E_w[f(q ⊕ w_q, u + w_u)] (2.20), with means in the tangent space at f(q, u). Disturbances of rotations are
/// transported to the disturbed frame and back (docs/theory/step.md, (S.11)). In the zeroth-order scheme A needs std_q > 0.
///
/// @param options  options of the steps; the scheme sets `smoothing` and `with_…`
/// @param with_A   also compute A
/// @param control  stops the samples
/// @returns Solved, or the status of the step. With samples: Solved if at least one sample was solved (zeroth order: as many as unknowns).
///          Cancelled or MaxIterations if it was stopped
/// @throws  InvalidInput: as step(), std_q or std_u of wrong size, negative or all zero, samples < 1, too few for a fit
/// Tests: tests/dynamics/local_model_test.cpp
[[nodiscard]] core::Status calc_local_model(const world::Model& model, const StepInput& in, const LocalModelScheme& scheme,
                                            const StepOptions& options, bool with_A, LocalModelWorkspace& work, LocalModel& out,
                                            const core::RunControl& control = {});

}  // namespace stiction::dynamics
