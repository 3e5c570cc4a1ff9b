#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/execution/open_loop/speed_limits.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/world/model.hpp"

// Plans as functions of time: docs/theory/execution.md.

namespace stiction::execution {

using dynamics::VectorRef;

/// A piece of a plan between contact samples: contact edges that follow each other, one regrasp, or the settling of the start. The pieces of
/// contact edges are the segments of the thesis (3.6.1).
struct Piece {
  planning::SegmentKind kind = planning::SegmentKind::Contact;
  int first_segment = 0, last_segment = 0;  ///< of the plan, both included
  Eigen::Index first_knot = 0;              ///< of the trajectory: the state from which it starts
  Eigen::Index last_knot = 0;               ///< … and that it reaches
};

/// Commands u(t), linear between knots, and the configurations that the plan predicts for them.
struct Trajectory {
  Eigen::VectorXd times;     ///< (knots) [s], increasing, the first one 0
  Eigen::MatrixXd u;         ///< (n_a × knots)
  Eigen::MatrixXd q;         ///< (n_q × knots)
  Eigen::VectorXi segments;  ///< (knots) of the plan, that led to the knot; 0 of the first one
  Eigen::VectorXi knots;     ///< (knots) of the plan, counted from its start, which is 0: whose sub-step ends here or is under way
  std::vector<Piece> pieces;
  double speed = 1;  ///< times the full timing (E.13)
  double duration() const { return times.size() == 0 ? 0.0 : times[times.size() - 1]; }
};

/// Time parameterisation: the knot after u_k comes Δt_k = max_j |u_{k+1,j} − u_{k,j}| / v_j later (E.1), so that at every moment one joint
/// moves at its limit and none faster, and later where springs are strained or let go (E.9); regrasps have other speeds (E.8), for which knots are put in between. Knots that come less than 1 µs later replace the one before them. The settling of the start is
/// left out: the trajectory begins at its end, at rest on the constraints.
/// @throws core::InvalidInput: limits out of range, a plan without knots or with sizes that are not those of the model
Trajectory make_trajectory(const world::Model& model, const planning::Plan& plan, const SpeedLimits& limits);

/// Segment of the plan that is under way at time t, with the pause after it.
int segment_at(const Trajectory& trajectory, double t);

/// u at time t; the ends are held. @param u (n_a)
void interpolate_command(const Trajectory& trajectory, double t, Eigen::Ref<Eigen::VectorXd> u);

/// q at time t: straight for positions and joints, the shortest rotation at constant speed for orientations; the ends are held.
void interpolate(const world::Model& model, const Trajectory& trajectory, double t, Eigen::Ref<Eigen::VectorXd> q);

/// The plan with the states of its contact edges predicted anew in `substeps` equal parts each, from the state in which the plan enters
/// the piece: 1 is the single step per extension of the thesis. Commands are the straight line from the first to the last of each edge.
/// Regrasps and the start stay as they are.
/// @returns Solved, or the status of the step that failed; `out` then holds what was predicted until there
core::Status predict(const world::Model& model, const planning::Plan& plan, int substeps, planning::Plan& out);

/// A trajectory of the same segments, each of which takes as long as in `timing`, so that states that were predicted anew can be compared with a run of the
/// plan: by them springs would be let go at other times (E.9).
/// @throws core::InvalidInput: the trajectories are not of the same pieces
Trajectory retime(Trajectory trajectory, const Trajectory& timing);

}  // namespace stiction::execution
