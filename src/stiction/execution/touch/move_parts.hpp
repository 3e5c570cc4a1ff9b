#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "stiction/execution/contact_control/control_loop.hpp"
#include "stiction/execution/touch/guarded_run.hpp"

// Internal to the layer: what moves of a tool and of fingers have in common.

namespace stiction::execution {

class Feeler;

// Times of a guarded move [s].
constexpr double kRest = 0.3;     ///< until springs rest after a move
constexpr double kListen = 0.5;   ///< of torques while nothing touches
constexpr double kRamp = 0.2;     ///< in which a move gets to its speed
constexpr double kHold = 0.2;     ///< at half of the force after an alarm
constexpr double kPress = 0.3;    ///< from one force to the next
constexpr double kMeasure = 0.3;  ///< of torques at that force
constexpr double kImpact = 0.1;   ///< after which forces are judged

constexpr double kPlausible =
    2;  ///< forces of contacts are this times the largest that a move asks for (one deviation), before torques are seen
constexpr double kStart = 0.5;      ///< share of the force with which the arm waits after an alarm
constexpr double kSlower = 0.5;     ///< of the speed, after an alarm with nothing behind it, which a rebound may be
constexpr double kSlowest = 0.125;  ///< and no slower than this share of what was asked
constexpr double kRight = 0.05;     ///< of the force, by which what is felt may be off
constexpr double kGain = 0.5;       ///< of the lead, by what of the force is missing in a measurement
constexpr double kDoubt =
    0.01;  ///< probability below which an asked link is not what touches: a move is made to feel it, and friction that hides torques spreads the rest
constexpr int kMeasurements = 12;
constexpr int kSure = 2;  ///< measurements in a row that say that another link is touched

/// Way of a straight move from rest to rest: constant acceleration for kRamp, its speed, and the same back to rest.
class MoveProfile {
 public:
  MoveProfile(double length, double speed) : length_(length), speed_(std::min(speed, length / kRamp)) {}
  double duration() const { return speed_ > 0 ? length_ / speed_ + kRamp : 0; }
  double at(double t) const;

 private:
  double length_, speed_;
};

/// The lead follows the force that is felt: the controller damps the command while forces are not as predicted, and friction bears a part of what springs press with.
/// @param share  of the lead  @returns the next share
inline double follow_force(double share, double felt, double asked) {
  return std::clamp(share + kGain * (1 - felt / asked), kStart, 1 / kStart);
}

/// The scenario with the seed of a run, objects where they are in its world, damping for forces that leads bound themselves, and an observer that knows the friction that
/// was found.
ControlScenario make_guarded_arm(const TouchScenario& scenario, const GuardedRunResult& run, std::uint64_t seed);

/// The friction that a run found; null: none.
inline const sensing::JointFriction* found_friction(const GuardedRunResult& run) { return run.friction ? &*run.friction : nullptr; }

/// What touches one of `links` (empty: any), from the torques of the feeler since its settle(): the likeliest of these; nullopt: each of them has less than kDoubt of the probability.
std::optional<FeltContact> describe_touch(Feeler& feeler, const Eigen::VectorXd& q, const std::vector<int>& links, double time);

/// Forces of the simulation over the samples of a move, from `first` on; each pair is judged from 0.1 s after it was made.
void judge_move(const std::vector<ControlSample>& samples, std::size_t first, MoveResult& out);

/// One tick of the arm, unless the run is to stop. @param q  joints after it, as measured (n_a)  @returns whether there was one
bool tick_arm(const Eigen::VectorXd& reference, const core::RunControl& control, ControlLoop& loop, std::vector<ControlSample>& samples,
              Eigen::VectorXd& q, core::Status& go_on);

/// The moves of a scenario one after the other, until one does not end as it should, and what became of them.
/// @param carry_out  one move, `travelled` included  @param go_on  not Solved: the run is over, as of tick_arm()
core::Status carry_out_moves(const TouchScenario& scenario, const ControlScenario& arm, double settle, ControlLoop& loop,
                             const core::Status& go_on, const std::function<void(const GuardedMove&, MoveResult&)>& carry_out,
                             GuardedRunResult& out);

/// Moves of fingers, each from its own touch on by itself: run_guarded() of a scenario without a tool.
core::Status run_closing(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out);

}  // namespace stiction::execution
