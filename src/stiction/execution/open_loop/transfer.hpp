#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "stiction/core/run_control.hpp"
#include "stiction/execution/open_loop/fall.hpp"
#include "stiction/execution/open_loop/run_speed.hpp"
#include "stiction/execution/open_loop/trajectory.hpp"
#include "stiction/simulation/simulation.hpp"

// Open-loop execution of a plan in the second-order simulation (3.6). docs/theory/execution.md

namespace stiction::execution {

using VectorRef = Eigen::Ref<const Eigen::VectorXd>;

struct TransferOptions {
  double speed = kOpenLoopSpeed;       ///< times the full timing (E.13), > 0; above 1 of pushes alone
  double pause = 0;                    ///< commands rest this long between pieces [s], ≥ 0
  std::optional<SpeedLimits> uniform;  ///< in place of both: as published, the same for every object and robot
  /// By what the objects are off their start in the plan, in their tangent (n_vu) [m, rad]; what overlaps then is moved apart (part_start). Empty: not at all.
  Eigen::VectorXd start_error{};
  double hold = 4.0;  ///< the last command is held this long before the goal is judged, at the plan's tolerances [s], ≥ 0
  /// A free object was dropped that is so far below where the plan has it from then to the end of a piece [L of the object], > 0
  double fall = kFall;
  /// The run ends where the object of the goal is farther from where the plan has it than this many tolerances, > 0
  double lost_factor = std::numeric_limits<double>::infinity();
  double record_interval = 0.02;  ///< of the samples [s]
  bool whole = true;              ///< run the whole plan; without it there is no verdict, and pieces have only `alone`
  bool alone = true;              ///< run every pushing piece by itself from its planned start, as in Fig. 3-8
  int threads = 0;                ///< for those; 0 = all cores; the result does not depend on it
  void validate() const;          ///< @throws core::InvalidInput naming the field
};

/// Errors of one object over one piece: planned against simulated pose.
struct PieceError {
  double mean_position = 0;    ///< Δ (3.10) [m]
  double mean_angle = 0;       ///< Δ (3.10) [rad]
  double start_position = 0;   ///< at the first moment [m]
  double start_angle = 0;      ///< [rad]
  double end_position = 0;     ///< at the last moment [m]
  double end_angle = 0;        ///< [rad]
  double length_position = 0;  ///< L of the plan (3.12) [m]
  double length_angle = 0;     ///< [rad]
  double least_position = 0;   ///< a plan that moves the object by less leaves it where it is: world::share::kMotionless of its length [m]
  /// Δ/L (3.11), nothing where the plan moves the object by less than least_position, or turns it by less than kLeastAngle.
  std::optional<double> normalised_position() const;
  std::optional<double> normalised_angle() const;
};
inline constexpr double kLeastAngle = 1e-4;  // [rad]

struct PieceReport {
  planning::SegmentKind kind = planning::SegmentKind::Contact;
  int first_segment = 0, last_segment = 0;
  double begin_s = 0, end_s = 0;
  std::optional<PieceError> in_plan;  ///< within the whole run, with what earlier pieces left behind; nothing where it ended before
  std::optional<PieceError> alone;    ///< started from the planned state at rest
};

struct TransferResult {
  core::Status status = core::Status::NumericalFailure;
  std::string message;                                     ///< what the simulation said, where it is not Solved
  std::vector<PieceReport> pieces;                         ///< of the plan
  planning::GoalError error;                               ///< of the object at the end of the run
  bool reached = false;                                    ///< the whole plan was run and error is within the tolerances of its goal
  std::optional<int> dropped;                              ///< object that fell: the run ends there
  double dropped_s = 0;                                    ///< and when
  bool lost = false;                                       ///< the run ended for lost_factor
  double max_depth = 0;                                    ///< deepest penetration over the whole run [m], ≥ 0
  double duration_s = 0;                                   ///< of the whole run, simulated
  std::vector<double> times;                               ///< samples of the whole run
  Eigen::MatrixXd q;                                       ///< (n_q × samples) simulated
  Eigen::MatrixXd q_plan;                                  ///< (n_q × samples) planned
  std::vector<int> piece;                                  ///< per sample
  std::vector<std::vector<simulation::PairForce>> forces;  ///< per sample
  Eigen::MatrixXd torque;                                  ///< (n_a × samples) of the motors, of each the largest since the sample before
  long steps = 0;
  double wall_s = 0;
};

/// Mean error (3.10), path length (3.12) and the errors at both ends between planned and simulated samples of one object.
/// Δ = 1/T ∫ d(q_plan, q_sim) dt by the trapezoidal rule, d the distance of body origins [m] and the angle between orientations [rad].
/// @param times   (samples) increasing [s]
/// @param q_plan  (n_q × samples)  @param q_sim (n_q × samples)
/// @param path    (n_q × knots) states of the plan between which L is summed
PieceError measure(const world::Model& model, int object, VectorRef times, Eigen::Ref<const Eigen::MatrixXd> q_plan,
                   Eigen::Ref<const Eigen::MatrixXd> q_sim, Eigen::Ref<const Eigen::MatrixXd> path);

/// Runs the commands of a plan open loop, from the state after the settling of the start to the last knot and `hold` seconds beyond, and
/// compares the object of the goal with the plan. Where an object is dropped the run ends: what comes after it would say nothing.
/// @param predicted  the plan with states that were predicted anew (predict), to be compared with instead of its own; the run is the same
/// @returns Solved: run to the end, whatever came out; Cancelled, MaxIterations (deadline), NumericalFailure: `out` holds what was run
/// @throws  core::InvalidInput: options, or a plan that does not fit the plant's model
/// Tests: tests/execution
core::Status transfer(const std::shared_ptr<const simulation::Plant>& plant, const planning::Plan& plan, const TransferOptions& options,
                      const core::RunControl& control, TransferResult& out, const planning::Plan* predicted = nullptr);

}  // namespace stiction::execution
