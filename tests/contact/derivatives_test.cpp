// Derivatives of J_cᵀλ and φ e₁ + J_c δq by the configuration against central differences through retract, for every pair of shapes.
#include <gtest/gtest.h>

#include "contact/contact_derivatives.hpp"
#include "contact/features.hpp"
#include "contact/scenes.hpp"
#include "stiction/contact/derivatives.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::contact {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::calc_full;
using test::EveryShapePair;
using test::find_feature;
using test::Fixture;
using test::kTolerance;
using test::largest;
using test::Random;
using test::Values;
using test::Vector3d;

constexpr int kStates = 100;
constexpr double kReach = 1e-3;  // states count whose features stay the same this far in every coordinate [m, rad]

class Differences {
 public:
  Differences(Fixture& s, int pair, const Vector3d& lambda, const VectorXd& delta, double spin)
      : s_(s), pair_(pair), lambda_(lambda), delta_(delta), spin_(spin) {}

  std::optional<Contact> contact() {
    std::vector<Contact> out;
    query_pairs(*s_.model, s_.kinematics, std::array{pair_}, 10.0, s_.work, out);
    if (out.empty()) return std::nullopt;
    for (Contact& c : out) c.spin = spin_;
    return *std::min_element(out.begin(), out.end(), [](const Contact& c, const Contact& d) { return c.phi < d.phi; });
  }

  Values values() {
    const Contact c = contact().value();
    const world::Pair& pair = s_.model->pairs()[pair_];
    const std::vector<int>& support = s_.model->supports()[pair.support];
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, static_cast<Eigen::Index>(support.size()));
    calc_jacobian(*s_.model, s_.kinematics, c, J.data());
    Values out{VectorXd::Zero(s_.model->n_v()), Vector3d(c.phi, 0, 0)};
    for (std::size_t k = 0; k < support.size(); ++k) {
      const auto column = J.col(static_cast<Eigen::Index>(k));
      out.tau[support[k]] = column.dot(lambda_);
      out.w += column * delta_[support[k]];
    }
    const auto feature = [&](int g, const Vector3d& p, const Vector3d& m) {
      return find_feature(s_.model->geometries()[g].shape, s_.X_WG(g), p, m);
    };
    out.feature = 10000 * feature(pair.geometry_a, c.p_WA, -c.nhat_BA_W) + feature(pair.geometry_b, c.p_WB, c.nhat_BA_W);
    return out;
  }

  Values moved(int coordinate, double by) {
    const VectorXd q = s_.q;
    s_.move_by(by * VectorXd::Unit(s_.model->n_v(), coordinate));
    Values out = values();
    s_.move_to(q);
    return out;
  }

  /// Away from kinks: in every coordinate both witness points stay on their features, and nothing jumps, up to `reach`.
  bool smooth(double reach) {
    const Values here = values();
    for (int j = 0; j < s_.model->n_v(); ++j) {
      for (const double by : {-reach, reach}) {
        const Values there = moved(j, by);
        if (there.feature != here.feature || (there.tau - here.tau).norm() > 200 * reach * lambda_.norm()) return false;
      }
    }
    return true;
  }

  /// Central differences of second order.
  void calc(double step, MatrixXd& D_tau, MatrixXd& D_w) {
    const int n = s_.model->n_v();
    D_tau.resize(n, n);
    D_w.resize(3, n);
    for (int j = 0; j < n; ++j) {
      const Values below = moved(j, -step), above = moved(j, step);
      D_tau.col(j) = (above.tau - below.tau) / (2 * step);
      D_w.col(j) = (above.w - below.w) / (2 * step);
    }
  }

 private:
  Fixture& s_;
  int pair_;
  Vector3d lambda_;
  VectorXd delta_;
  double spin_;
};

struct Errors {
  double tau = 0, w = 0;  // of differences of fourth order, relative
  double order = 0;       // log2 of the error of second order at one step over that at half of it; 0 where rounding hides it
  double phi = 0;
  bool used = false;
};

/// Errors at the present configuration; not used where it is near a kink.
Errors compare(Fixture& s, int pair, Random& random) {
  const Vector3d lambda = random.in_cube(1.0);
  VectorXd delta(s.model->n_v());
  for (Eigen::Index i = 0; i < delta.size(); ++i) delta[i] = random.uniform(-0.1, 0.1);
  const double spin = lambda[0] > 0 ? 0.05 : 0.0;  // half of the contacts resist turning
  Differences differences(s, pair, lambda, delta, spin);
  const auto c = differences.contact();
  if (!c || std::abs(c->phi) < 2 * kReach || !differences.smooth(kReach)) return {};
  MatrixXd D_tau, D_w, tau_1, w_1, tau_2, w_2;
  calc_full(s, *c, lambda, delta, D_tau, D_w);
  differences.calc(1e-4, tau_1, w_1);
  differences.calc(5e-5, tau_2, w_2);
  Errors out{.phi = c->phi, .used = true};
  out.tau = largest(D_tau - (4 * tau_2 - tau_1) / 3) / largest(D_tau);
  out.w = largest(D_w - (4 * w_2 - w_1) / 3) / largest(D_w);
  differences.calc(4e-4, tau_1, w_1);
  differences.calc(2e-4, tau_2, w_2);
  const double error = largest(D_tau - tau_1);
  if (error > 1e-8 * largest(D_tau)) out.order = std::log2(error / largest(D_tau - tau_2));
  return out;
}

// jacobian_test.cpp has the instances of EveryShapePair.

TEST_P(EveryShapePair, Derivatives_MatchCentralDifferences) {
  const auto& [a, b] = GetParam();
  Fixture s(test::make_pair_scene(GetParam()));
  Random random(31);
  int states = 0, apart = 0, attempts = 0, ordered = 0;
  for (; attempts < 2 * kStates && states < kStates; ++attempts) {
    s.move_to_random(random, attempts % 2 ? 0.06 : 0.15);
    const Errors e = compare(s, 0, random);
    if (!e.used) continue;
    ++states;
    apart += e.phi > 0;
    EXPECT_LE(e.tau, kTolerance) << "#" << attempts << " phi " << e.phi;
    EXPECT_LE(e.w, kTolerance) << "#" << attempts << " phi " << e.phi;
    if (e.order == 0) continue;
    ++ordered;
    EXPECT_NEAR(e.order, 2, 0.1) << "#" << attempts << " phi " << e.phi;
  }
  EXPECT_EQ(states, kStates) << "of " << attempts;
  EXPECT_GT(apart, 30);
  EXPECT_LT(apart, 80);
  EXPECT_TRUE(ordered > kStates / 2 || test::is_half_space(b.shape)) << ordered;
}

/// Every pair of a scene at random configurations.
int compare_all(Fixture& s, Random& random, int rounds, double spread) {
  int states = 0;
  for (int round = 0; round < rounds; ++round) {
    s.move_to_random(random, spread);
    for (int pair = 0; pair < static_cast<int>(s.model->pairs().size()); ++pair) {
      const Errors e = compare(s, pair, random);
      if (!e.used) continue;
      ++states;
      EXPECT_LE(e.tau, kTolerance) << "#" << round << " pair " << pair << " phi " << e.phi;
      EXPECT_LE(e.w, kTolerance) << "#" << round << " pair " << pair << " phi " << e.phi;
    }
  }
  return states;
}

TEST(Derivatives, RobotChainsAndObjects_MatchCentralDifferences) {
  Fixture s(test::make_busy_scene());
  Random random(32);
  EXPECT_GT(compare_all(s, random, 6, 0.2), 150);
}

TEST(Derivatives, JointsThatFollowOthers_MatchCentralDifferences) {
  Fixture s(test::make_busy_scene(true));
  ASSERT_EQ(s.model->n_a(), 2);
  ASSERT_EQ(s.model->followers().size(), 3u);
  Random random(33);
  EXPECT_GT(compare_all(s, random, 6, 0.2), 150);
}

TEST(Derivatives, HingedAndSlidingObjects_MatchCentralDifferences) {
  world::Scene scene;
  scene.contact_distance = 10;
  scene.objects = {test::make_object("door", world::Box{{0.05, 0.03, 0.08}}, world::ObjectJoint::Hinge),
                   test::make_object("drawer", world::Capsule{0.03, 0.06}, world::ObjectJoint::Slider),
                   test::make_object("disc", world::Cylinder{0.04, 0.06}, world::ObjectJoint::PlanarXZ),
                   test::make_object("ball", world::Sphere{0.05})};
  scene.objects[0].axis = Vector3d(1, 2, 2) / 3;
  scene.objects[0].geometries[0].X_BG = {Eigen::AngleAxisd(0.3, Vector3d::UnitX()).toRotationMatrix(), {0.1, 0.02, 0}};
  scene.objects[1].axis = Vector3d(2, -1, 2) / 3;
  Fixture s(scene);
  Random random(33);
  EXPECT_GT(compare_all(s, random, 40, 0.2), 200);
}

TEST(Derivatives, PlanarModels_MatchCentralDifferences) {
  for (const auto joint : {world::ObjectJoint::PlanarXY, world::ObjectJoint::PlanarYZ, world::ObjectJoint::PlanarXZ}) {
    world::Scene scene;
    scene.contact_distance = 10;
    for (const test::Named& shape : test::all_shapes()) {
      if (!test::is_half_space(shape.shape) && shape.name != "mesh")
        scene.objects.push_back(test::make_object(shape.name, shape.shape, joint));
    }
    scene.objects.push_back(test::make_object("prism", test::make_box_mesh({0.04, 0.05, 0.03}), joint));
    Fixture s(scene);
    ASSERT_TRUE(s.model->planar_axis());
    Random random(34);
    EXPECT_GT(compare_all(s, random, 20, 0.15), 150) << "joint " << static_cast<int>(joint);
  }
}

world::Scene ground_scene(const world::Shape& shape) {
  world::Scene scene;
  scene.contact_distance = 10;
  scene.objects = {test::make_object("object", shape)};
  scene.fixed = {{"ground", {}, {{"plane", world::HalfSpace{}, {}, 1.0}}}};
  return scene;
}

TEST(Derivatives, BoxFlatOnGround_PointsStayOnTheBox) {
  Fixture s(ground_scene(world::Box{{0.05, 0.03, 0.08}}));
  VectorXd q = s.q, delta(6);
  q[2] = 0.079;
  delta << 0.01, -0.02, 0.03, 0.2, -0.1, 0.3;
  s.move_to(q);
  std::vector<Contact> contacts;
  query_pairs(*s.model, s.kinematics, std::array{0}, 1.0, s.work, contacts);
  ASSERT_FALSE(contacts.empty());
  for (const Contact& c : contacts) {
    const Vector3d lambda(1, 0.3, -0.2), p_B = s.kinematics.X_WB[s.model->objects()[0].body].inverse() * c.p_WA;
    MatrixXd D_tau, D_w, D_tau_fd(6, 6), D_w_fd(3, 6);
    calc_full(s, c, lambda, delta, D_tau, D_w);
    const double step = 1e-4;
    for (int j = 0; j < 6; ++j) {
      Values side[2];
      for (const int k : {0, 1}) {
        s.move_by((k ? step : -step) * VectorXd::Unit(6, j));
        Contact there = c;  // same frame: the plane's
        there.p_WA = s.kinematics.X_WB[s.model->objects()[0].body] * p_B;
        Eigen::Matrix<double, 3, 6, Eigen::RowMajor> J;
        calc_jacobian(*s.model, s.kinematics, there, J.data());
        side[k] = {J.transpose() * lambda, Vector3d(there.p_WA.z(), 0, 0) + J * delta};
        s.move_to(q);
      }
      D_tau_fd.col(j) = (side[1].tau - side[0].tau) / (2 * step);
      D_w_fd.col(j) = (side[1].w - side[0].w) / (2 * step);
    }
    EXPECT_LE(largest(D_tau - D_tau_fd), 1e-8);
    EXPECT_LE(largest(D_w - D_w_fd), 1e-8);
    EXPECT_GT(largest(D_tau), 0.01);
  }
}

TEST(Derivatives, FrameNearMinusZ_IsThatOfItsChart) {
  // A ball below the edge of a box: its normal turns from inside to outside of the second chart of (4).
  world::Scene scene;
  scene.contact_distance = 10;
  scene.objects = {test::make_object("ball", world::Sphere{0.05}), test::make_object("box", world::Box{{0.05, 0.03, 0.08}})};
  Fixture s(scene);
  Random random(35);
  for (const double x : {0.02, 0.03, 0.058, 0.065, 0.07}) {
    VectorXd q = s.q;
    q.head<3>() << -0.05 - x, 0.01, -0.08 - 0.15;
    s.move_to(q);
    const Errors e = compare(s, 0, random);
    EXPECT_TRUE(e.used);
    EXPECT_LE(std::max(e.tau, e.w), kTolerance);
  }
}

TEST(Derivatives, WrongSizes_Throw) {
  Fixture s(ground_scene(world::Sphere{0.05}));
  s.move_to(s.q);
  const auto contacts = s.query_contacts();
  Jacobians J;
  ContactDerivatives out;
  calc_jacobians(*s.model, s.kinematics, contacts, s.work, J);
  std::vector<Vector3d> lambda(contacts.size(), Vector3d::Zero());
  EXPECT_THROW(calc_derivatives(*s.model, s.kinematics, contacts, J, lambda, VectorXd::Zero(5), {}, s.work, out), core::InvalidInput);
  lambda.emplace_back(0, 0, 0);
  EXPECT_THROW(calc_derivatives(*s.model, s.kinematics, contacts, J, lambda, VectorXd::Zero(6), {}, s.work, out), core::InvalidInput);
}

}  // namespace
}  // namespace stiction::contact
