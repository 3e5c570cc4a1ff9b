#pragma once

#include "stiction/dynamics/rollout.hpp"
#include "stiction/world/scales.hpp"

// Thresholds of search and refinement. Lengths are shares of L, forces are shares of F, and distances from the goal are in tolerances of
// the goal. L and F, and the shares that other layers use as well, are in world/scales.hpp.

namespace stiction::planning {

/// Limits on the displacement of objects from a place.
struct Allowance {
  double position = 0;  ///< [m]
  double angle = 0;     ///< [rad]
};

namespace threshold {

// ---- edges and plans
inline constexpr double kStep = 0.1;             ///< time step of the search [s]
inline constexpr double kFidelityEdge = 0.15;    ///< whole and half sub-steps may differ by this on one edge [tolerances]
inline constexpr double kFidelityPath = 0.8;     ///< whole and half sub-steps may differ by this on the whole path [tolerances]
inline constexpr double kRestMove = 1e-4;        ///< objects at rest move less than this in a step of kStep [L of the robots]
inline constexpr double kRestTurn = 1e-5;        ///< objects at rest turn less than this in a step of kStep [rad]
inline constexpr double kMotionless = 0.01;      ///< largest motion of objects in a push that refinement drops [L of the robots]
inline constexpr double kMotionlessTurn = 1e-3;  ///< largest turn of objects in a push that refinement drops [rad]
inline constexpr int kMostSettling = 100;        ///< most steps in which a start must come to rest

// ---- margins of pushes (docs/lab/margins.md)
inline constexpr double kStartNoise = 0.2;     ///< error of object poses at the start of a push [tolerances]
inline constexpr double kEdgeTilt = 0.05;      ///< tilt of gravity to each of four sides [rad]
inline constexpr double kFrictionNoise = 0.3;  ///< μ is reduced by this share at half of the contacts
inline constexpr int kTiltHeld = 3;            ///< steps for which the last command of a disturbed edge is held

// ---- regrasps
inline constexpr double kReleaseTilt = 0.1;  ///< a release is stable if objects stay with gravity tilted by this to any of four sides [rad]
inline constexpr double kRegraspAngle = 0.02;  ///< an object may turn by this while branches move to new contacts [rad]
inline constexpr int kMostHeld = 20;           ///< most steps for which a command is held until objects rest
inline constexpr int kCandidates = 32;         ///< postures in contact that are drawn for a regrasp
inline constexpr int kTrials = 4;              ///< number of the most promising postures that are simulated
inline constexpr long kStableReleases = 20;    ///< if fewer than one release in this many is stable, a search accepts unstable ones as well
inline constexpr int kBranchDraws = 30;        ///< most draws of branches, to find some whose release may be stable
inline constexpr double kGraspProbability = 0.3;  ///< share of the expansions that are regrasps

// ---- search
inline constexpr double kLength = 0.3;            ///< largest ‖δu‖ of an extension [rad, L of the robots]
inline constexpr double kWorth = 0.02;            ///< cost of one joint unit of command, as an error of the objects: √ρ of (P.2) [L]
inline constexpr double kForceReach = 0.1;        ///< contacts with a larger gap do not bound an extension by their forces [L]
inline constexpr double kInCones = 0.5;           ///< share of the expansions that keep contact forces inside their friction cones
inline constexpr double kSameCommand = 0.1;       ///< a node skips a command that is closer to an earlier one than this share of its length
inline constexpr double kSharpening = 10;         ///< κ grows up to this factor, beginning this many tolerances from the goal
inline constexpr std::size_t kLongestChain = 12;  ///< most extensions in a row towards one subgoal
inline constexpr double kProgress = 0.95;         ///< an extension came nearer if less than this share of the distance is left
inline constexpr double kByPlaceToGoal = 0.25;    ///< share of the pushes to the goal whose node is selected by place, not by metric
inline constexpr double kByPlace = 0.5;           ///< share of the expansions to drawn subgoals whose node is selected by place
inline constexpr double kVisit = 0.2;             ///< five visits of a node, or of a cell relative to the mean, double the cost (P.12)
inline constexpr double kCell = 0.1;           ///< objects nearer than this share of (1 + distance from the goal) share a cell [tolerances]
inline constexpr double kGain = 0.9;           ///< a tree gains if its distance from the goal falls below this share of its least distance
inline constexpr long kLeastStall = 1000;      ///< a tree stalls after max(this, half of all its extensions) extensions without gain
inline constexpr int kTrees = 2;               ///< number of trees that grow side by side
inline constexpr double kSlippery = 0.7;       ///< two trees in three plan with this share of the friction, by Coulomb's law
inline constexpr int kBatch = 8;               ///< expansions in one round, over all trees
inline constexpr long kHopelessSamples = 100;  ///< if this many draws of postures all fail, the robot counts as unable to touch an object
inline constexpr long kPatience = 4;           ///< a tree for a cheaper path gets this many times the extensions of the first search
inline constexpr long kLeastPatience = 1000;   ///< least number of extensions of a tree for a cheaper path

// ---- refinement
inline constexpr double kFarOff = 0.5;  ///< a regrasp may leave objects this far from where the next push starts [tolerances]
inline constexpr double kLost = 2;      ///< a push is rejected if it ends farther than this from its end in the plan [tolerances]
inline constexpr double kStrayed = 4;   ///< a push is rejected if it is ever farther than this from its way in the plan [tolerances]
inline constexpr double kAgree = 0.45;  ///< searches for the remaining way start where whole and half sub-steps agree to this [tolerances]
inline constexpr double kMovedBranch = 5e-3;  ///< a branch moves if its posture changes by more than this [rad, L of the robots]

}  // namespace threshold

/// The thresholds of one scene, in SI units.
struct SceneThresholds {
  /// @param object  index of the goal's object
  SceneThresholds(const world::Model& model, int object);

  dynamics::Analytic smoothing;     ///< smoothing of the local models, with their κ
  double gamma = 0;                 ///< γ of (3.5) [m²]
  dynamics::SubstepLimits substep;  ///< limits of a sub-step of the search
  double clearance = 0;             ///< distance that moving branches keep from everything between their contacts [m]
  Allowance rest;                   ///< objects rest if they move less than this in a step of kStep
  Allowance motionless;             ///< smaller motions of objects count as none
  Allowance regrasp;                ///< how far objects may move while branches go to new contacts
  Allowance release;                ///< how far objects may move while branches release them
  double preload = 0;               ///< largest spring strain at the start of a push [N at the reach of a joint]
  double brace = 0;                 ///< a push ends before the robot presses harder than this on itself or on fixed bodies [N]
};

}  // namespace stiction::planning
