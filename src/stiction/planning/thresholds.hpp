#pragma once

#include "stiction/dynamics/rollout.hpp"
#include "stiction/world/scales.hpp"

// The numbers that decide something in search and refinement; shares of L and F that other layers know as well are in world/scales.hpp. Lengths are shares of L, forces of F (world/scales.hpp), distances from the goal are
// in tolerances of the goal.

namespace stiction::planning {

/// How far objects may be from a place.
struct Allowance {
  double position = 0;  ///< [m]
  double angle = 0;     ///< [rad]
};

namespace threshold {

// ---- what is kept by an edge, and by a plan
inline constexpr double kStep = 0.1;             ///< time step of the search [s]
inline constexpr double kFidelityEdge = 0.15;    ///< whole and half sub-steps agree on an edge up to this [tolerances]
inline constexpr double kFidelityPath = 0.8;     ///< … and on the whole path up to this [tolerances]
inline constexpr double kRestMove = 1e-4;        ///< objects rest when they move less than this in a step of kStep [L of the robots] …
inline constexpr double kRestTurn = 1e-5;        ///< … and turn less than this [rad]
inline constexpr double kMotionless = 0.01;      ///< a push that moves no object farther than this [L of the robots] …
inline constexpr double kMotionlessTurn = 1e-3;  ///< … or turns none farther than this [rad] is dropped by refinement
inline constexpr int kMostSettling = 100;        ///< steps that a start may take to come to rest

// ---- margins of pushes (docs/decisions/0013-plans-that-hold.md)
inline constexpr double kStartNoise = 0.2;     ///< error of objects where a push starts [tolerances]
inline constexpr double kEdgeTilt = 0.05;      ///< gravity aside by this, from four sides [rad]
inline constexpr double kFrictionNoise = 0.3;  ///< μ less by this share at half of what touches
inline constexpr int kTiltHeld = 3;            ///< steps for which the last command is held then

// ---- regrasps
inline constexpr double kReleaseTilt = 0.1;    ///< a release is stable if objects stay with gravity aside by this, from four sides [rad]
inline constexpr double kRegraspAngle = 0.02;  ///< an object may turn by this while branches move [rad]
inline constexpr int kMostHeld = 20;           ///< steps for which a command is held until objects rest
inline constexpr int kCandidates = 32;         ///< postures in contact that are drawn for a regrasp …
inline constexpr int kTrials = 4;              ///< … and how many of the most promising are simulated
inline constexpr long kStableReleases = 20;    ///< where fewer than one in so many releases is stable, a search takes unstable ones as well
inline constexpr int kBranchDraws = 30;        ///< draws of branches, until some may leave the objects stable
inline constexpr double kGraspProbability = 0.3;  ///< share of the expansions that change contacts

// ---- search
inline constexpr double kLength = 0.3;            ///< ‖δu‖ of an extension at most [rad, L of the robots]
inline constexpr double kWorth = 0.02;            ///< what a command of a joint unit counts for beside an error of the objects [L]
inline constexpr double kForceReach = 0.1;        ///< contacts farther apart than this do not bound an extension by their forces [L]
inline constexpr double kInCones = 0.5;           ///< share of the expansions whose contact forces stay in their cones
inline constexpr double kSameCommand = 0.1;       ///< another extension from a node differs from earlier ones by this share of its length
inline constexpr double kSharpening = 10;         ///< κ grows up to this factor, as objects come within as many tolerances of the goal
inline constexpr std::size_t kLongestChain = 12;  ///< extensions in a row towards one subgoal
inline constexpr double kProgress = 0.95;         ///< an extension has come nearer when less than this share of the distance is left
inline constexpr double kByPlaceToGoal =
    0.25;  ///< share of the pushes to the goal that start where objects are nearest to it, not by the metric …
inline constexpr double kByPlace = 0.5;  ///< … and of all expansions to drawn places
inline constexpr double kVisit =
    0.2;  ///< a node, or a cell beside the mean, that was visited five times counts as twice as far from the goal
inline constexpr double kCell = 0.1;           ///< objects nearer than this share of (1 + distance from the goal) share a cell [tolerances]
inline constexpr double kGain = 0.9;           ///< a tree stalls when less than this share of the distance was not left …
inline constexpr long kLeastStall = 1000;      ///< … for so many extensions, and for half of all that it had
inline constexpr int kTrees = 2;               ///< trees that grow side by side
inline constexpr double kSlippery = 0.7;       ///< … every second of them with this share of the friction, by Coulomb's law
inline constexpr int kBatch = 8;               ///< expansions under way at once in all trees: a round
inline constexpr long kHopelessSamples = 100;  ///< draws of postures that all fail before the robot is said to be unable to touch an object
inline constexpr long kPatience = 4;           ///< a search for a cheaper path takes so many times the extensions of the first one …
inline constexpr long kLeastPatience = 1000;   ///< … or so many

// ---- refinement
inline constexpr double kFarOff = 0.5;  ///< a regrasp may leave objects this far from where they are wanted [tolerances]
inline constexpr double kLost = 2;      ///< a push that ends farther than this from its place is given up [tolerances]
inline constexpr double kStrayed = 4;   ///< … and on its way farther away than this [tolerances]
inline constexpr double kAgree = 0.45;  ///< a search for what is left starts where whole and half sub-steps agree up to this [tolerances]
inline constexpr double kMovedBranch =
    5e-3;  ///< a branch whose posture differs by more than this between two pushes has moved [rad, L of the robots]

}  // namespace threshold

/// The thresholds of one scene, in its units.
struct SceneThresholds {
  /// @param object  that of the goal
  SceneThresholds(const world::Model& model, int object);

  dynamics::Analytic smoothing;     ///< κ of local models
  double gamma = 0;                 ///< γ of (3.5) [m²]
  dynamics::SubstepLimits substep;  ///< of a sub-step of the search
  double clearance = 0;             ///< that moving branches keep to everything between their contacts [m]
  Allowance rest;                   ///< objects that move less in a step of kStep rest
  Allowance motionless;             ///< motion that counts as none
  Allowance regrasp;                ///< how far objects may move while branches go to new contacts …
  Allowance release;                ///< … and while branches let go of them before
  double preload = 0;               ///< strain of the springs that a push starts with, at most [N at the reach of a joint]
  double brace = 0;                 ///< a push ends before the robot presses harder on itself or on what does not move [N]
};

}  // namespace stiction::planning
