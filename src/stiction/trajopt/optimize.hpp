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

/// One QP over the whole horizon per iteration, its inputs and feedback followed by the exact dynamics, the step shortened until the
/// cost falls. Linear in T.
struct SweepSolver {
  int max_halvings = 8;  ///< of the step before the iteration is given up, ≥ 0
};
/// Alg. 1 as published: at every time one QP over what is left of the horizon, of which the first input is applied. O(T²) stages, and the
/// cost may rise; the best trajectory is kept.
struct RecedingSolver {};
using InnerSolver = std::variant<SweepSolver, RecedingSolver>;

/// Contact trust region besides the boxes: contact forces, linear in the step, stay inside their friction cones (dual feasibility), so that the
/// quadratic model cannot pull. Cones in space become pyramids around them, so that no step at all always is inside (T.7).
/// Needs the Analytic scheme, use_A and SweepSolver.
struct ForceTrustRegion {
  double max_distance = 0.02;  ///< of the contacts that count [m], > 0: the smoothed force of a far one is tiny, its linear model of no use
  int rays = 8;                ///< of the pyramids, in [4, 64]
  double friction = 1.0;       ///< multiplies every μ, > 0
};

struct OptimizeOptions {
  dynamics::StepOptions step;  ///< h, regularisation, friction, joint limits of all dynamics; smoothing and with_… are set here
  dynamics::LocalModelScheme scheme = dynamics::Analytic{};  ///< of the local models in the first iteration
  double kappa_growth = 1.1616;                              ///< κ_i = κ_0 · growthⁱ (Analytic), > 0; (2000/100)^(1/20) as published
  double std_decay = 0.8;                                    ///< std_i = std_0 / (i + 1)^decay (randomised), ≥ 0
  bool use_A = true;                                         ///< false: A = 1 for objects, 0 for robots, and the robot rows of B are 1
  Weights weights;
  Eigen::VectorXd input_bound = Eigen::VectorXd::Constant(1, 0.2);  ///< |u_t − qᵃ_t| ≤ this (n_a, or one for all) [rad or m], > 0
  int iterations = 10;                                              ///< ≥ 1
  double tolerance = 0;        ///< stop when an iteration lowers the cost by less than this share, ≥ 0
  double qp_tolerance = 1e-6;  ///< of a QP, as a share of the cost, > 0
  InnerSolver solver = SweepSolver{};
  std::optional<ForceTrustRegion> forces;  ///< nullopt: boxes alone
  int threads = 0;                         ///< of the local models, 0 = all cores; the result does not depend on it, bit for bit
  void validate(const world::Model& model) const;
};

struct OptimizeInput {
  VectorRef q_start;                          ///< (n_q)
  std::vector<Eigen::VectorXd> u_guess;       ///< T ≥ 1 commands (n_a), inside the joint limits [rad or m]
  std::vector<Eigen::VectorXd> reference;     ///< T + 1 configurations q^d (n_q)
  const Eigen::VectorXd* u_before = nullptr;  ///< u_{−1} (n_a); null: the joint positions of q_start
};

/// T commands equal to the joint positions of q, and T + 1 equal configurations: the trivial guess and the reference of one goal.
std::vector<Eigen::VectorXd> constant_inputs(const world::Model& model, VectorRef q, int horizon);
std::vector<Eigen::VectorXd> constant_reference(VectorRef q, int horizon);

/// One iteration as it went. The first entry of a history is the guess.
struct IterationLog {
  CostTerms cost;        ///< of the trajectory after this iteration
  double best = 0;       ///< lowest total so far
  double predicted = 0;  ///< by which the QP thought the cost would fall
  double length = 0;     ///< of the accepted step, 1 = whole; 0: none was
  double sharpness = 0;  ///< κ [1/J], or std of u (its largest) [rad or m]; 0 for Exact
  int qp_iterations = 0;
  int failed_models = 0;  ///< times whose local model had no solution: taken as if nothing were touched
  double elapsed_s = 0;
};

struct OptimizeResult {
  core::Status status = core::Status::NumericalFailure;
  std::vector<Eigen::VectorXd> u;                               ///< T commands (n_a), of the lowest cost met
  std::vector<Eigen::VectorXd> q;                               ///< T + 1 configurations of the exact dynamics
  std::vector<std::vector<dynamics::ContactImpulse>> contacts;  ///< T, the active ones of every step
  CostTerms cost;
  std::vector<IterationLog> history;
  long steps = 0;           ///< exact steps of rollouts
  long linearisations = 0;  ///< local models
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

/// Iterative MPC (Alg. 1, §3.2): commands u_0 … u_{T−1} that lower
///
///   ‖q_T ⊖ q_T^d‖²_Qd + Σ_{t<T} ‖q_t ⊖ q_t^d‖²_Q + ‖u_t − u_{t−1}‖²_R     s.t. q_{t+1} = f(q_t, u_t) exactly,                    (T.1)
///
/// joint limits for u_t, and |u_t − qᵃ_t| ≤ input_bound around the trajectory before (the trust region of the thesis).
///
/// @returns Solved: all iterations done, or the tolerance met | MaxIterations: deadline | Cancelled | NumericalFailure: the guess cannot
///          be followed (a step has no solution). `out` holds the best trajectory met in any case; after NumericalFailure none.
/// @throws  core::InvalidInput: sizes, numbers that are not finite, negative weights, a guess outside the joint limits, options
/// Source:  T. Pang's thesis §3.2; docs/theory/trajopt.md
/// Tests:   tests/trajopt/optimize_test.cpp
[[nodiscard]] core::Status optimize(const world::Model& model, const OptimizeInput& in, const OptimizeOptions& options,
                                    const core::RunControl& control, OptimizeWorkspace& work, OptimizeResult& out);

}  // namespace stiction::trajopt
