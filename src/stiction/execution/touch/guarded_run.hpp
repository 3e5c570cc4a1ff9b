#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/execution/contact_control/control_run.hpp"
#include "stiction/execution/touch/touch_run.hpp"
#include "stiction/execution/touch/touch_scenario.hpp"
#include "stiction/sensing/observer.hpp"

namespace stiction::execution {

enum class MoveOutcome {
  Arrived,    ///< at the end of its way
  Felt,       ///< what its end asks for was felt, and is pressed with its force
  Lost,       ///< what it pressed on is no longer there: an edge
  NotFelt,    ///< at the end of its way, and nothing was felt
  WrongLink,  ///< something was felt, on none of the links of its end
  StillThere  ///< at the end of its way, and what it presses on goes on
};
std::string_view to_string(MoveOutcome outcome) noexcept;

/// A contact that ended a move. Times are those of the run.
struct FeltContact {
  double time = 0;                                         ///< when it was told, pressed with the force of its move [s]
  double begin = 0;                                        ///< when it began, as far as torques tell [s]
  double alarm = 0;                                        ///< when that was noticed, and the arm stopped [s]
  int body = -1;                                           ///< link
  double probability = 0;                                  ///< of that link
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();           ///< place [m]
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitZ();  ///< of the force on the arm
  double force = 0;                                        ///< [N]
};

/// What became of a move, and, from the simulation, how hard it pressed: for judging alone.
struct MoveResult {
  std::string name;
  MoveOutcome outcome = MoveOutcome::NotFelt;
  std::string reason;                      ///< where it is not as wanted
  double begin = 0, end = 0;               ///< [s]
  double travelled = 0;                    ///< of the tool along its direction, as measured [m]
  std::vector<FeltContact> felt;           ///< one; of a hand one of each side
  std::optional<double> correction;        ///< by which the body was moved along the direction in the model [m]
  std::optional<double> correction_error;  ///< where it then is less where it is in the simulation, along the direction [m]
  double contact = 0;                      ///< when the first contact was made [s]; the end where there was none
  double peak = 0;                         ///< largest force [N]
  double late_peak = 0;                    ///< the same from 0.1 s after the contact on [N]
  double last_force = 0;                   ///< mean over the last 0.1 s [N]
};

struct GuardedRunResult {
  core::Status status = core::Status::NumericalFailure;
  bool reached = false;  ///< all moves ended as they should
  std::string reason;    ///< why not, or what the simulation said
  std::vector<MoveResult> moves;
  std::optional<sensing::JointFriction> friction;  ///< that joints showed before the moves; nullopt: not asked for
  ControlRunResult run;                            ///< samples and forces of the whole run
  std::shared_ptr<const world::Model> world;       ///< what was simulated
  std::shared_ptr<const world::Model> model;       ///< what the arm knows at the end
  Eigen::VectorXd q;                               ///< where joints and objects are in the simulation at the end (n_q)
};

/// Carries out the moves of a scenario one after the other under the contact-aware controller. A guarded move is slow and listens: where joint torques show that
/// something touches, by a change test with a stated rate of false alarms, the command stays half the asked force ahead of the arm, then goes
///     x_cmd = x + F c d ,   c = dᵀ J K⁻¹ Jᵀ d ,                                                                     (G.5)
/// with which springs at rest press with F along d, whatever touches. Then the torques of half a second say on which link, where and how hard. A fixed body that was to be
/// felt is moved in the model so that it is where it was felt, and later moves that refer to it go by that. Without a tool joints move, and each side of a hand stops and
/// presses by itself.
/// @returns Solved: the run came to its end, `reached` says whether as wanted | NumericalFailure: the simulation stopped | Cancelled | MaxIterations (deadline)
/// @throws core::InvalidInput: options out of range, no moves, a start in contact
/// Tests: tests/execution/guarded_test.cpp
[[nodiscard]] core::Status run_guarded(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out);

}  // namespace stiction::execution
