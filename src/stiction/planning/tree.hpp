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
  Eigen::MatrixXd S;      ///< inverse of the metric (P.1): B_u D²B_uᵀ + Γ (n_vu × n_vu); empty once in a tree, like L_inv
  Eigen::MatrixXd L_inv;  ///< inverse of the Cholesky factor of S, lower triangular

  /// Sets model and metric. @param gamma  diagonal of Γ, > 0 (n_vu)  @param joint_units  diagonal of D (n_a); empty: 1, as in the thesis
  void set(const Eigen::VectorXd& q_next, const Eigen::MatrixXd& B, int n_qu, const Eigen::VectorXd& gamma,
           const Eigen::VectorXd& joint_units = {});
};

/// End states of the path from the root to a node when it is replayed otherwise than the tree simulated it.
struct EdgeReplay {
  Eigen::VectorXd q_fine;     ///< at half sub-steps (n_q)
  Eigen::MatrixXd disturbed;  ///< under each disturbance of the margins (n_q × kDisturbances); empty without margins

  bool empty() const { return q_fine.size() == 0; }
};

/// A state of the tree, with the edge that leads to it.
struct Node {
  int parent = -1;
  SegmentKind edge = SegmentKind::Contact;
  bool unstable = false;     ///< see Segment::unstable
  Eigen::VectorXd q;         ///< (n_q)
  Eigen::VectorXd u;         ///< command at q (n_a)
  Eigen::MatrixXd commands;  ///< commands of the sub-steps of the edge, one column each (n_a × steps)
  Eigen::MatrixXd states;    ///< states after these sub-steps (n_q × steps)
  LocalModel local;
  double goal_ratio = 0;                              ///< larger of position and angle error at the goal, in tolerances
  double goal_distance = 0;                           ///< distance of all objects from the goal, in tolerances
  int pushes = 0;                                     ///< number of pushes on the path from the root
  EdgeReplay replay{};                                ///< empty until computed
  double cost = 0;                                    ///< cost of the path from the root [s]
  std::vector<Eigen::VectorXd> tried{};               ///< commands of the extensions that were tried from here (n_a each)
  std::vector<world::ChainMask> unstable_releases{};  ///< branches whose release leaves the object unstable
};

/// Stores the sub-steps of an edge in its node; the last one gives the state of the node.
void set_edge(const std::vector<dynamics::Knot>& knots, const world::Model& model, Node& node);

/// The nodes of a search tree, and the choice of the node that is extended next.
class Tree {
 public:
  /// @param weights  w of the distance Σ wᵢ eᵢ² between objects, in tolerances of the goal (n_v)
  /// @param of_goal  coordinates of the goal's objects, if other objects serve as tools; empty: all
  explicit Tree(const world::ObjectSpace& space, const Eigen::VectorXd& weights, std::vector<int> of_goal = {})
      : nearest_(space),
        places_(space),
        weights_(weights),
        of_goal_(std::move(of_goal)),
        by_metric_(space, weights),
        pushes_(space, weights),
        regrasps_(space, weights) {}

  /// Adds a node. @param q_goal  objects at the goal (n_qu)  @param visited  the node was extended already
  int add(Node node, const Eigen::VectorXd& q_goal, bool visited = false);
  int size() const { return static_cast<int>(nodes_.size()); }
  const Node& operator[](int i) const { return nodes_[static_cast<std::size_t>(i)]; }

  /// argmin over the nodes of d(q_u; node) = eᵀ(B_uB_uᵀ + γI)⁻¹e with e = q_u ⊖ c_u (3.5), (3.8).
  /// @param v  tangent coordinates that count, while the others may have any value; empty: all
  int nearest(const Eigen::VectorXd& q_u, const std::vector<int>& v = {}) const { return nearest_.nearest(q_u.data(), v); }

  /// The node whose objects are nearest to q_u in tolerances of the goal, −1 if there is none. A regrasp towards q_u starts there. Nodes to
  /// which a regrasp leads are left out. @param v  as in nearest()
  int nearest_place(const Eigen::VectorXd& q_u, const std::vector<int>& v = {}) const { return places_.nearest(q_u.data(), v); }

  /// The frontier node that is nearest to the goal by its local metric, for a push; −1 if there is none.
  int take_by_metric();
  /// The frontier node whose objects are nearest to the goal, for a push or a regrasp; −1 if there is none. A regrasp does not start from a
  /// node to which another regrasp leads.
  int take_by_place(bool grasp);
  /// The node nearest to the goal that is not pruned.
  int best() const { return best_; }

  void add_tried(int i, Eigen::VectorXd u) { nodes_[static_cast<std::size_t>(i)].tried.push_back(std::move(u)); }
  void add_unstable_release(int i, world::ChainMask branches) { nodes_[static_cast<std::size_t>(i)].unstable_releases.push_back(branches); }
  /// Sets the replay of a node at half steps, and with it the distance of the node from the goal.
  void set_replay(int i, EdgeReplay replay, double goal_ratio, double goal_distance);

  /// Takes a node without children out of every later search.
  void prune(int i);
  bool pruned(int i) const { return nearest_.removed(i); }

  /// Node indices on the path from the root to i.
  std::vector<int> path_to(int i) const;

 private:
  void find_best();

  std::vector<Node> nodes_;
  NearestPoints nearest_, places_;  // by the metric of each node; by the distance of the objects
  Eigen::VectorXd weights_;
  std::vector<int> of_goal_;
  Frontier by_metric_, pushes_, regrasps_;
  std::vector<double> effort_;  // for each node, the number of extensions that its metric predicts to the goal
  int best_ = -1;
};

}  // namespace stiction::planning
