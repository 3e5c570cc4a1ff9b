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
  double speed = kOpenLoopSpeed;       ///< factor of the full speed (E.13), > 0; above 1 it applies to pushes only
  double pause = 0;                    ///< time for which commands rest between pieces [s], ≥ 0
  std::optional<SpeedLimits> uniform;  ///< replaces `speed` and `pause` by the published limits, the same for every object and robot
  /// Displacement of the objects from their planned start, in their tangent (n_vu) [m, rad]. Objects that then overlap are moved apart (part_start).
  /// Empty: none.
  Eigen::VectorXd start_error{};
  double hold = 4.0;  ///< the last command is held this long; then the goal is judged with the plan's tolerances [s], ≥ 0
  /// A free object is dropped if it is this far below its planned place from then to the end of a piece [L of the object], > 0
  double fall = kFall;
  /// The run ends if the object of the goal is farther than this from its planned place [tolerances], > 0
  double lost_factor = std::numeric_limits<double>::infinity();
  double record_interval = 0.02;  ///< time between two samples [s]
  bool whole = true;              ///< run the whole plan; false: there is no verdict, and pieces only have `alone`
  bool alone = true;              ///< run every pushing piece by itself from its planned start, as in Fig. 3-8
  int threads = 0;                ///< threads for the runs of `alone`; 0: all cores; the result does not depend on it
  void validate() const;          ///< @throws core::InvalidInput naming the field
};

/// Errors of one object over one piece: distance between planned and simulated pose.
struct PieceError {
  double mean_position = 0;    ///< mean error Δ (3.10) [m]
  double mean_angle = 0;       ///< mean error Δ (3.10) [rad]
  double start_position = 0;   ///< error at the first moment [m]
  double start_angle = 0;      ///< [rad]
  double end_position = 0;     ///< error at the last moment [m]
  double end_angle = 0;        ///< [rad]
  double length_position = 0;  ///< path length L of the plan (3.12) [m]
  double length_angle = 0;     ///< [rad]
  double least_position = 0;   ///< motion below which the plan leaves the object in place: world::share::kMotionless of its length [m]
  /// Δ/L (3.11); empty if the plan moves the object by less than least_position, or turns it by less than kLeastAngle.
  std::optional<double> normalised_position() const;
  std::optional<double> normalised_angle() const;
};
inline constexpr double kLeastAngle = 1e-4;  // [rad]

struct PieceReport {
  planning::SegmentKind kind = planning::SegmentKind::Contact;
  int first_segment = 0, last_segment = 0;
  double begin_s = 0, end_s = 0;
  std::optional<PieceError> in_plan;  ///< error in the whole run, on top of the errors of earlier pieces; empty if the run ended before
  std::optional<PieceError> alone;    ///< error of the piece alone, started at rest from the planned state
};

struct TransferResult {
  core::Status status = core::Status::NumericalFailure;
  std::string message;                                     ///< message of the simulation if not Solved
  std::vector<PieceReport> pieces;                         ///< pieces of the plan
  planning::GoalError error;                               ///< error of the object at the end of the run
  bool reached = false;                                    ///< the whole plan was run, and the error is within the tolerances of its goal
  std::optional<int> dropped;                              ///< object that fell, which ended the run
  double dropped_s = 0;                                    ///< time of the fall
  bool lost = false;                                       ///< the run ended because of lost_factor
  double max_depth = 0;                                    ///< deepest penetration over the whole run [m], ≥ 0
  double duration_s = 0;                                   ///< simulated time of the whole run
  std::vector<double> times;                               ///< times of the samples of the whole run [s]
  Eigen::MatrixXd q;                                       ///< simulated configurations (n_q × samples)
  Eigen::MatrixXd q_plan;                                  ///< planned configurations (n_q × samples)
  std::vector<int> piece;                                  ///< index into pieces for each sample
  std::vector<std::vector<simulation::PairForce>> forces;  ///< contact forces of each sample
  Eigen::MatrixXd torque;  ///< motor torques (n_a × samples): the largest of each motor since the sample before
  long steps = 0;
  double wall_s = 0;
};

/// Computes the mean error (3.10), the path length (3.12) and the errors at both ends between planned and simulated samples of one object.
/// Δ = 1/T ∫ d(q_plan, q_sim) dt by the trapezoidal rule; d is the distance of body origins [m] or the angle between orientations [rad].
/// @param times   (samples) increasing [s]
/// @param q_plan  (n_q × samples)  @param q_sim (n_q × samples)
/// @param path    (n_q × knots) states of the plan, along which L is summed
PieceError measure(const world::Model& model, int object, VectorRef times, Eigen::Ref<const Eigen::MatrixXd> q_plan,
                   Eigen::Ref<const Eigen::MatrixXd> q_sim, Eigen::Ref<const Eigen::MatrixXd> path);

/// Runs the commands of a plan open loop in the simulation, from the end of the settling of the start to `hold` seconds after the last knot, and compares the
/// object of the goal with the plan. The run ends if an object is dropped, because later errors would say nothing.
/// @param predicted  the plan with states that were predicted anew (predict); the run, which is the same, is compared with these states
/// @returns Solved: the run came to its end, with any verdict; Cancelled, MaxIterations (deadline), NumericalFailure: `out` holds the run so far
/// @throws  core::InvalidInput: invalid options, or a plan that does not fit the plant's model
/// Tests: tests/execution
core::Status transfer(const std::shared_ptr<const simulation::Plant>& plant, const planning::Plan& plan, const TransferOptions& options,
                      const core::RunControl& control, TransferResult& out, const planning::Plan* predicted = nullptr);

}  // namespace stiction::execution
