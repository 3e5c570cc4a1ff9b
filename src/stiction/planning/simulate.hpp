#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "stiction/planning/setting.hpp"

namespace stiction::planning {

/// Largest penetration, gap under force and press along commands; also used as limits on them.
struct Worst {
  double penetration = 0, force_gap = 0;  ///< [contact tolerances of their pairs] (contact_limits.hpp)
  double press = 0;                       ///< see PressLimits::share

  bool within(const Worst& most) const { return penetration <= most.penetration && force_gap <= most.force_gap && press <= most.press; }
};
inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();
inline constexpr Worst kAnything{kUnlimited, kUnlimited, kUnlimited};

/// How commands are divided into simulation steps.
struct Pace {
  enum class Kind {
    SubSteps,       ///< each command moves in parts within `limits` and motor efforts (dynamics::rollout); knots have contacts
    WithinEfforts,  ///< each command is one step; a command that a motor cannot follow is reduced
    Steps,          ///< each command is one step
    HalfSteps,      ///< each command is reached in two equal parts, one step each, as in the checker's replay
  };
  Kind kind = Kind::SubSteps;
  dynamics::StepOptions step{};
  dynamics::SubstepLimits limits{};                     ///< used with SubSteps
  dynamics::Overrun overrun = dynamics::Overrun::Stop;  ///< used with SubSteps
};

/// Differences between a simulation and the scene (Kind::Steps only).
struct Disturbance {
  const Eigen::VectorXd* friction_factors = nullptr;  ///< factors on the μ of each pair of the model; null: 1
  double tilt = 0;                                    ///< angle by which gravity is tilted [rad]
  int side = 0;                                       ///< direction of the tilt, one of dynamics::kDisturbances
};

/// A place where objects may be.
struct Place {
  const Eigen::VectorXd* q = nullptr;  ///< configuration (n_q); null: anywhere
  Allowance within{};
};

/// Conditions that end a simulation before its last command.
struct Watch {
  Worst most = kAnything;
  bool brace = false;             ///< end before the robot presses on itself or on fixed bodies harder than SceneThresholds::brace
  std::array<Place, 2> places{};  ///< the objects must be at the first place or at the second one
};

/// How a simulation ended.
enum class Ending {
  Reached,     ///< all commands were followed
  Moved,       ///< the objects left the places of Watch, or a bystander moved farther than it may
  OverLimits,  ///< a limit of Watch was exceeded, or something slid or recoiled farther than a sub-step allows
  Unsolved,    ///< the solver did not solve a step
  Stopped,     ///< the run was stopped
};

/// The present state of a simulation, and how it got there.
struct Trace {
  Eigen::VectorXd q{}, u{};             ///< present state and command
  std::vector<dynamics::Knot> knots{};  ///< one per sub-step with SubSteps, else one per command, without contacts
  Worst worst{};
  bool started = false;  ///< true after the first step: penetrations of the given state do not count
};

/// Follows commands with the exact dynamics. The same class serves tree, regrasps, verification, settling and refinement.
/// Tests: tests/planning/simulate_test.cpp
class Simulation {
 public:
  /// @param work  counts the steps
  Simulation(const Setting& setting, SimulationScratch& scratch, Work& work) : setting_(setting), scratch_(scratch), work_(work) {}

  /// Follows the commands one after the other from `at`, and leaves `at` where the simulation ended: with Kind::SubSteps at the last state
  /// that Watch allows, with the other kinds at the first state that it does not allow.
  Ending follow(std::span<const Eigen::VectorXd> commands, const Pace& pace, const Disturbance& disturbance, const Watch& watch, Trace& at);
  Ending follow(const Eigen::VectorXd& command, const Pace& pace, const Watch& watch, Trace& at) {
    return follow(std::span(&command, 1), pace, {}, watch, at);
  }
  /// Holds the command of `at` for at most `most` steps. `rests` tells whether the objects then move by less than `rest` in one step.
  Ending hold(int most, const Allowance& rest, const Pace& pace, const Disturbance& disturbance, const Watch& watch, Trace& at,
              bool& rests);
  /// True if the last state meets the limits as well. Each step looks at penetration only where it starts.
  bool ends_well(const Watch& watch, Trace& at);

 private:
  Ending roll(const Eigen::VectorXd& command, const Pace& pace, const Watch& watch, Trace& at);
  Ending step(const Eigen::VectorXd& command, const Pace& pace, const Disturbance& disturbance, const Watch& watch, Trace& at);
  bool solve(const Eigen::VectorXd& q, Eigen::VectorXd& u, const Pace& pace, const Disturbance& disturbance);
  bool stays(const Eigen::VectorXd& q, const Watch& watch) const;

  const Setting& setting_;
  SimulationScratch& scratch_;
  Work& work_;
};

/// Commands of knots, and columns of a matrix, as a list.
std::vector<Eigen::VectorXd> commands_of(std::span<const dynamics::Knot> knots);
std::vector<Eigen::VectorXd> commands_of(const Eigen::MatrixXd& columns);

/// Paces of the search: sub-steps, and half sub-steps that depend on their state alone.
Pace substeps(const Setting& setting);
Pace half_steps(const Setting& setting);

/// Computes the contact forces of every sub-step of a segment that starts at q, because the tree stores none.
void add_forces(const world::Model& model, const dynamics::StepOptions& options, Eigen::VectorXd q, Segment& segment,
                SimulationScratch& scratch, Work& work);

}  // namespace stiction::planning
