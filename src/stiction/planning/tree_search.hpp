#pragma once

#include <atomic>
#include <limits>

#include "stiction/core/lanes.hpp"
#include "stiction/core/parallel.hpp"
#include "stiction/planning/contact_change.hpp"
#include "stiction/planning/plan_path.hpp"
#include "stiction/planning/subgoal.hpp"
#include "stiction/planning/verify.hpp"

namespace stiction::planning {

/// What a tree has come to.
struct Counts {
  long iterations = 0, nodes = 0;
  Totals totals;
  long cost = 0;  ///< TreeSearch::cost()

  Counts& operator+=(const Counts& o) {
    iterations += o.iterations;
    nodes += o.nodes;
    totals += o.totals;
    return *this;
  }
};

/// The threads of a run and their workspaces, shared by its trees.
struct Crew {
  Crew(const std::shared_ptr<const world::Model>& model, int threads, const core::RunControl& control)
      : pool(threads > 0 ? threads : core::hardware_threads()) {
    for (int i = 0; i < pool.size(); ++i) scratch.emplace_back(model, control);
  }
  core::ThreadPool pool;
  std::vector<ThreadScratch> scratch;
  std::atomic<long> extensions{0};  ///< of all trees
  std::atomic<bool> over{false};    ///< what is still under way comes too late
};

/// Algorithm 2: one tree, grown in rounds so that it does not depend on the number of threads (core::LaneTask).
class TreeSearch final : public core::LaneTask {
 public:
  /// @param u_start  commands at the start (n_a); empty: joints are commanded where they are
  /// @param bound    nodes that cost as much to come to are left out [s]
  TreeSearch(const PlanningProblem& problem, const Eigen::VectorXd& u_start, const PlannerOptions& options, const core::RunControl& control,
             double bound, Crew& crew, PlanResult& result);

  /// Turns grow the tree, from where it was, to so many extensions in all.
  void grow_to(long iterations) { limit_ = iterations; }
  int turn(int thread) override;
  void work(int item, int thread) override;
  /// About the time that it took: a local model takes as long as two steps, and draws that come to nothing are not for nothing.
  long cost() const override { return iterations_ + totals_.steps + 2 * totals_.linearisations; }

  void report();
  /// From now on reports tell what the tree has gained.
  void watch(GrowthSink grown) { grown_ = std::move(grown); }
  /// Writes the tree and its best path into the result.
  void finish();
  Counts counts() const { return {iterations_, tree_.size(), totals_, cost()}; }
  /// The last ones at which it had cost no more.
  Counts counts_at(long cost) const;
  long iterations() const { return iterations_; }
  /// Of the best node: how far the objects are from the goal, in tolerances.
  double goal_ratio() const { return best_ < 0 ? std::numeric_limits<double>::infinity() : tree_[best_].goal_ratio; }
  /// The tree comes no nearer to the goal any more. Trees of jumps, and those that are to have a certain size, never stall.
  bool stalled() const;

 private:
  /// Lets the given start settle under the exact dynamics with the robot commanded where it is.
  bool plant_root(ThreadScratch& scratch);
  /// Takes in what came of a round; the root comes before the first one. @returns MaxIterations: nothing final
  core::Status take_in(ThreadScratch& scratch);
  bool may_go_on();
  void tell_growth();
  int draw_round();
  /// No branch moves a geometry that may touch an object, or every contact sample so far failed.
  bool cannot_touch();
  void expand(Expansion& x, ThreadScratch& scratch);
  /// Cost and local model of a new node; false where it is none.
  bool complete(const Node& parent, Expansion& x, ThreadScratch& scratch, Node& node);
  /// The last node of the chain is worth another extension: it is a new grasp, or nearer the subgoal than the node before.
  bool goes_on(const Expansion& x, const Node& near) const;
  /// One more extension towards the subgoal. False at the end of the chain; its last node is gone when it is not to be built on.
  bool lengthen(Expansion& x, const Node& near, const EdgeReplay& near_replay, ThreadScratch& scratch);
  void record_verdict(Expansion& x);
  /// The nodes of an x; true when one of them is at the goal and the search ends there.
  bool insert(Expansion& x, ThreadScratch& scratch);
  /// @param taken  the node was extended towards the goal already
  int insert(Node node, bool taken);
  /// Node::goal_ratio and goal_distance: of the farther of the two resolutions, once both are known.
  std::pair<double, double> how_far(const Eigen::VectorXd& q, const EdgeReplay& replay) const;
  void set_replay(int i, EdgeReplay replay);
  /// At the goal at both resolutions, from all disturbed starts; then the path is kept. A regrasp serves nothing at the end, and is cut off there.
  bool reaches_goal(int node, ThreadScratch& scratch);
  bool verify_at_goal(int node, ThreadScratch& scratch);
  /// A plan that rests on the sixth digit of a command is none: at half the sub-step, with commands that are off by kNoise, it still reaches the goal.
  /// Else everything behind the edge that went elsewhere is taken out of the search.
  bool survives_noise(const std::vector<int>& path, ThreadScratch& scratch);
  void keep(const std::vector<int>& path, bool forces, ThreadScratch& scratch);

  double bound_;
  const Setting setting_;
  const Eigen::VectorXd& u_start_;
  const core::RunControl& control_;
  GrowthSink grown_;
  int told_ = 0;  ///< nodes that it was told of
  PlanResult& result_;
  EdgeSimulator simulator_;
  NodeModels models_;
  Extend extend_;
  ContactChange contact_change_;
  EdgeVerifier verifier_;
  SubgoalSampler subgoals_;
  PathWriter writer_;
  Tree tree_;
  Crew& crew_;
  std::vector<Expansion> round_;
  std::vector<int> order_;       ///< in which its expansions are worked on
  int drawn_ = 0;                ///< so many of them were drawn and not yet taken in
  std::vector<Counts> counted_;  ///< after each turn
  long iterations_ = 0, limit_ = 0;
  int best_ = -1;
  double least_distance_ = std::numeric_limits<double>::infinity();  ///< of the objects from the goal, in tolerances
  long last_gain_ = 0;                                               ///< extensions after which it last became less
  Totals totals_;
};

}  // namespace stiction::planning
