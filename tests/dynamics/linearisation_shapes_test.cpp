// A = D_qnext_q, B and the derivatives of the impulses against central differences: every pair of shapes, and flat faces on each other.
#include <Eigen/Geometry>

#include "dynamics/linearisation.hpp"
#include "dynamics/wrist.hpp"

namespace stiction::dynamics::test {
namespace {

using contact::test::Named;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

struct ShapePair {
  Named a, b;
};
void PrintTo(const ShapePair& p, std::ostream* os) { *os << p.a.name << "_" << p.b.name; }

std::vector<ShapePair> shape_pairs() {
  std::vector<ShapePair> out;
  for (const auto& a : contact::test::all_shapes()) {
    for (const auto& b : contact::test::all_shapes()) {
      if (!contact::test::is_half_space(a.shape)) out.push_back({a, b});
    }
  }
  return out;
}

/// Object a and hand b; or a hand with a ball, object a and the ground b.
std::shared_ptr<const Model> pair_model(const ShapePair& pair) {
  world::Scene scene = empty_scene();
  scene.contact_distance = 0.05;
  scene.objects = {free_object(pair.a.shape)};
  const bool ground = contact::test::is_half_space(pair.b.shape);
  scene.robots = {wrist("hand_" + pair.a.name + "_" + pair.b.name, ground ? world::Shape(world::Sphere{0.03}) : pair.b.shape)};
  scene.robots[0].friction = 0.6;
  if (ground) {
    scene.fixed = {half_space({0, 0, 1}, {0, 0, 0}, 0.6)};
    scene.filters = {{"ground", scene.robots[0].name, std::nullopt}};
  }
  return Model::make(scene);
}

/// From the neutral state by delta, then onto gaps of 2 … 3 mm, open or penetrating: the radius at which vertices and edges turn around each other.
void place(const Model& model, const VectorXd& delta, core::Random& random, VectorXd& q, VectorXd& u) {
  world::retract(model, model.neutral(), delta, q = model.neutral());
  const double sign = random.uniform(0, 1) < 0.3 ? -1 : 1;
  const double wanted[2] = {sign * random.uniform(2e-3, 3e-3), sign * random.uniform(2e-3, 3e-3)};
  world::KinematicsWorkspace kinematics_work(model);
  world::Kinematics kinematics;
  contact::Workspace contact_work(model);
  // Moves A along n̂ onto the wanted gap: first the object against the ground, then the hand against the object.
  for (int k = static_cast<int>(model.pairs().size()) - 1; k >= 0; --k) {
    for (int round = 0; round < 20; ++round) {
      world::calc_kinematics(model, q, kinematics_work, kinematics);
      const contact::Distance d = contact::pair_distance(model, kinematics, k, contact_work);
      const double by = (round < 19 ? 0.9 : 1.0) * (d.phi - wanted[k]);
      const Eigen::Index at = k == 0 ? model.n_qu() : 0;
      q.segment<3>(at) += (k == 0 ? 1.0 : -1.0) * by * d.nhat_BA_W;
    }
  }
  u = q.tail(model.n_a());
  for (Eigen::Index j = 0; j < 3; ++j) u[j] += 0.02 * random.normal();
  for (Eigen::Index j = 3; j < 6; ++j) u[j] += 0.05 * random.normal();
}

void sample_pair(const Model& model, core::Random& random, VectorXd& q, VectorXd& u) {
  VectorXd delta(model.n_v());
  for (Eigen::Index i = 0; i < delta.size(); ++i) {
    delta[i] = model.dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute ? random.uniform(-1.3, 1.3) : 0.0;
  }
  Vector3d towards(random.normal(), random.normal(), random.normal());
  if (model.pairs().size() > 1) towards.z() = std::abs(towards.z());
  delta.segment<3>(6) = 0.5 * towards.normalized();
  place(model, delta, random, q, u);
}

class EveryShapePair : public testing::TestWithParam<ShapePair> {
 protected:
  void run(const StepOptions& options) {
    System s(pair_model(GetParam()), options);
    const bool exact = std::holds_alternative<Exact>(options.smoothing);
    core::Random random(41, 0);
    VectorXd q, u;
    int states = 0, touching = 0, untouched = 0, attempts = 0, ordered = 0;
    double sum_of_orders = 0;
    for (; attempts < 30 * kStates && states < kStates; ++attempts) {
      sample_pair(*s.model, random, q, u);
      const Outcome here = s.outcome(q, u);
      if (!here.solved || (exact && !here.clear)) continue;
      double force = 0;
      for (const auto& c : s.result.contacts) force = std::max(force, c.lambda[0] / options.h);
      if ((force < 0.3 && untouched >= kStates / 4) || !s.smooth(q, u)) continue;
      const auto e = compare(s, q, u, kStep);
      if (!e) continue;
      ++states;
      touching += force > 0.3, untouched += force <= 0.3;
      expect_small(*e, attempts);
      if (exact) continue;
      VectorXd direction(s.model->n_v());
      for (double& d : direction) d = random.normal();
      const double order = calc_order(s, q, u, direction.normalized());
      if (order == 0) continue;
      ++ordered;
      sum_of_orders += order;
      EXPECT_NEAR(order, 2, 0.5) << "#" << attempts;  // around sharp features the next order shows
    }
    EXPECT_EQ(states, kStates) << "of " << attempts;
    EXPECT_GT(touching, 3 * kStates / 4 - 1);
    if (exact) return;
    EXPECT_GT(ordered, kStates / 5);
    EXPECT_NEAR(sum_of_orders / ordered, 2, 0.05);
  }
};

TEST_P(EveryShapePair, Smoothed_MatchesCentralDifferences) {
  run({.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

TEST_P(EveryShapePair, Exact_MatchesCentralDifferences) {
  run({.regularisation = FixedEpsilon{50}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShapePair, testing::ValuesIn(shape_pairs()),
                         [](const auto& test) { return test.param.a.name + "_" + test.param.b.name; });

/// Object `above` lies almost flat on b: on the hand that carries it, or on the ground with the hand's ball beside it.
struct Patched {
  ShapePair pair;
  bool lying;  // the object's z axis is level
};
void PrintTo(const Patched& p, std::ostream* os) { PrintTo(p.pair, os); }

std::vector<Patched> patched() {
  const Named box{"box", world::Box{{0.05, 0.03, 0.08}}}, mesh{"mesh", contact::test::make_box_mesh({0.05, 0.03, 0.08})};
  const Named capsule{"capsule", world::Capsule{0.02, 0.05}}, rod{"rod", world::Cylinder{0.02, 0.07}},
      can{"can", world::Cylinder{0.05, 0.04}};
  const Named plate{"plate", world::Box{{0.04, 0.06, 0.02}}}, slab{"slab", contact::test::make_box_mesh({0.04, 0.06, 0.02})};
  const Named ground{"half_space", world::HalfSpace{}};
  return {{{box, plate}, false}, {{mesh, plate}, false}, {{mesh, slab}, false},   {{capsule, plate}, true},  {{rod, plate}, true},
          {{can, plate}, false}, {{box, ground}, false}, {{mesh, ground}, false}, {{capsule, ground}, true}, {{can, ground}, false}};
}

class EveryPatch : public testing::TestWithParam<Patched> {
 protected:
  /// Tilted beyond 1e-3 rad: the slack of the side planes, which is there below that, counts as constant (docs/theory/contact.md §9).
  void sample(const Model& model, core::Random& random, VectorXd& q, VectorXd& u) const {
    const bool ground = model.pairs().size() > 1;
    const Eigen::AngleAxisd rest(GetParam().lying ? M_PI / 2 : 0, Vector3d::UnitX());
    Eigen::AngleAxisd turn;
    do {
      const Vector3d tilt(random.uniform(0.01, 0.1), random.uniform(0.01, 0.1), random.uniform(-1.5, 1.5));
      turn = rest * Eigen::AngleAxisd(tilt.norm(), tilt.normalized());
    } while (GetParam().lying && std::abs(turn.toRotationMatrix()(2, 2)) < 2e-3);
    VectorXd delta = VectorXd::Zero(model.n_v());
    delta.segment<3>(3) = turn.angle() * turn.axis();
    const double around = random.uniform(-M_PI, M_PI);
    delta.segment<3>(6) << random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03), -0.5;
    if (ground) delta.segment<3>(6) << 0.4 * std::cos(around), 0.4 * std::sin(around), 0.1;
    place(model, delta, random, q, u);
  }

  void run(const StepOptions& options) {
    System s(pair_model(GetParam().pair), options);
    core::Random random(44, 0);
    VectorXd q, u;
    int states = 0, attempts = 0, several = 0;
    for (; attempts < 100 * kStates && states < kStates; ++attempts) {
      sample(*s.model, random, q, u);
      const Outcome here = s.outcome(q, u);
      if (!here.solved || (s.exact() && !here.clear) || here.rows.size() < 2 || !s.smooth(q, u)) continue;
      const auto e = compare(s, q, u, kStep);
      if (!e) continue;
      ++states;
      int pressing = 0;
      for (const auto& c : s.result.contacts) pressing += c.lambda[0] > 0.1 * options.h;
      several += pressing > 1;
      expect_small(*e, attempts);
    }
    EXPECT_EQ(states, kStates) << "of " << attempts;
    EXPECT_GT(several, kStates / 25) << "states in which more than one point pressed";
  }
};

TEST_P(EveryPatch, Smoothed_MatchesCentralDifferences) {
  run({.smoothing = Analytic{}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

TEST_P(EveryPatch, Exact_MatchesCentralDifferences) {
  run({.regularisation = FixedEpsilon{50}, .with_B = true, .with_A = true, .with_force_derivatives = true});
}

INSTANTIATE_TEST_SUITE_P(Patches, EveryPatch, testing::ValuesIn(patched()),
                         [](const auto& test) { return test.param.pair.a.name + "_" + test.param.pair.b.name; });

}  // namespace
}  // namespace stiction::dynamics::test
