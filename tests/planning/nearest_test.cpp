#include "stiction/planning/nearest.hpp"

#include <Eigen/Cholesky>

#include "planning/systems.hpp"

namespace stiction::planning::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Points along walks through the space, as a tree grows, with metrics that are long in few directions and forget the others.
struct Points {
  explicit Points(const std::string& task, int walks) : model(load_model(task)), space(*model), nearest(space), random(8, 0) {
    const int n_v = model->n_vu();
    for (int w = 0; w < walks; ++w) {
      VectorXd q = model->neutral();
      for (int k = 0; k < 40; ++k) {
        q = moved(q, 0.1);
        MatrixXd B = MatrixXd::NullaryExpr(n_v, n_v, [&] { return random.normal(); });
        for (int j = 0; j < n_v; ++j) B.col(j) *= std::pow(0.6, j);
        MatrixXd S = B * B.transpose();
        S.diagonal().array() += 1e-6;
        MatrixXd L_inv = MatrixXd::Identity(n_v, n_v);
        S.llt().matrixL().solveInPlace(L_inv);
        nearest.add(q.head(model->n_qu()), S, L_inv);
      }
    }
  }
  VectorXd moved(const VectorXd& q, double spread) {
    VectorXd delta = VectorXd::Zero(model->n_v()), out(model->n_q());
    for (int i = 0; i < model->n_vu(); ++i) delta[i] = spread * random.normal();
    world::retract(*model, q, delta, out);
    return out;
  }
  int scan(const VectorXd& q) const {
    int best = -1;
    for (int i = 0; i < nearest.size(); ++i) {
      if (!nearest.removed(i) && (best < 0 || nearest.distance(i, q.data()) < nearest.distance(best, q.data()))) best = i;
    }
    return best;
  }
  std::shared_ptr<const world::Model> model;
  world::ObjectSpace space;
  NearestPoints nearest;
  core::Random random;
};

class EverySpace : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Tasks, EverySpace, testing::Values("planar_pushing", "planar_hand", "allegro_ball"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(EverySpace, Nearest_IsThatOfTheScan) {
  Points p(GetParam(), 20);
  for (int k = 0; k < 100; ++k) {
    const VectorXd q = p.moved(p.model->neutral(), 0.7);
    ASSERT_EQ(p.nearest.nearest(q.data()), p.scan(q));
  }
}

TEST_P(EverySpace, RemovedPoints_AreNeverFoundAndTheNextOneIs) {
  Points p(GetParam(), 5);
  const VectorXd q = p.moved(p.model->neutral(), 0.7);
  for (int left = p.nearest.size(); left > 0; --left) {
    const int i = p.nearest.nearest(q.data());
    ASSERT_EQ(i, p.scan(q));
    p.nearest.remove(i);
  }
  EXPECT_EQ(p.nearest.nearest(q.data()), -1);
  EXPECT_EQ(Points(GetParam(), 0).nearest.nearest(q.data()), -1) << "no points at all";
}

TEST(NearestPoints, EqualPoints_TheFirstWins) {
  Points p("planar_pushing", 0);
  const MatrixXd one = MatrixXd::Identity(3, 3);
  for (int i = 0; i < 300; ++i) p.nearest.add(Eigen::Vector3d(0.1, 0.2, 0.3), one, one);
  const Eigen::Vector3d q(1, 1, 1);
  for (const int first : {0, 1, 2}) {
    EXPECT_EQ(p.nearest.nearest(q.data()), first);
    p.nearest.remove(first);
  }
}

/// The least form over all places of the other coordinates: that of the error that the metric itself expects of them, S_rv S_vv⁻¹ e_v.
TEST(NearestPoints, DistanceOfSomeCoordinates_IsTheLeastOverTheOthers) {
  Points p("planar_hand", 1);
  const std::vector<int> v = {0, 2};
  for (int k = 0; k < 50; ++k) {
    VectorXd e(3);
    const VectorXd c = p.model->neutral().head(3), q = p.moved(p.model->neutral(), 0.2).head(3);
    p.space.error(c.data(), q.data(), e.data());
    MatrixXd B = MatrixXd::NullaryExpr(3, 3, [&] { return p.random.normal(); });
    const MatrixXd S = B * B.transpose() + 0.1 * MatrixXd::Identity(3, 3);
    MatrixXd L_inv = MatrixXd::Identity(3, 3);
    S.llt().matrixL().solveInPlace(L_inv);
    NearestPoints one(p.space);
    one.add(c, S, L_inv);
    const Eigen::Matrix2d S_vv = S({0, 2}, {0, 2});
    const Eigen::Vector2d e_v(e[0], e[2]);
    VectorXd least = q;
    least[1] = c[1] + (S(1, {0, 2}) * S_vv.inverse() * e_v).value();
    const double d = one.distance(0, q.data(), v);
    EXPECT_NEAR(d, one.distance(0, least.data()), 1e-9 * (1 + d));
    for (const double step : {-0.01, 0.01}) {
      VectorXd aside = least;
      aside[1] += step;
      EXPECT_GT(one.distance(0, aside.data()), d);
    }
  }
}

}  // namespace
}  // namespace stiction::planning::test
