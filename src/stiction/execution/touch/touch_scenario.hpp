#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stiction/execution/contact_control/control_scenario.hpp"
#include "stiction/world/scene.hpp"

namespace stiction::execution {

/// A fixed body that is in the world and not in the model. Where it is may differ from seed to seed.
struct UnknownBody {
  world::FixedSpec body;
  Eigen::Vector3d position_spread = Eigen::Vector3d::Zero();  ///< its place is drawn uniformly within ± this [m], ≥ 0
  double yaw_spread = 0;                                      ///< and its turn about z of W, through its place [rad], ≥ 0
};

/// A fixed body of the scene that is not quite where the scene says.
struct MisplacedBody {
  std::string name;
  Eigen::Vector3d position_spread = Eigen::Vector3d::Zero();  ///< as of UnknownBody [m], ≥ 0
  std::vector<int> objects{};                                 ///< free objects that stand on it, and are elsewhere by as much
};

/// A straight move of a tool, or of joints, that may end where something is felt.
struct GuardedMove {
  /// A contact that ends a move.
  struct Until {
    double force = 0;          ///< F with which it is pressed in the end, and no harder [N], > 0
    std::vector<int> links{};  ///< on which it is to be felt, bodies of the model; empty: on any
  };
  /// A distance from a fixed body that ends a move, by the model.
  struct Gap {
    std::string body;
    double distance = 0;  ///< [m], > 0
  };
  /// A force beside the move, on what the move before it felt. The move ends where there is nothing left to press on.
  struct Press {
    Eigen::Vector3d direction_W = Eigen::Vector3d::UnitX();  ///< unit
    double force = 0;                                        ///< [N], > 0
  };
  std::string name;
  Eigen::VectorXd posture{};  ///< where joints go (n_a), in a scenario without a tool, with `until` each branch until its own link touches
  Eigen::Vector3d direction_W = -Eigen::Vector3d::UnitZ();  ///< d, unit
  double travel = 0;                                        ///< at most [m], > 0
  double speed = 0.02;                                      ///< [m/s], > 0
  std::optional<Until> until;
  std::optional<Gap> gap;
  std::optional<Press> press;
  std::string correct;  ///< fixed body that is moved along d to where it, or its edge, was felt; empty: none
};

/// An arm that goes to a posture among things that it does not know, as a YAML file says (tasks/touch_scenario_file.hpp).
struct TouchScenario {
  ControlScenario arm;      ///< what is known: model, start, controller, plant, estimator. Without a reference; contacts are estimated
  Eigen::VectorXd goal;     ///< joints (n_a)
  double speed = 0.15;      ///< of any point of the arm, at most [m/s]
  int max_touches = 20;     ///< after which the arm gives up, ≥ 1
  double tolerance = 0.01;  ///< of the largest joint at the goal [rad, L of the robots]
  std::vector<UnknownBody> unknown;
  std::vector<MisplacedBody> misplaced;
  double friction_motion =
      0;  ///< joints go to and fro by so much before the moves, which tells their friction [rad; m], ≥ 0; 0: they do not
  std::vector<GuardedMove> moves;  ///< of the tool, or where there is none of joints, in place of `goal`: run_guarded()
};

/// The known scene and what is not known, in the places of this seed.
/// @throws core::InvalidInput: the arm at its start touches something
std::shared_ptr<const world::Model> make_world(const TouchScenario& scenario, std::uint64_t seed);

/// Moves the objects that stand on misplaced bodies by as much as these are elsewhere in `to` than in `from`. @param q_u  objects (n_qu)
void move_objects(const TouchScenario& scenario, const world::Model& from, const world::Model& to, Eigen::VectorXd& q_u);

}  // namespace stiction::execution
