#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/planning/front.hpp"
#include "stiction/planning/nearest.hpp"
#include "stiction/planning/plan.hpp"
#include "stiction/world/robot_chains.hpp"

namespace stiction::planning {

/// Smoothed local model of a node (3.3): object motion ≈ c_u ⊕ B_u δu around u = qᵃ.
struct LocalModel {
  Eigen::VectorXd c_u;    ///< smoothed next configuration of the objects (n_qu)
  Eigen::MatrixXd B_u;    ///< (n_vu × n_a)
  Eigen::MatrixXd S;      ///< B_u D²B_uᵀ + Γ, the inverse of the metric (P.1) (n_vu × n_vu); empty once in a tree, like L_inv
  Eigen::MatrixXd L_inv;  ///< inverse of its Cholesky factor, lower triangular

  /// Factorises the metric. @param gamma  the diagonal of Γ, > 0 (n_vu)  @param joint_units  the diagonal of D (n_a); empty: 1, as in the thesis
  void set(const Eigen::VectorXd& q_next, const Eigen::MatrixXd& B, int n_qu, const Eigen::VectorXd& gamma,
           const Eigen::VectorXd& joint_units = {});
};

/// What comes of a path from the root when it is replay otherwise than the tree did.
struct EdgeReplay {
  Eigen::VectorXd q_fine;     ///< at half its sub-steps (n_q)
  Eigen::MatrixXd disturbed;  ///< with something otherwise than planned, one column per draw (n_q × kDisturbances), or none

  bool empty() const { return q_fine.size() == 0; }
};

/// A state of the tree and the edge that leads to it.
struct Node {
  int parent = -1;
  SegmentKind edge = SegmentKind::Contact;
  bool loose = false;        ///< see Segment
  Eigen::VectorXd q;         ///< (n_q)
  Eigen::VectorXd u;         ///< command at q (n_a)
  Eigen::MatrixXd commands;  ///< of the edge's sub-steps, one column each (n_a × steps)
  Eigen::MatrixXd states;    ///< after each of them (n_q × steps)
  LocalModel local;
  double goal_ratio = 0;                            ///< worst of position and angle error, divided by the tolerance
  double goal_distance = 0;                         ///< of all objects from the goal, in tolerances
  int pushes = 0;                                   ///< that started on the path from the root
  EdgeReplay replay{};                              ///< empty until asked for
  double cost = 0;                                  ///< of the path from the root [s]
  std::vector<Eigen::VectorXd> tried{};             ///< commands of extensions from here (n_a each)
  std::vector<world::ChainMask> failed_releases{};  ///< branches that cannot let go of the object together
  std::vector<world::ChainMask> loose_releases{};   ///< branches that can, but leave it loose
  bool cannot_release = false;                      ///< none can
};

/// Nodes, and the orders in which the search takes them. No choice scans all nodes.
class Tree {
 public:
  /// @param global_weights  diagonal of a metric that is the same everywhere (n_v); empty: every node has its own
  /// @param place_weights   w of nearest_for_regrasp (n_v); empty: 1
  explicit Tree(const world::ObjectSpace& space, Eigen::VectorXd global_weights = {}, Eigen::VectorXd place_weights = {})
      : nearest_(space),
        places_(space),
        cells_(space),
        global_weights_(std::move(global_weights)),
        place_weights_(std::move(place_weights)) {
    if (place_weights_.size() == 0) place_weights_.setOnes(space.n_v());
  }

  /// @param taken  it was taken towards the goal already
  int add(Node node, const Eigen::VectorXd& q_goal, bool taken = false);
  int size() const { return static_cast<int>(nodes_.size()); }
  const Node& operator[](int i) const { return nodes_[static_cast<std::size_t>(i)]; }

  /// argmin over the nodes of d(q_u; node) = eᵀ(B_uB_uᵀ + γI)⁻¹e with e = q_u ⊖ c_u (3.5), (3.8), or of Σ wᵢ eᵢ² with e = q_u ⊖ qᵘ.
  int nearest(const Eigen::VectorXd& q_u) const { return nearest_.nearest(q_u.data()); }

  /// argmin Σ wᵢ eᵢ² with e = q_u ⊖ qᵘ over the nodes at which branches may let go of the object: where a grasp for q_u starts. The
  /// posture will change, so that the node's metric says nothing. −1 when there is none.
  int nearest_for_regrasp(const Eigen::VectorXd& q_u) const { return places_.nearest(q_u.data()); }

  /// The node nearest to the goal among those never taken towards it before; marks it. −1 when none is left.
  int take_nearest_to_goal();

  /// The node to grasp anew from for the goal: what counts is how near the object is, since the robot's posture will change; every
  /// earlier choice makes a node less attractive. Marks it. −1 when none is left.
  int take_for_regrasp();

  /// The same for the node to push on from, regrasps included.
  int take_for_push();

  void add_tried(int i, Eigen::VectorXd u) { nodes_[static_cast<std::size_t>(i)].tried.push_back(std::move(u)); }
  void add_failed_release(int i, world::ChainMask branches) { nodes_[static_cast<std::size_t>(i)].failed_releases.push_back(branches); }
  void add_loose_release(int i, world::ChainMask branches) { nodes_[static_cast<std::size_t>(i)].loose_releases.push_back(branches); }
  void set_cannot_release(int i) {
    nodes_[static_cast<std::size_t>(i)].cannot_release = true;
    places_.remove(i);
  }
  /// What came of following a node, and how far it is from the goal by that.
  void set_replay(int i, EdgeReplay replay, double goal_ratio, double goal_distance) {
    Node& node = nodes_[static_cast<std::size_t>(i)];
    node.replay = std::move(replay);
    node.goal_ratio = goal_ratio;
    node.goal_distance = goal_distance;
  }

  /// Takes a node out of every later search; it must have no children.
  void prune(int i);
  bool pruned(int i) const { return nearest_.removed(i); }
  /// The same for a node and all behind it. @returns their number
  int prune_subtree(int i);

  /// Node indices from the root to i.
  std::vector<int> path_to(int i) const;

 private:
  /// Number of the cell of a node; a new one where no other is near.
  int cell_of(const Node& node);

  std::vector<Node> nodes_;
  NearestPoints nearest_;
  NearestPoints places_;  // of the objects at the nodes
  NearestPoints cells_;   // a place each, for Front
  Eigen::VectorXd global_weights_, place_weights_;
  Choices to_goal_;  // by d(q_goal; node); a node taken is gone
  Front to_regrasp_, to_push_;
};

}  // namespace stiction::planning
