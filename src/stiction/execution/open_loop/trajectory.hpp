#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/execution/open_loop/speed_limits.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/world/model.hpp"

// Plans as functions of time: docs/theory/execution.md.

namespace stiction::execution {

using dynamics::VectorRef;

/// A piece of a plan between contact samples: consecutive contact edges, one regrasp, or the settling of the start. Pieces of contact edges are the segments of
/// the thesis (3.6.1).
struct Piece {
  planning::SegmentKind kind = planning::SegmentKind::Contact;
  int first_segment = 0, last_segment = 0;  ///< segments of the plan, both included
  Eigen::Index first_knot = 0;              ///< knot of the trajectory at which the piece starts
  Eigen::Index last_knot = 0;               ///< knot that it reaches
};

/// Commands u(t), linear between knots, and the configurations that the plan predicts for them.
struct Trajectory {
  Eigen::VectorXd times;     ///< times of the knots [s], increasing, the first one 0
  Eigen::MatrixXd u;         ///< (n_a × knots)
  Eigen::MatrixXd q;         ///< (n_q × knots)
  Eigen::VectorXi segments;  ///< per knot: segment of the plan that leads to it; 0 for the first one
  /// Per knot: knot of the plan whose sub-step ends here or is under way, counted from the start of the plan, which is 0.
  Eigen::VectorXi knots;
  std::vector<Piece> pieces;
  double speed = 1;  ///< factor of the full speed (E.13)
  double duration() const { return times.size() == 0 ? 0.0 : times[times.size() - 1]; }
};

/// Times a plan within speed limits. The knot after u_k comes Δt_k = max_j |u_{k+1,j} − u_{k,j}| / v_j later (E.1), so at every moment one joint moves at its
/// limit and none faster. It comes later if springs are loaded or unloaded (E.9). Regrasps have other speeds (E.8), for which knots are added in between. Knots
/// that would come less than 1 µs later replace the one before them. The settling of the start is left out: the trajectory begins at its end, at rest.
/// @throws core::InvalidInput: limits out of range, a plan without knots or with sizes that are not those of the model
Trajectory make_trajectory(const world::Model& model, const planning::Plan& plan, const SpeedLimits& limits);

/// Segment of the plan that is carried out at time t; the pause after a segment belongs to it.
int segment_at(const Trajectory& trajectory, double t);

/// Computes the command u (n_a) at time t. Before and after the trajectory, its first and last command are held.
void interpolate_command(const Trajectory& trajectory, double t, Eigen::Ref<Eigen::VectorXd> u);

/// Computes the configuration q (n_q) at time t: linear for positions and joints, the shortest rotation at constant speed for orientations. The ends are held.
void interpolate(const world::Model& model, const Trajectory& trajectory, double t, Eigen::Ref<Eigen::VectorXd> q);

/// Predicts the states of the contact edges of a plan anew, in `substeps` equal parts each, from the state in which the plan enters the piece. 1 is the single
/// step per extension of the thesis. The commands of an edge are the straight line from its first to its last command. Regrasps and the start stay unchanged.
/// @returns Solved, or the status of the step that failed; `out` then holds the states predicted before it
core::Status predict(const world::Model& model, const planning::Plan& plan, int substeps, planning::Plan& out);

/// Gives each segment of a trajectory the duration that it has in `timing`. States that were predicted anew can then be compared with a run of the plan:
/// timed by their own strains they would unload springs at other times (E.9).
/// @throws core::InvalidInput: the trajectories have different pieces
Trajectory retime(Trajectory trajectory, const Trajectory& timing);

}  // namespace stiction::execution
