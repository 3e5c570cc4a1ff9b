#pragma once

#include <map>

#include "stiction/planning/contact_change.hpp"
#include "stiction/planning/plan_path.hpp"
#include "stiction/planning/tools.hpp"
#include "stiction/planning/verify.hpp"

namespace stiction::planning {

/// One tree: what Algorithm 2 does in an iteration, for edges that are carried out. The loop is in search.cpp.
class TreeSearch {
 public:
  /// @param u_start  commands at the start (n_a); empty: joints are commanded where they are
  /// @param bound    nodes that cost as much to come to are left out [s]
  TreeSearch(const Setting& setting, const Eigen::VectorXd& u_start, std::uint64_t seed, double bound);

  /// The root: the given start, settled under the exact dynamics. @returns false: it does not come to rest, or has no local model; result.reason says why
  bool plant_root(ThreadScratch& scratch, PlanResult& result);
  /// Alg. 2, SampleSubgoal: the goal or a drawn place, for a push or a change of contacts; the node that is taken from the frontier.
  Expansion draw();
  /// Alg. 2, Nearest and Extend, or a contact sample of 3.4.3; with its replay at half steps. Changes nothing of the tree.
  void expand(Expansion& x, ThreadScratch& scratch) const;
  /// At the goal at both resolutions, and from all disturbed starts. A regrasp serves nothing at the end.
  bool reaches_goal(int node, ThreadScratch& scratch);
  /// Alg. 2, AddNode. @returns the node at which the goal is reached and the path holds, or −1
  int insert(Expansion& x, ThreadScratch& scratch);

  const Tree& tree() const { return tree_; }
  const Totals& totals() const { return totals_; }
  /// Adds the nodes from which moves to new contacts were refused, in the order of their making.
  void add_refused(std::vector<RefusedMoves>& out) const;
  long iterations() const { return iterations_; }
  /// Of the best node: how far the objects are from the goal, in tolerances.
  double goal_ratio() const { return tree_[tree_.best()].goal_ratio; }
  /// How long the tree has come no nearer to the goal, as a share of what makes it stalled.
  double waiting() const;
  /// The tree comes no nearer to the goal any more.
  bool stalled() const;
  /// The path to a node as a plan. @param forces  with those of every sub-step, which take a step each
  Plan plan_to(int node, bool forces, ThreadScratch& scratch);

 private:
  /// Which objects the subgoal is about, and of one that is not the goal's where it is to be.
  void aim(Expansion& x, core::Random& random, ThreadScratch& scratch) const;
  int find_near(const Expansion& x) const;
  /// Cost and local model of a new node; false where it is none.
  bool complete(const Node& parent, ThreadScratch& scratch, Totals& totals, Node& node) const;
  /// The last node of the chain is worth another extension: it is a new grasp, or nearer the subgoal than the node before.
  bool goes_on(const Expansion& x, const Node& near) const;
  /// One more extension towards the subgoal. False at the end of the chain; its last node is gone when it is not to be built on.
  bool lengthen(Expansion& x, const Node& near, const EdgeReplay& near_replay, ThreadScratch& scratch) const;
  void record_verdict(Expansion& x);
  int insert(Node node, bool visited);
  /// Node::goal_ratio and goal_distance: of the farther of the two resolutions, once both are known.
  std::pair<double, double> how_far(const Eigen::VectorXd& q, const EdgeReplay& replay) const;
  void set_replay(int i, EdgeReplay replay);

  const Setting& setting_;
  const Eigen::VectorXd& u_start_;
  const std::uint64_t seed_;
  const double bound_;
  const NodeModels models_;
  const Extend extend_;
  const ContactChange contact_change_;
  const EdgeVerifier verifier_;
  const Tools tools_;
  const PathWriter writer_;
  Tree tree_;
  Totals totals_;
  std::map<int, RegraspCounts> refused_;  ///< of nodes from which a move was refused
  long drawn_ = 0, iterations_ = 0;
  double least_distance_;  ///< of the objects from the goal, in tolerances
  long last_gain_ = 0;     ///< extensions after which it last became less
};

}  // namespace stiction::planning
