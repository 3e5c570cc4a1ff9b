#pragma once

#include <map>

#include "stiction/planning/contact_change.hpp"
#include "stiction/planning/plan_path.hpp"
#include "stiction/planning/tools.hpp"
#include "stiction/planning/verify.hpp"

namespace stiction::planning {

/// One tree, with the parts of an iteration of Algorithm 2 for edges that can be carried out. The loop is in search.cpp.
class TreeSearch {
 public:
  /// @param u_start  commands at the start (n_a); empty: the positions of the joints
  /// @param bound    nodes whose path costs at least this are left out [s]
  TreeSearch(const Setting& setting, const Eigen::VectorXd& u_start, std::uint64_t seed, double bound);

  /// Settles the given start and makes it the root. @returns false: it does not come to rest or has no local model; result.reason says why
  bool plant_root(ThreadScratch& scratch, PlanResult& result);
  /// SampleSubgoal of Alg. 2: the goal or a drawn place, for a push or a regrasp. May take the node from the frontier.
  Expansion draw();
  /// Nearest and Extend of Alg. 2, or a contact sample of 3.4.3, with the replay at half steps. Does not change the tree.
  void expand(Expansion& x, ThreadScratch& scratch) const;
  /// True if the node is at the goal at both resolutions and from all disturbed starts. A node to which a regrasp leads does not count.
  bool reaches_goal(int node, ThreadScratch& scratch);
  /// AddNode of Alg. 2. @returns the node at which the goal is reached and the path holds, or −1
  int insert(Expansion& x, ThreadScratch& scratch);

  const Tree& tree() const { return tree_; }
  const Totals& totals() const { return totals_; }
  /// Adds the nodes at which regrasps were rejected, in the order in which the nodes were made.
  void add_refused(std::vector<RefusedMoves>& out) const;
  long iterations() const { return iterations_; }
  /// Error of the best node at the goal, in tolerances.
  double goal_ratio() const { return tree_[tree_.best()].goal_ratio; }
  /// Number of extensions since the last gain towards the goal, as a share of the number after which the tree stalls.
  double waiting() const;
  /// True if the tree has come no nearer to the goal for so long that a new tree should replace it.
  bool stalled() const;
  /// The path to a node as a plan. @param forces  add the contact forces of every sub-step, at the cost of one step each
  Plan plan_to(int node, bool forces, ThreadScratch& scratch);

 private:
  /// Sets the objects that the subgoal is about. For a tool it also draws the place where the tool should be.
  void aim(Expansion& x, core::Random& random, ThreadScratch& scratch) const;
  int find_near(const Expansion& x) const;
  /// Computes cost and local model of a new node. @returns false: the node is too expensive or has no local model
  bool complete(const Node& parent, ThreadScratch& scratch, Totals& totals, Node& node) const;
  /// True if the last node of the chain deserves another extension: it is a new grasp, or nearer to the subgoal than the node before.
  bool goes_on(const Expansion& x, const Node& near) const;
  /// Adds an extension towards the subgoal. @returns false at the end of the chain. A last node that fails its verification is removed.
  bool lengthen(Expansion& x, const Node& near, const EdgeReplay& near_replay, ThreadScratch& scratch) const;
  void record_verdict(Expansion& x);
  int insert(Node node, bool visited);
  /// Node::goal_ratio and Node::goal_distance: the larger values of the two resolutions, once both are known.
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
  std::map<int, RegraspCounts> refused_;  ///< rejected regrasps, by node
  long drawn_ = 0, iterations_ = 0;
  double least_distance_;  ///< least distance of the objects from the goal so far, in tolerances
  long last_gain_ = 0;     ///< number of extensions when least_distance_ last fell
};

}  // namespace stiction::planning
