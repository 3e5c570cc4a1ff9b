#pragma once

#include <Eigen/Core>
#include <vector>

#include "stiction/planning/frontier.hpp"
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

/// Where a path from the root leads when it is replayed otherwise than the tree simulated it.
struct EdgeReplay {
  Eigen::VectorXd q_fine;     ///< at half its sub-steps (n_q)
  Eigen::MatrixXd disturbed;  ///< with each of the disturbances of the margins (n_q × kDisturbances), or none

  bool empty() const { return q_fine.size() == 0; }
};

/// A state of the tree and the edge that leads to it.
struct Node {
  int parent = -1;
  SegmentKind edge = SegmentKind::Contact;
  bool unstable = false;     ///< see Segment
  Eigen::VectorXd q;         ///< (n_q)
  Eigen::VectorXd u;         ///< command at q (n_a)
  Eigen::MatrixXd commands;  ///< of the edge's sub-steps, one column each (n_a × steps)
  Eigen::MatrixXd states;    ///< after each of them (n_q × steps)
  LocalModel local;
  double goal_ratio = 0;                              ///< worst of position and angle error, divided by the tolerance
  double goal_distance = 0;                           ///< of all objects from the goal, in tolerances
  int pushes = 0;                                     ///< that started on the path from the root
  EdgeReplay replay{};                                ///< empty until asked for
  double cost = 0;                                    ///< of the path from the root [s]
  std::vector<Eigen::VectorXd> tried{};               ///< commands of extensions from here (n_a each)
  std::vector<world::ChainMask> unstable_releases{};  ///< branches that leave the object unstable when they let go
};

/// The sub-steps of an edge become those of its node, and the last one its state.
void set_edge(const std::vector<dynamics::Knot>& knots, const world::Model& model, Node& node);

/// Nodes, and which one is extended next.
class Tree {
 public:
  /// @param weights  w of the distance Σ wᵢ eᵢ² between objects, in tolerances of the goal (n_v)
  /// @param of_goal  coordinates that the goal is about, when there are others; empty: all
  explicit Tree(const world::ObjectSpace& space, const Eigen::VectorXd& weights, std::vector<int> of_goal = {})
      : nearest_(space),
        places_(space),
        weights_(weights),
        of_goal_(std::move(of_goal)),
        by_metric_(space, weights),
        pushes_(space, weights),
        regrasps_(space, weights) {}

  /// @param q_goal   objects at the goal (n_qu)  @param visited  it was extended already
  int add(Node node, const Eigen::VectorXd& q_goal, bool visited = false);
  int size() const { return static_cast<int>(nodes_.size()); }
  const Node& operator[](int i) const { return nodes_[static_cast<std::size_t>(i)]; }

  /// argmin over the nodes of d(q_u; node) = eᵀ(B_uB_uᵀ + γI)⁻¹e with e = q_u ⊖ c_u (3.5), (3.8).
  /// @param v  coordinates of some of the objects (tangent), wherever the others are; empty: of all
  int nearest(const Eigen::VectorXd& q_u, const std::vector<int>& v = {}) const { return nearest_.nearest(q_u.data(), v); }

  /// The node whose objects are nearest to q_u, in tolerances of the goal: where a change of contacts towards q_u starts. It is none
  /// itself. −1 when there is none. @param v  as above
  int nearest_place(const Eigen::VectorXd& q_u, const std::vector<int>& v = {}) const { return places_.nearest(q_u.data(), v); }

  /// The node of the frontier whose push, by its local metric, comes nearest to the goal; −1 when there is none.
  int take_by_metric();
  /// The node of the frontier whose objects are nearest to the goal, for a push or a change of contacts; −1 when there is none. What a change of contacts
  /// starts from is none itself.
  int take_by_place(bool grasp);
  /// The node nearest to the goal that is not pruned.
  int best() const { return best_; }

  void add_tried(int i, Eigen::VectorXd u) { nodes_[static_cast<std::size_t>(i)].tried.push_back(std::move(u)); }
  void add_unstable_release(int i, world::ChainMask branches) { nodes_[static_cast<std::size_t>(i)].unstable_releases.push_back(branches); }
  /// Where the path to a node leads at half steps, and how far the node is from the goal by that.
  void set_replay(int i, EdgeReplay replay, double goal_ratio, double goal_distance);

  /// Takes a node out of every later search; it must have no children.
  void prune(int i);
  bool pruned(int i) const { return nearest_.removed(i); }

  /// Node indices from the root to i.
  std::vector<int> path_to(int i) const;

 private:
  void find_best();

  std::vector<Node> nodes_;
  NearestPoints nearest_, places_;  // by the metric of each node; by the distance of objects
  Eigen::VectorXd weights_;
  std::vector<int> of_goal_;
  Frontier by_metric_, pushes_, regrasps_;
  std::vector<double> effort_;  // by node: extensions to the goal by its metric
  int best_ = -1;
};

}  // namespace stiction::planning
