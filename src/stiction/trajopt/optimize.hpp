#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/dynamics/local_model.hpp"
#include "stiction/dynamics/rollout.hpp"
#include "stiction/trajopt/cost.hpp"

namespace stiction::trajopt {

/// Solves one QP over the whole horizon per iteration. The exact dynamics then follow its inputs and feedback, and the step is shortened
/// until the cost falls. The effort is linear in T.
struct SweepSolver {
  int max_halvings = 8;  ///< how often the step is halved before the iteration is given up, ≥ 0
};
/// Alg. 1 as published: at every time it solves one QP over the remaining horizon and applies the first input. This takes O(T²) stages, and
/// the cost may rise; the best trajectory is kept.
struct RecedingSolver {};
using InnerSolver = std::variant<SweepSolver, RecedingSolver>;

/// Contact trust region in addition to the input bounds: the linearised contact forces stay inside their friction cones (dual feasibility),
/// so that the quadratic model cannot pull on an object. A 3-D cone is replaced by a pyramid around it, so that a zero step is always
/// feasible (T.7). Needs the Analytic scheme, use_A and SweepSolver.
struct ForceTrustRegion {
  /// Only contacts nearer than this count [m], > 0. The smoothed forces of far contacts are tiny and their linear model is useless.
  double max_distance = 0.02;
  int rays = 8;           ///< number of rays of each pyramid, in [4, 64]
  double friction = 1.0;  ///< factor on every μ, > 0
};

struct OptimizeOptions {
  /// h, regularisation, friction and joint limits of all steps. The optimizer sets smoothing and with_… itself.
  dynamics::StepOptions step;
  dynamics::LocalModelScheme scheme = dynamics::Analytic{};  ///< scheme of the local models in the first iteration
  double kappa_growth = 1.1616;  ///< κ_i = κ_0 · growthⁱ ≤ 1e50 (Analytic), > 0; (2000/100)^(1/20) as published
  double std_decay = 0.8;        ///< std_i = std_0 / (i + 1)^decay (randomised), ≥ 0
  bool use_A = true;             ///< false: A is identity for objects and 0 for robots; the robot rows of B are identity
  Weights weights;
  Eigen::VectorXd input_bound = Eigen::VectorXd::Constant(1, 0.2);  ///< |u_t − qᵃ_t| ≤ this (n_a, or one for all) [rad or m], > 0
  int iterations = 10;                                              ///< ≥ 1
  double tolerance = 0;        ///< stop when an iteration lowers the cost by less than this share, ≥ 0
  double qp_tolerance = 1e-6;  ///< tolerance of each QP as a share of the cost, > 0
  InnerSolver solver = SweepSolver{};
  std::optional<ForceTrustRegion> forces;  ///< nullopt: only the input bounds limit the step
  int threads = 0;                         ///< threads for the local models, 0 = all cores; does not change a bit of the result
  void validate(const world::Model& model) const;
};

struct OptimizeInput {
  VectorRef q_start;                          ///< (n_q)
  std::vector<Eigen::VectorXd> u_guess;       ///< T ≥ 1 commands (n_a), inside the joint limits [rad or m]
  std::vector<Eigen::VectorXd> reference;     ///< T + 1 configurations q^d (n_q)
  const Eigen::VectorXd* u_before = nullptr;  ///< u_{−1} (n_a); null: the joint positions of q_start
};

/// Trivial guess: T commands equal to the joint positions of q.
std::vector<Eigen::VectorXd> constant_inputs(const world::Model& model, VectorRef q, int horizon);
/// Reference for a single goal: T + 1 configurations equal to q.
std::vector<Eigen::VectorXd> constant_reference(VectorRef q, int horizon);

/// Log of one iteration. The first entry of a history is the guess.
struct IterationLog {
  CostTerms cost;        ///< cost of the trajectory after this iteration
  double best = 0;       ///< lowest total cost so far
  double predicted = 0;  ///< decrease of the cost that the QP predicted
  double length = 0;     ///< length of the accepted step, 1 = full step; 0: no step was accepted
  double sharpness = 0;  ///< κ [1/J], or the largest standard deviation of u [rad or m]; 0 for Exact
  int qp_iterations = 0;
  int failed_models = 0;  ///< number of times whose local model had no solution; they are treated as if there were no contact
  double elapsed_s = 0;
};

struct OptimizeResult {
  core::Status status = core::Status::NumericalFailure;
  std::vector<Eigen::VectorXd> u;                               ///< T commands (n_a) of the trajectory with the lowest cost
  std::vector<Eigen::VectorXd> q;                               ///< T + 1 configurations of the exact dynamics
  std::vector<std::vector<dynamics::ContactImpulse>> contacts;  ///< active contacts of each of the T steps
  CostTerms cost;
  std::vector<IterationLog> history;
  long steps = 0;           ///< number of exact steps in rollouts
  long linearisations = 0;  ///< number of local models
  double wall_s = 0;
};

/// Scratch of all threads; belongs to one caller at a time.
class OptimizeWorkspace {
 public:
  /// @param threads  0 = all cores
  explicit OptimizeWorkspace(std::shared_ptr<const world::Model> model, int threads = 0);
  ~OptimizeWorkspace();
  OptimizeWorkspace(OptimizeWorkspace&&) noexcept;
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// Iterative MPC (Alg. 1, §3.2): improves commands u_0 … u_{T−1} so that they lower the cost
///
///   ‖q_T ⊖ q_T^d‖²_Qd + Σ_{t<T} ‖q_t ⊖ q_t^d‖²_Q + ‖u_t − u_{t−1}‖²_R     s.t. q_{t+1} = f(q_t, u_t) exactly,                    (T.1)
///
/// with joint limits for u_t and |u_t − qᵃ_t| ≤ input_bound around the previous trajectory (the trust region of the thesis).
///
/// @returns Solved: all iterations done, or the tolerance met | MaxIterations: deadline | Cancelled | NumericalFailure: the guess cannot
///          be followed (a step has no solution). `out` holds the best trajectory found, except after NumericalFailure.
/// @throws  core::InvalidInput: sizes, numbers that are not finite, negative weights, a guess outside the joint limits, options
/// Source:  T. Pang's thesis §3.2; docs/theory/trajopt.md
/// Tests:   tests/trajopt/optimize_test.cpp
[[nodiscard]] core::Status optimize(const world::Model& model, const OptimizeInput& in, const OptimizeOptions& options,
                                    const core::RunControl& control, OptimizeWorkspace& work, OptimizeResult& out);

}  // namespace stiction::trajopt
