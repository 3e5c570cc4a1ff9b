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
  Arrived,    ///< the move came to its end
  Felt,       ///< the arm felt the contact that `until` asks for, and presses with its force
  Lost,       ///< the surface on which it pressed has ended: an edge
  NotFelt,    ///< the move came to its end without feeling a contact
  WrongLink,  ///< it felt a contact, but on none of the links of `until`
  StillThere  ///< the move came to its end, and the surface on which it presses goes on
};
std::string_view to_string(MoveOutcome outcome) noexcept;

/// A contact that ended a move. Times are those of the run.
struct FeltContact {
  double time = 0;                                         ///< when it was reported, pressed with the force of its move [s]
  double begin = 0;                                        ///< begin of the contact, estimated from torques [s]
  double alarm = 0;                                        ///< when the arm noticed the contact and stopped [s]
  int body = -1;                                           ///< touched link
  double probability = 0;                                  ///< probability of this link
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();           ///< contact point [m]
  Eigen::Vector3d direction_W = Eigen::Vector3d::UnitZ();  ///< direction of the force on the arm, unit
  double force = 0;                                        ///< [N]
};

/// Result of a move. The forces are those of the simulation and serve only to judge the move.
struct MoveResult {
  std::string name;
  MoveOutcome outcome = MoveOutcome::NotFelt;
  std::string reason;                      ///< why the move failed
  double begin = 0, end = 0;               ///< [s]
  double travelled = 0;                    ///< measured travel of the tool along the direction [m]
  std::vector<FeltContact> felt;           ///< one contact; of a hand, one for each finger
  std::optional<double> correction;        ///< shift of the body along the direction in the model [m]
  std::optional<double> correction_error;  ///< its place in the model minus its place in the simulation, along the direction [m]
  double contact = 0;                      ///< begin of the first contact [s]; the end of the move if there was none
  double peak = 0;                         ///< largest force [N]
  double late_peak = 0;                    ///< largest force from 0.1 s after the contact on [N]
  double last_force = 0;                   ///< mean force over the last 0.1 s [N]
};

struct GuardedRunResult {
  core::Status status = core::Status::NumericalFailure;
  bool reached = false;  ///< all moves ended as they should
  std::string reason;    ///< why not, or the message of the simulation
  std::vector<MoveResult> moves;
  std::optional<sensing::JointFriction> friction;  ///< joint friction identified before the moves; empty: not asked for
  ControlRunResult run;                            ///< samples and forces of the whole run
  std::shared_ptr<const world::Model> world;       ///< the simulated model
  std::shared_ptr<const world::Model> model;       ///< the arm's corrected model at the end
  Eigen::VectorXd q;                               ///< configuration of the simulation at the end (n_q)
};

/// Carries out the moves of a scenario one after the other under the contact-aware controller. A guarded move is slow, and a change test with a stated rate
/// of false alarms watches the joint torques. After an alarm, the command first leads the arm with half of the asked force F, and then with all of it,
///     x_cmd = x + F c d ,   c = dᵀ J K⁻¹ Jᵀ d ,                                                                     (G.5)
/// so that springs at rest press with F along d, for any material of the contact. From mean torques, the arm then estimates link, place and force. The fixed
/// body named by `correct` is moved in the model to where it was felt, and later moves use this place. Without a tool, joints move, and each finger stops and
/// presses on its own.
/// @returns Solved: the run came to its end, `reached` says if all moves succeeded | NumericalFailure: the simulation stopped | Cancelled |
///          MaxIterations (deadline)
/// @throws core::InvalidInput: options out of range, no moves, a start in contact
/// Tests: tests/execution/guarded_test.cpp
[[nodiscard]] core::Status run_guarded(const TouchScenario& scenario, const TouchRunOptions& options, GuardedRunResult& out);

}  // namespace stiction::execution
