#include "stiction/planning/tree.hpp"

#include <Eigen/LU>
#include <algorithm>

#include "planning/systems.hpp"

namespace stiction::planning::test {
namespace {

struct RandomTree {
  explicit RandomTree(const std::string& task)
      : model(load_model(task)), space(*model), tree(space, Eigen::VectorXd::Ones(space.n_v())), random(6, 0) {
    goal = model->neutral().head(model->n_qu());
    for (int i = 0; i < 200; ++i) {
      Node node;
      node.parent = i == 0 ? -1 : random.index(i);
      Eigen::VectorXd delta = Eigen::VectorXd::NullaryExpr(model->n_v(), [&] { return random.normal(); });
      node.q.resize(model->n_q());
      world::retract(*model, model->neutral(), delta, node.q);
      const Eigen::MatrixXd B = Eigen::MatrixXd::NullaryExpr(model->n_v(), model->n_a(), [&] { return random.normal(); });
      node.local.set(node.q, B, model->n_qu(), Eigen::VectorXd::Constant(model->n_vu(), 1e-4));
      node.goal_distance = i == 0 ? 10 : 0.9 * tree[node.parent].goal_distance;  // every edge brought the object nearer
      tree.add(node, goal);
    }
  }
  /// (3.5) from its definition, with the rotation from the model's own log map.
  double distance(int i, const Eigen::VectorXd& q_u) {
    Eigen::VectorXd from = model->neutral(), to = model->neutral(), e(model->n_v());
    from.head(model->n_qu()) = tree[i].local.c_u;
    to.head(model->n_qu()) = q_u;
    world::local(*model, from, to, e);
    if (model->n_vu() == 3) e[2] = std::remainder(e[2], 2 * std::numbers::pi);
    const Eigen::MatrixXd S =
        tree[i].local.B_u * tree[i].local.B_u.transpose() + 1e-4 * Eigen::MatrixXd::Identity(model->n_vu(), model->n_vu());
    const Eigen::VectorXd e_u = e.head(model->n_vu());
    return e_u.dot(S.inverse() * e_u);
  }
  std::shared_ptr<const world::Model> model;
  world::ObjectSpace space;
  Tree tree;
  core::Random random;
  Eigen::VectorXd goal;
};

TEST(Tree, Nearest_IsTheBruteForceMinimum) {
  for (const char* task : {"planar_pushing", "allegro_ball"}) {
    RandomTree t(task);
    for (int query = 0; query < 50; ++query) {
      Eigen::VectorXd q(t.model->n_q());
      world::retract(*t.model, t.model->neutral(), Eigen::VectorXd::NullaryExpr(t.model->n_v(), [&] { return t.random.normal(); }), q);
      const Eigen::VectorXd q_u = q.head(t.model->n_qu());
      int best = 0;
      for (int i = 1; i < t.tree.size(); ++i) {
        if (t.distance(i, q_u) < t.distance(best, q_u)) best = i;
      }
      EXPECT_NEAR(t.distance(t.tree.nearest(q_u), q_u), t.distance(best, q_u), 1e-5 * t.distance(best, q_u));
    }
  }
}

TEST(Tree, NearestPlace_IsWhereObjectsAreNearest) {
  RandomTree t("planar_pushing");
  for (int query = 0; query < 50; ++query) {
    const Eigen::VectorXd q_u = Eigen::VectorXd::NullaryExpr(t.model->n_qu(), [&] { return t.random.normal(); });
    const auto distance = [&](int i) {
      Eigen::VectorXd e(t.model->n_vu());
      t.space.error(t.tree[i].q.data(), q_u.data(), e.data());
      return e.norm();
    };
    const int nearest = t.tree.nearest_place(q_u);
    for (int i = 0; i < t.tree.size(); ++i) EXPECT_LE(distance(nearest), distance(i)) << i;
  }
}

TEST(Tree, NodesForAChangeOfContacts_AreThoseNearTheGoalMoreOften) {  // in which order: tests/planning/frontier_test.cpp
  RandomTree t("planar_pushing");
  int nearest = 0;
  for (int i = 1; i < t.tree.size(); ++i) {
    if (t.tree[i].goal_distance < t.tree[nearest].goal_distance) nearest = i;
  }
  std::vector<int> taken(200, 0);
  for (int k = 0; k < 2000; ++k) ++taken[static_cast<std::size_t>(t.tree.take_by_place(true))];
  EXPECT_GT(taken[static_cast<std::size_t>(nearest)], 2 * taken[0]) << "0 is the farthest";
  EXPECT_GT(taken[0], 0) << "nodes that are visited often come later, and all get their turn";
}

TEST(Tree, ReplayedNode_ComesBackAsFarAsItIsByThat) {
  RandomTree t("planar_pushing");
  const int nearest = t.tree.take_by_place(true);
  EdgeReplay replay;
  replay.q_fine = t.tree[nearest].q;
  t.tree.set_replay(nearest, replay, 20, 1000);
  EXPECT_FALSE(t.tree[nearest].replay.empty());
  EXPECT_EQ(t.tree[nearest].goal_ratio, 20);
  EXPECT_EQ(t.tree[nearest].goal_distance, 1000);
  int again = 0;
  for (int k = 0; k < 400; ++k) again += t.tree.take_by_place(true) == nearest;
  EXPECT_LE(again, 1);  // it was in the queue as near as it had seemed
}

TEST(Tree, NodesToPushFrom_AreThoseWithTheLeastMetricMoreOften) {
  RandomTree t("planar_pushing");
  int nearest = 0, farthest = 0;
  for (int i = 1; i < t.tree.size(); ++i) {
    if (t.distance(i, t.goal) < t.distance(nearest, t.goal)) nearest = i;
    if (t.distance(i, t.goal) > t.distance(farthest, t.goal)) farthest = i;
  }
  EXPECT_EQ(t.tree.take_by_metric(), nearest);
  std::vector<int> taken(200, 0);
  for (int k = 0; k < 2000; ++k) ++taken[static_cast<std::size_t>(t.tree.take_by_metric())];
  EXPECT_GT(taken[static_cast<std::size_t>(nearest)], taken[static_cast<std::size_t>(farthest)]);
}

TEST(Tree, NodesToPushFromByPlace_AreThoseNearTheGoalWhateverTheirMetric) {
  RandomTree t("planar_pushing");
  int nearest = 0;
  for (int i = 1; i < t.tree.size(); ++i) {
    if (t.tree[i].goal_distance < t.tree[nearest].goal_distance) nearest = i;
  }
  EXPECT_EQ(t.tree.take_by_place(false), nearest);
}

TEST(Tree, Best_IsTheNearestThatIsNotPruned) {
  RandomTree t("planar_pushing");
  for (int i = 0; i < t.tree.size(); ++i) t.tree.set_replay(i, {.q_fine = t.tree[i].q, .disturbed = {}}, 1 + i, 1);
  EXPECT_EQ(t.tree.best(), 0);
  t.tree.prune(0);
  EXPECT_EQ(t.tree.best(), 1) << "a node that verification refused is not carried out";
  t.tree.set_replay(1, {.q_fine = t.tree[1].q, .disturbed = {}}, 1000, 1);
  EXPECT_EQ(t.tree.best(), 2);
  t.tree.prune(2);
  EXPECT_FALSE(t.tree.pruned(t.tree.best()));
}

TEST(Tree, BuriedNode_IsNeverFoundAgain) {
  RandomTree t("planar_pushing");
  const int first = t.tree.nearest(t.goal);
  t.tree.prune(first);
  EXPECT_NE(t.tree.nearest(t.goal), first);
  const int place = t.tree.nearest_place(t.goal);
  t.tree.prune(place);
  EXPECT_NE(t.tree.nearest_place(t.goal), place);
  for (int k = 0; k < 500; ++k) EXPECT_NE(t.tree.take_by_place(true), first);
  for (int k = 0; k < 500; ++k) EXPECT_NE(t.tree.take_by_place(false), first);
  for (int k = 0; k < 500; ++k) EXPECT_NE(t.tree.take_by_metric(), first);
}

TEST(Tree, ChangesOfContacts_DoNotFollowEachOther) {
  RandomTree t("planar_pushing");
  Node grasp = t.tree[0];
  grasp.parent = 0;
  grasp.edge = SegmentKind::Regrasp;
  grasp.goal_distance = 0;
  grasp.local.set(grasp.q, t.tree[0].local.B_u, t.model->n_qu(), Eigen::VectorXd::Constant(t.model->n_vu(), 1e-4));
  const int regrasp = t.tree.add(grasp, t.goal);
  EXPECT_NE(t.tree.take_by_place(true), regrasp) << "another grasp starts where this one did";
  EXPECT_NE(t.tree.nearest_place(grasp.q.head(t.model->n_qu())), regrasp);
  EXPECT_GE(t.tree.take_by_place(false), 0);
}

TEST(Tree, PathTo_GoesFromTheRootAlongParents) {
  RandomTree t("planar_pushing");
  const auto path = t.tree.path_to(199);
  EXPECT_EQ(path.front(), 0);
  EXPECT_EQ(path.back(), 199);
  for (std::size_t k = 1; k < path.size(); ++k) EXPECT_EQ(t.tree[path[k]].parent, path[k - 1]);
}

}  // namespace
}  // namespace stiction::planning::test
