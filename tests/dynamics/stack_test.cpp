// Objects that rest on flat faces: stacks, single bodies on a plane, tipping over an edge, deep starts, continuity of the step.
#include <numeric>

#include "contact/shapes.hpp"
#include "dynamics/systems.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using world::Model;

world::ObjectSpec make_object(const std::string& name, const world::Shape& shape, double mass, const Vector3d& half) {
  world::ObjectSpec object;
  object.name = name;
  object.mass = mass;
  object.inertia = mass / 3 *
                   Vector3d(half.y() * half.y() + half.z() * half.z(), half.x() * half.x() + half.z() * half.z(),
                            half.x() * half.x() + half.y() * half.y())
                       .asDiagonal();
  object.geometries = {{"g", shape, {}, 0.5}};
  return object;
}

world::Scene table_scene(double friction = 0.5) {
  world::Scene scene;
  scene.name = "stack";
  scene.contact_distance = 0.02;
  scene.robots.push_back(pusher(friction));
  scene.fixed.push_back(half_space(Vector3d::UnitZ(), Vector3d::Zero(), friction));
  return scene;
}

/// Objects over a table, with the pusher out of the way: steps with a command that never changes.
struct Scene {
  explicit Scene(const world::Scene& scene) : model(Model::make(scene)), work(model) {
    q = model->neutral();
    q.tail(2) << 5, 5;
    u = q.tail(2);
    options.h = 0.05;
  }
  void place(int object, const Eigen::Matrix3d& R, const Vector3d& p) {
    const Eigen::Quaterniond quaternion(R);
    q.segment<7>(model->objects()[static_cast<std::size_t>(object)].q_begin) << p, quaternion.coeffs();
  }
  Status go() {
    const Status status = step(*model, {q, u}, options, work, result);
    q = result.q_next;
    return status;
  }
  Vector3d force_on(int object) const {
    Vector3d sum = Vector3d::Zero();
    for (const auto& c : result.contacts) {
      const auto& pair = model->pairs()[static_cast<std::size_t>(c.contact.pair)];
      const Vector3d f = (c.contact.nhat_BA_W * c.lambda[0] + c.contact.t1_W * c.lambda[1] + c.contact.t2_W * c.lambda[2]) / options.h;
      if (model->geometries()[static_cast<std::size_t>(pair.geometry_a)].body == object_body(object)) sum += f;
      if (model->geometries()[static_cast<std::size_t>(pair.geometry_b)].body == object_body(object)) sum -= f;
    }
    return sum;
  }
  Vector3d torque_on(int object) const {
    Vector3d sum = Vector3d::Zero();
    const Vector3d centre = q.segment<3>(model->objects()[static_cast<std::size_t>(object)].q_begin);
    for (const auto& c : result.contacts) {
      const auto& pair = model->pairs()[static_cast<std::size_t>(c.contact.pair)];
      const Vector3d f = (c.contact.nhat_BA_W * c.lambda[0] + c.contact.t1_W * c.lambda[1] + c.contact.t2_W * c.lambda[2]) / options.h;
      if (model->geometries()[static_cast<std::size_t>(pair.geometry_a)].body == object_body(object))
        sum += (c.contact.p_WA - centre).cross(f);
      if (model->geometries()[static_cast<std::size_t>(pair.geometry_b)].body == object_body(object))
        sum -= (c.contact.p_WB - centre).cross(f);
    }
    return sum;
  }
  int object_body(int object) const { return model->objects()[static_cast<std::size_t>(object)].body; }

  std::shared_ptr<const Model> model;
  StepWorkspace work;
  StepOptions options;
  StepResult result;
  VectorXd q, u;
};

/// Largest displacement of the objects in one step, angles at 0.1 m [m].
double motion(const Scene& s) {
  double most = 0;
  for (int i = 0; i < s.model->n_vu(); ++i) most = std::max(most, std::abs(s.result.delta[i]) * (i % 6 < 3 ? 1.0 : 0.1));
  return most;
}

TEST(Stack, TenBoxes_StandForAThousandSteps) {
  for (const double mass : {0.1, 1.0}) {
    world::Scene scene = table_scene();
    const Vector3d half(0.05, 0.04, 0.03);
    for (int i = 0; i < 10; ++i) scene.objects.push_back(make_object("box" + std::to_string(i), world::Box{half}, mass, half));
    Scene s(scene);
    for (int i = 0; i < 10; ++i) s.place(i, Eigen::Matrix3d::Identity(), {0, 0, half.z() * (2 * i + 1)});
    VectorXd q_rest;
    for (int i = 0; i < 1000; ++i) {
      ASSERT_EQ(s.go(), Status::Solved) << i;
      // The first two steps find the rest, as far as the complementarity of a step lets them; then nothing moves any more.
      EXPECT_LT(motion(s), i < 2 ? 1e-8 : 1e-13) << i;
      if (i == 1) q_rest = s.q;
    }
    VectorXd moved(s.model->n_v());
    world::local(*s.model, q_rest, s.q, moved);
    EXPECT_LT(moved.cwiseAbs().maxCoeff(), 1e-10) << "in all, not per step";
    // Each box carries those above it.
    for (int i = 0; i < 10; ++i) EXPECT_LE((s.force_on(i) - Vector3d(0, 0, mass * kGravity)).norm(), 1e-4 * mass * kGravity);
  }
}

const Vector3d kHalf(0.05, 0.04, 0.03);
const Vector3d kTable(0.2, 0.15, 0.05);

/// One object on the plane z = 0, or on the top of a fixed block there.
world::Scene one_object(const world::Shape& shape, bool on_block, double friction = 0.5) {
  world::Scene scene = table_scene(friction);
  scene.objects.push_back(make_object("object", shape, 1.0, kHalf));
  if (on_block) {
    scene.fixed = {{"block", {Eigen::Matrix3d::Identity(), {0, 0, -kTable.z()}}, {{"g", world::Box{kTable}, {}, friction}}}};
  }
  return scene;
}

TEST(Rest, LightBoxesBesideAHeavyBlock_OnlyContactsThatTouchAreActive) {
  constexpr double kGap = 0.001;
  world::Scene scene = table_scene();
  for (const char* name : {"left", "right"}) {
    scene.objects.push_back(make_object(name, world::Box{kHalf}, 1e-3, kHalf));
    scene.objects.back().geometries[0].friction = 0;
  }
  scene.objects.push_back(make_object("block", world::Box{kHalf}, 1e5, kHalf));
  Scene s(scene);
  s.options.friction_law = FrictionLaw::Coulomb;
  s.place(2, Eigen::Matrix3d::Identity(), {1, 0, kHalf.z()});
  ASSERT_LT(s.model->scales().contact_tolerance(0), kGap);
  core::Random random(3, 0);
  double most = 0;
  for (int i = 0; i < 200; ++i) {
    const auto tilted = [&] { return Eigen::AngleAxisd(random.uniform(-0.02, 0.02), Vector3d::UnitY()).toRotationMatrix(); };
    s.place(0, tilted(), {0, 0, kHalf.z() + 1e-3});
    s.place(1, tilted(), {2 * kHalf.x() + 2 * kGap, 0, kHalf.z() + 1e-3});
    s.place(2, tilted(), {1, 0, kHalf.z() + 1e-3});
    ASSERT_EQ(s.go(), Status::Solved);
    for (const auto& c : s.result.contacts) {
      const double share = c.lambda[0] / (s.options.h * s.model->scales().pair(c.contact.pair).force);
      const bool touches = c.gap < s.model->scales().contact_tolerance(c.contact.pair);
      if (!touches) most = std::max(most, share);
      EXPECT_TRUE(!c.active || touches) << "active across " << c.gap << " m";
    }
  }
  EXPECT_GT(most, world::share::kActive) << "what the solver leaves on a contact that keeps its distance";
}

TEST(Rest, AnyShapeFlatOnAPlane_StaysWithItsWeightBalanced) {
  const std::pair<world::Shape, double> shapes[] = {
      {world::Box{kHalf}, 0.03}, {world::Cylinder{0.04, 0.03}, 0.03}, {contact::test::make_box_mesh(kHalf), 0.03}};
  for (const auto& [shape, height] : shapes) {
    for (const bool on_block : {false, true}) {
      Scene s(one_object(shape, on_block));
      s.place(0, Eigen::AngleAxisd(0.4, Vector3d::UnitZ()).toRotationMatrix(), {0.01, 0.02, height});
      const VectorXd q0 = s.q;
      for (int i = 0; i < 100; ++i) ASSERT_EQ(s.go(), Status::Solved);
      VectorXd moved(s.model->n_v());
      world::local(*s.model, q0, s.q, moved);
      const std::string what = "shape " + std::to_string(shape.index()) + (on_block ? " on a block" : " on a plane");
      EXPECT_LT(moved.cwiseAbs().maxCoeff(), 1e-8) << what;
      EXPECT_LE((s.force_on(0) - Vector3d(0, 0, kGravity)).norm(), 1e-6 * kGravity) << what;
      EXPECT_LE(s.torque_on(0).norm(), 1e-6 * kGravity * 0.05) << what;
    }
  }
}

TEST(Rest, FiveMillimetresDeep_ComesStraightOut) {
  for (const bool on_block : {false, true}) {
    Scene s(one_object(world::Box{kHalf}, on_block));
    s.place(0, Eigen::Matrix3d::Identity(), {0.01, 0.02, kHalf.z() - 5e-3});
    ASSERT_EQ(s.go(), Status::Solved);
    EXPECT_LE((s.q.head<3>() - Vector3d(0.01, 0.02, kHalf.z())).norm(), 1e-6);
    EXPECT_LE(s.result.delta.segment<3>(3).norm(), 1e-6);
  }
}

TEST(Rest, CentreBeyondTheEdge_Tips) {
  for (const double beyond : {-5e-3, 5e-3}) {
    Scene s(one_object(world::Box{kHalf}, true));
    s.place(0, Eigen::Matrix3d::Identity(), {kTable.x() + beyond, 0, kHalf.z()});
    s.options.h = 0.01;
    for (int i = 0; i < 5; ++i) ASSERT_EQ(s.go(), Status::Solved);
    const Eigen::Quaterniond turned(s.q.segment<4>(3));
    const double angle = 2 * std::asin(turned.y());  // about +y the far side goes down
    if (beyond < 0) {
      EXPECT_NEAR(angle, 0, 1e-7);
    } else {
      EXPECT_GT(angle, 1e-3);
    }
  }
}

/// The box hangs over the edges of the block, its centre does not: there it would fall, and far.
/// A point that enters or leaves the patch, or changes its features, does not change the step.
TEST(Rest, TinyMotionOfABoxOnABlock_TinyChangeOfTheStep) {
  Scene s(one_object(world::Box{kHalf}, true));
  core::Random random(7, 0);
  const auto draw = [&](double half) { return half * (2 * random.uniform() - 1); };
  double worst = 0;
  for (int i = 0; i < 300; ++i) {
    const double tilt = std::pow(10.0, -9 + 7 * random.uniform());
    const Vector3d axis = Vector3d(draw(1), draw(1), 0).normalized();
    const Eigen::Matrix3d R = (Eigen::AngleAxisd(tilt, axis) * Eigen::AngleAxisd(draw(3), Vector3d::UnitZ())).toRotationMatrix();
    s.place(0, R, {draw(0.19), draw(0.14), kHalf.z() + 0.05 * tilt + 1e-4 * random.uniform()});
    const VectorXd q0 = s.q;
    s.work.forget();
    ASSERT_EQ(s.go(), Status::Solved) << i;
    const VectorXd before = s.result.delta;
    VectorXd small(s.model->n_v());
    for (Eigen::Index k = 0; k < small.size(); ++k) small[k] = draw(1e-9);
    world::retract(*s.model, q0, small, s.q);
    s.work.forget();
    ASSERT_EQ(s.go(), Status::Solved) << i;
    worst = std::max(worst, (s.result.delta - before).norm());
    EXPECT_LE((s.result.delta - before).norm(), 1e-6) << i << " tilt " << tilt << " at " << q0.head<3>().transpose();
  }
}

/// A box of 40 mm between a table and a ceiling, between which there is too little room, as a simulation with soft contacts leaves it.
/// @param overlap  of the box with each of them [m]
Scene between_two_plates(double overlap) {
  world::Scene scene = table_scene();
  world::FixedSpec ceiling;
  ceiling.name = "ceiling";
  ceiling.X_WB.p.z() = 0.04 - 2 * overlap + 0.01;
  ceiling.geometries = {{"plate", world::Box{{0.05, 0.05, 0.01}}, {}, 0.5}};
  scene.fixed.push_back(ceiling);
  scene.objects.push_back(make_object("box", world::Box{{0.02, 0.02, 0.02}}, 0.1, {0.02, 0.02, 0.02}));
  Scene out(scene);
  out.place(0, Eigen::Matrix3d::Identity(), {0, 0, 0.02 - overlap});
  return out;
}

TEST(Overlap, ThatNoMotionEnds_StaysAsDeepAsItIs) {
  Scene scene = between_two_plates(2e-5);
  const VectorXd q = scene.q;
  for (int k = 0; k < 20; ++k) ASSERT_EQ(scene.go(), Status::Solved);
  EXPECT_LT((scene.q - q).lpNorm<Eigen::Infinity>(), 1e-7) << "and does not grow";
  double deepest = 0;
  for (const auto& c : scene.result.contacts) deepest = std::min(deepest, c.contact.phi);
  EXPECT_NEAR(deepest, -2e-5, 1e-7) << "contacts say how deep it is";
  EXPECT_NEAR(scene.force_on(0).z(), 0.1 * kGravity, 1e-6);

  scene.options.smoothing = Analytic{.kappa = 1000};
  scene.options.with_A = scene.options.with_B = true;
  ASSERT_EQ(scene.go(), Status::Solved);
  EXPECT_TRUE(scene.result.A.allFinite() && scene.result.B.allFinite());
}

TEST(Overlap, BeyondTheToleranceOfContacts_Infeasible) {
  Scene scene = between_two_plates(2e-3);
  EXPECT_EQ(scene.go(), Status::Infeasible);
}

}  // namespace
}  // namespace stiction::dynamics::test
