#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "stiction/planning/setting.hpp"

namespace stiction::planning {

/// The worst that was met along commands, or how much of it is allowed.
struct Worst {
  double penetration = 0, force_gap = 0;  ///< in contact tolerances of their pairs (contact_limits.hpp)
  double press = 0;                       ///< PressLimits::share

  bool within(const Worst& most) const { return penetration <= most.penetration && force_gap <= most.force_gap && press <= most.press; }
};
inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();
inline constexpr Worst kAnything{kUnlimited, kUnlimited, kUnlimited};

/// How commands become steps.
struct Pace {
  enum class Kind {
    SubSteps,       ///< the command moves in parts within `limits` and motors (dynamics::rollout); knots have contacts
    WithinEfforts,  ///< each command is one step; a command that a motor cannot follow is drawn back
    Steps,          ///< each command is one step
    HalfSteps,      ///< each command is reached in two equal parts, a step each: how the checker replays a plan
  };
  Kind kind = Kind::SubSteps;
  dynamics::StepOptions step{};
  dynamics::SubstepLimits limits{};                     ///< of SubSteps
  dynamics::Overrun overrun = dynamics::Overrun::Stop;  ///< of SubSteps
};

/// What differs from the scene in a simulation (Kind::Steps alone).
struct Disturbance {
  const Eigen::VectorXd* friction_factors = nullptr;  ///< every μ times this (pairs of the model); null: 1
  double tilt = 0;                                    ///< gravity comes from this far aside [rad] …
  int side = 0;                                       ///< … from one of dynamics::kDisturbances sides
};

/// A place where objects may be.
struct Place {
  const Eigen::VectorXd* q = nullptr;  ///< (n_q); null: anywhere
  Allowance within{};
};

/// What ends a simulation before its commands do.
struct Watch {
  Worst most = kAnything;
  bool brace = false;             ///< the robot may not press harder than `brace` on itself or on what does not move
  std::array<Place, 2> places{};  ///< the objects are at the first one, or at the second one
};

/// How a simulation ended.
enum class Ending {
  Reached,     ///< all commands were followed
  Moved,       ///< the objects left the places that Watch names, or a bystander went farther than it may
  OverLimits,  ///< something was worse than Watch::most, or slid or recoiled farther than a sub-step may
  Unsolved,    ///< a step was not solved
  Stopped,     ///< the run is to end
};

/// Where a simulation is, and how it came there.
struct Trace {
  Eigen::VectorXd q{}, u{};             ///< state and command reached
  std::vector<dynamics::Knot> knots{};  ///< of every sub-step; one for each command with the other kinds of Pace, without contacts
  Worst worst{};
  bool started = false;  ///< the first state may penetrate what it was given in
};

/// Follows commands with the exact dynamics. One of these is used by tree, regrasps, verification, settling and refinement alike.
/// Tests: tests/planning/simulate_test.cpp
class Simulation {
 public:
  /// @param work  counts up
  Simulation(const Setting& setting, SimulationScratch& scratch, Work& work) : setting_(setting), scratch_(scratch), work_(work) {}

  /// From `at` along the commands, one after the other. `at` is left where the simulation ended: at the last state that Watch allows with
  /// Kind::SubSteps, at the first one that it does not allow with the others.
  Ending follow(std::span<const Eigen::VectorXd> commands, const Pace& pace, const Disturbance& disturbance, const Watch& watch, Trace& at);
  Ending follow(const Eigen::VectorXd& command, const Pace& pace, const Watch& watch, Trace& at) {
    return follow(std::span(&command, 1), pace, {}, watch, at);
  }
  /// Holds the command of `at` for up to so many steps, until the objects move by less than `rest` in one.
  Ending hold(int most, const Allowance& rest, const Pace& pace, const Disturbance& disturbance, const Watch& watch, Trace& at,
              bool& rests);
  /// Looks at the end of the commands, where no step has looked yet.
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

/// Commands of knots, and of the columns of a matrix.
std::vector<Eigen::VectorXd> commands_of(std::span<const dynamics::Knot> knots);
std::vector<Eigen::VectorXd> commands_of(const Eigen::MatrixXd& columns);

/// Paces of the search: sub-steps; half of them from each state alone.
Pace substeps(const Setting& setting);
Pace half_steps(const Setting& setting);

/// The contact forces of every sub-step of a segment that starts at q; the tree keeps none.
void add_forces(const world::Model& model, const dynamics::StepOptions& options, Eigen::VectorXd q, Segment& segment,
                SimulationScratch& scratch, Work& work);

}  // namespace stiction::planning
