#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "stiction/execution/contact_control/control_loop.hpp"
#include "stiction/execution/touch/guarded_run.hpp"

// Internal to the layer: common parts of the moves of a tool and of fingers.

namespace stiction::execution {

class Feeler;

// Times of a guarded move [s].
constexpr double kRest = 0.3;     ///< wait until springs rest after a move
constexpr double kListen = 0.5;   ///< duration of the torque mean at rest, while nothing touches
constexpr double kRamp = 0.2;     ///< time in which a move reaches its speed
constexpr double kHold = 0.2;     ///< time at half of the force after an alarm
constexpr double kPress = 0.3;    ///< time of the change from half to all of the force
constexpr double kMeasure = 0.3;  ///< duration of a torque mean at this force
constexpr double kImpact = 0.1;   ///< time after contact from which forces are judged

constexpr double kPlausible = 2;    ///< prior deviation of contact forces, in multiples of the largest force that a move asks for
constexpr double kStart = 0.5;      ///< share of the force with which the arm waits after an alarm
constexpr double kSlower = 0.5;     ///< speed factor after a false alarm, for instance a rebound
constexpr double kSlowest = 0.125;  ///< least share of the asked speed
constexpr double kRight = 0.05;     ///< relative tolerance of the estimated force
constexpr double kGain = 0.5;       ///< gain from the missing share of the force to the lead
/// A named link with less probability than this is not touched. The value is low, because moves expect their links and hidden friction spreads the
/// probability over other links.
constexpr double kDoubt = 0.01;
constexpr int kMeasurements = 12;
constexpr int kSure = 2;  ///< number of measurements in a row that must name another link to end the move

/// Travel of a straight move from rest to rest: constant acceleration for kRamp, constant speed, and the same deceleration.
class MoveProfile {
 public:
  MoveProfile(double length, double speed) : length_(length), speed_(std::min(speed, length / kRamp)) {}
  double duration() const { return speed_ > 0 ? length_ / speed_ + kRamp : 0; }
  double at(double t) const;

 private:
  double length_, speed_;
};

/// Adapts the lead to the estimated force. This is needed because the controller damps the command while forces differ from their prediction, and because
/// friction bears a part of the springs' force.
/// @param share  factor of the lead  @returns the next factor
inline double follow_force(double share, double felt, double asked) {
  return std::clamp(share + kGain * (1 - felt / asked), kStart, 1 / kStart);
}

/// Makes the arm of a run from its scenario: sets the seed, the places of objects in the run's world, a damping for forces that the leads already bound, and
/// the identified friction in the observer.
ControlScenario make_guarded_arm(const TouchScenario& scenario, const GuardedRunResult& run, std::uint64_t seed);

/// Friction that a run identified; null: none.
inline const sensing::JointFriction* found_friction(const GuardedRunResult& run) { return run.friction ? &*run.friction : nullptr; }

/// Describes the most likely contact on one of `links` (empty: any link), from the torques of the feeler since its settle(). Empty if the probability of each
/// link is below kDoubt.
std::optional<FeltContact> describe_touch(Feeler& feeler, const Eigen::VectorXd& q, const std::vector<int>& links, double time);

/// Sets the forces of a move from its samples of the simulation, from `first` on; each pair is judged from 0.1 s after its contact began.
void judge_move(const std::vector<ControlSample>& samples, std::size_t first, MoveResult& out);

/// Runs one tick of the arm unless the run has to stop. @param q  measured joints after the tick (n_a)  @returns true if the tick was run
bool tick_arm(const Eigen::VectorXd& reference, const core::RunControl& control, ControlLoop& loop, std::vector<ControlSample>& samples,
              Eigen::VectorXd& q, core::Status& go_on);

/// Carries out the moves of a scenario one after the other until a move fails, and records their results.
/// @param carry_out  carries out one move and sets `travelled`  @param go_on  not Solved: the run is over, as in tick_arm()
core::Status carry_out_moves(const TouchScenario& scenario, const ControlScenario& arm, double settle, ControlLoop& loop,
                             const core::Status& go_on, const std::function<void(const GuardedMove&, MoveResult&)>& carry_out,
                             GuardedRunResult& out);

/// run_guarded() for a scenario without a tool: each finger acts on its own after it touches.
core::Status run_closing(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out);

}  // namespace stiction::execution
