#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stiction/execution/contact_control/control_scenario.hpp"
#include "stiction/world/scene.hpp"

namespace stiction::execution {

/// A fixed body of the world that is missing in the model. Its place may differ from seed to seed.
struct UnknownBody {
  world::FixedSpec body;
  Eigen::Vector3d position_spread = Eigen::Vector3d::Zero();  ///< its position is drawn uniformly within ± this [m], ≥ 0
  double yaw_spread = 0;  ///< its rotation about the vertical through this position is drawn within ± this [rad], ≥ 0
};

/// A fixed body of the scene whose place in the world differs from that in the scene.
struct MisplacedBody {
  std::string name;
  Eigen::Vector3d position_spread = Eigen::Vector3d::Zero();  ///< as in UnknownBody [m], ≥ 0
  std::vector<int> objects{};                                 ///< free objects that stand on it and are displaced with it
};

/// A straight move of a tool, or a move of joints, that may end when a contact is felt.
struct GuardedMove {
  /// A contact that ends a move.
  struct Until {
    double force = 0;          ///< F: force with which the arm finally presses, and no harder [N], > 0
    std::vector<int> links{};  ///< links on which the contact is expected, bodies of the model; empty: any link
  };
  /// A distance from a fixed body, by the model, that ends a move.
  struct Gap {
    std::string body;
    double distance = 0;  ///< [m], > 0
  };
  /// A force on the surface that the move before felt, while the tool moves along it. The move ends where the surface ends.
  struct Press {
    Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();  ///< unit
    double force = 0;                                        ///< [N], > 0
  };
  std::string name;
  /// Target joints (n_a) in a scenario without a tool. With `until`, each branch moves until its own link touches.
  Eigen::VectorXd posture{};
  Eigen::Vector3d direction_W = -Eigen::Vector3d::UnitZ();  ///< d, unit
  double travel = 0;                                        ///< largest travel [m], > 0
  double speed = 0.02;                                      ///< [m/s], > 0
  std::optional<Until> until;
  std::optional<Gap> gap;
  std::optional<Press> press;
  std::string correct;  ///< fixed body that is moved along d to where it, or its edge, was felt; empty: none
};

/// An arm that moves among unknown bodies, to a posture or through guarded moves. Read from a YAML file (tasks/touch_scenario_file.hpp).
struct TouchScenario {
  ControlScenario arm;      ///< known part: model, start, controller, plant, estimator; without reference; contacts are estimated
  Eigen::VectorXd goal;     ///< goal posture, joints (n_a)
  double speed = 0.15;      ///< largest speed of any point of the arm [m/s]
  int max_touches = 20;     ///< number of touches after which the arm gives up, ≥ 1
  double tolerance = 0.01;  ///< largest joint error at the goal [rad, L of the robots]
  std::vector<UnknownBody> unknown;
  std::vector<MisplacedBody> misplaced;
  double friction_motion = 0;  ///< amplitude of the motion that identifies joint friction before the moves [rad; m], ≥ 0; 0: no such motion
  std::vector<GuardedMove> moves;  ///< moves of the tool, or of joints without a tool, in place of `goal`: run_guarded()
};

/// Makes the world: the known scene with the unknown and misplaced bodies, in their places for this seed.
/// @throws core::InvalidInput: the arm touches something at its start
std::shared_ptr<const world::Model> make_world(const TouchScenario& scenario, std::uint64_t seed);

/// Displaces the objects that stand on misplaced bodies as these bodies are displaced in `to` against `from`. @param q_u  objects (n_qu)
void move_objects(const TouchScenario& scenario, const world::Model& from, const world::Model& to, Eigen::VectorXd& q_u);

}  // namespace stiction::execution
