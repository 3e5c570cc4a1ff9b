// Contact Jacobians: row n is the gradient of phi, all rows are velocities of material points, batch equals single.
#include <gtest/gtest.h>

#include "contact/scenes.hpp"

namespace stiction::contact {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::EveryShapePair;
using test::Fixture;
using test::Random;
using test::Vector3d;

using RowMajor = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;

/// J_c over all coordinates.
MatrixXd full_jacobian(const Fixture& s, const Contact& c) {
  const std::vector<int>& support = s.model->supports()[s.model->pairs()[c.pair].support];
  RowMajor J(3, static_cast<Eigen::Index>(support.size()));
  calc_jacobian(*s.model, s.kinematics, c, J.data());
  MatrixXd full = MatrixXd::Zero(3, s.model->n_v());
  for (std::size_t k = 0; k < support.size(); ++k) full.col(support[k]) = J.col(static_cast<Eigen::Index>(k));
  return full;
}

/// Central differences of phi of one pair, and whether the normal turns too fast nearby for them to mean anything.
struct Slope {
  VectorXd gradient;
  double turn = 0;
};

Slope difference_phi(Fixture& s, int pair, double step) {
  const VectorXd q = s.q;
  Slope out{VectorXd::Zero(s.model->n_v()), 0};
  for (int i = 0; i < s.model->n_v(); ++i) {
    Distance d[2];
    for (int side = 0; side < 2; ++side) {
      s.move_to(q);
      s.move_by((side ? 1.0 : -1.0) * step * VectorXd::Unit(s.model->n_v(), i));
      d[side] = pair_distance(*s.model, s.kinematics, pair, s.work);
    }
    out.gradient[i] = (d[1].phi - d[0].phi) / (2 * step);
    out.turn = std::max({out.turn, (d[1].nhat_BA_W - d[0].nhat_BA_W).norm(), (d[1].p_WA - d[0].p_WA).norm() / 0.1});
  }
  s.move_to(q);
  return out;
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShapePair, ::testing::ValuesIn(test::shape_pairs()), test::case_name);

TEST_P(EveryShapePair, RowN_IsTheGradientOfPhi) {
  Fixture s(test::make_pair_scene(GetParam()));
  Random random(21);
  // Central differences: error h² |phi'''| / 6 + rounding 1e-16 / h, with curvatures up to 1 / distance.
  const double step = 1e-6;
  int compared = 0, apart = 0;
  for (int i = 0; i < 60; ++i) {
    s.move_to_random(random, i % 2 ? 0.05 : 0.15);
    const auto contacts = s.query_contacts();
    const auto nearest =
        std::min_element(contacts.begin(), contacts.end(), [](const Contact& c, const Contact& d) { return c.phi < d.phi; });
    ASSERT_NE(nearest, contacts.end());
    const Slope slope = difference_phi(s, 0, step);
    if (slope.turn > 1e-4) continue;  // a kink within a step
    const VectorXd J_n = full_jacobian(s, *nearest).row(0);
    EXPECT_LE((slope.gradient - J_n).norm(), 1e-7)
        << "#" << i << " phi " << nearest->phi << "\n  differences " << slope.gradient.transpose() << "\n  row n       " << J_n.transpose();
    EXPECT_GT(J_n.norm(), 0.9);
    ++compared;
    apart += nearest->phi > 0;
  }
  EXPECT_GT(compared, 45);
  EXPECT_GT(apart, 10);
  EXPECT_LT(apart, compared - 5);
}

/// Velocity of the material point of a geometry's body that is at p_W now, by central differences.
Vector3d material_velocity(Fixture& s, int geometry, const Vector3d& p_W, const VectorXd& delta) {
  const int body = s.model->geometries()[geometry].body;
  const VectorXd q = s.q;
  const Vector3d p_B = s.kinematics.X_WB[body].inverse() * p_W;
  const double step = 1e-6;
  s.move_by(step * delta);
  const Vector3d after = s.kinematics.X_WB[body] * p_B;
  s.move_to(q);
  s.move_by(-step * delta);
  const Vector3d before = s.kinematics.X_WB[body] * p_B;
  s.move_to(q);
  return (after - before) / (2 * step);
}

/// Robots whose joints move by themselves, and follow others.
class BusyScene : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Following, BusyScene, ::testing::Bool());

TEST_P(BusyScene, AllRows_AreRelativeVelocitiesOfMaterialPoints) {
  Fixture s(test::make_busy_scene(GetParam()));
  Random random(22);
  int shared = 0, compared = 0;
  for (int i = 0; i < 10; ++i) {
    s.move_to_random(random);
    for (Contact& c : s.query_contacts({.margin = 0.2})) {
      const world::Pair& pair = s.model->pairs()[c.pair];
      c.spin = random.uniform(-0.1, 0.1);
      const MatrixXd J = full_jacobian(s, c);
      for (int k = 0; k < s.model->n_v(); ++k) {
        const VectorXd delta = VectorXd::Unit(s.model->n_v(), k);
        const Vector3d v_a = material_velocity(s, pair.geometry_a, c.p_WA, delta),
                       v_b = material_velocity(s, pair.geometry_b, c.p_WB, delta);
        const Vector3d arm = c.spin * c.t1_W;
        const Vector3d at_arm =
            material_velocity(s, pair.geometry_a, c.p_WA + arm, delta) - material_velocity(s, pair.geometry_b, c.p_WB + arm, delta);
        const Vector3d want(c.nhat_BA_W.dot(v_a - v_b), c.t1_W.dot(v_a - v_b), c.t2_W.dot(at_arm));
        EXPECT_LE((J.col(k) - want).norm(), 1e-8) << "pair " << c.pair << " coordinate " << s.model->dofs()[k].name;
        shared += v_a.norm() > 1e-3 && v_b.norm() > 1e-3;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 1000);
  EXPECT_GT(shared, 10) << "no pair whose bodies move together";
}

TEST(Jacobian, SharedCoordinate_DoesNotChangePhi) {
  Fixture s(test::make_busy_scene());
  Random random(23);
  const int turn = s.model->n_vu() + s.model->joint_index("gripper/turn");
  int checked = 0;
  for (int i = 0; i < 20; ++i) {
    s.move_to_random(random);
    for (const Contact& c : s.query_contacts({.margin = 0.5})) {
      const world::Pair& pair = s.model->pairs()[c.pair];
      const auto on_robot = [&](int g) { return s.model->bodies()[s.model->geometries()[g].body].kind == world::BodyKind::Robot; };
      if (!on_robot(pair.geometry_a) || !on_robot(pair.geometry_b)) continue;
      EXPECT_NEAR(full_jacobian(s, c)(0, turn), 0.0, 1e-15);
      ++checked;
    }
  }
  EXPECT_GT(checked, 10);
}

TEST(Jacobian, BlockOnGround_HandNumbers) {
  world::Scene scene;
  scene.contact_distance = 1;
  scene.objects = {test::make_object("ball", world::Sphere{0.1})};
  scene.fixed = {{"ground", {}, {{"plane", world::HalfSpace{}, {}, 1.0}}}};
  Fixture s(scene);
  VectorXd q = s.q;
  q[2] = 0.25;
  s.move_to(q);
  const auto contacts = s.query_contacts();
  ASSERT_EQ(contacts.size(), 1u);
  // n = z, t1 = x, t2 = y; the lowest point is r below the centre, so turning about y by ω moves it by −ω r in x.
  MatrixXd want(3, 6);
  want << 0, 0, 1, 0, 0, 0,  //
      1, 0, 0, 0, -0.1, 0,   //
      0, 1, 0, 0.1, 0, 0;
  EXPECT_LE((full_jacobian(s, contacts[0]) - want).norm(), 1e-15);
  EXPECT_NEAR(contacts[0].phi, 0.15, 1e-15);
}

TEST_P(BusyScene, BatchOfJacobians_EqualsOneByOne) {
  Fixture s(test::make_busy_scene(GetParam()));
  Random random(24);
  Jacobians batch;
  std::vector<double> J(3 * static_cast<std::size_t>(s.model->n_v()));
  for (int i = 0; i < 50; ++i) {
    s.move_to_random(random);
    auto contacts = s.query_contacts({.margin = 0.1});
    for (Contact& c : contacts) c.spin = random.uniform(-0.1, 0.1);
    calc_jacobians(*s.model, s.kinematics, contacts, s.work, batch);
    ASSERT_EQ(batch.begin.size(), contacts.size() + 1);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      const int n = batch.begin[c + 1] - batch.begin[c];
      ASSERT_EQ(n, 3 * static_cast<int>(s.model->supports()[s.model->pairs()[contacts[c].pair].support].size()));
      calc_jacobian(*s.model, s.kinematics, contacts[c], J.data());
      for (int k = 0; k < n; ++k) EXPECT_NEAR(batch.values[batch.begin[c] + k], J[k], 1e-14);
    }
  }
}

}  // namespace
}  // namespace stiction::contact
