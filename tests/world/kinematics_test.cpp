// Poses, axes, moves on the manifold, mass and gravity.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <limits>
#include <numbers>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/moving_links.hpp"
#include "stiction/world/object_derivatives.hpp"
#include "world/test_scenes.hpp"

namespace stiction::world {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::random_configuration;
using test::random_vector;

Kinematics kinematics_at(const Model& model, const VectorXd& q) {
  KinematicsWorkspace work(model);
  Kinematics kinematics;
  calc_kinematics(model, q, work, kinematics);
  return kinematics;
}

/// Velocity of a point per unit of coordinate i, from axes and origins.
Vector3d point_velocity(const Model& model, const Kinematics& k, const Body& body, int i, const Vector3d& p_W) {
  if (std::find(body.dofs.begin(), body.dofs.end(), i) == body.dofs.end()) return Vector3d::Zero();
  const Vector3d axis = k.axis_W.col(i);
  if (model.dofs()[static_cast<std::size_t>(i)].kind == DofKind::Prismatic) return axis;
  return axis.cross(p_W - k.origin_W.col(i));
}

/// make_linked with all frames away from the centres of mass, that of the free object too.
Scene make_with_own_frames() {
  Scene scene = test::make_linked();
  for (ObjectSpec& object : scene.objects) {
    if (object.joint == ObjectJoint::Free) object.p_BCom = {0.1, -0.3, 0.2};
  }
  return scene;
}

constexpr const char* kSceneNames[] = {"zoo", "linked", "own_frames"};

class AnyScene : public testing::TestWithParam<Scene (*)()> {};
INSTANTIATE_TEST_SUITE_P(Scenes, AnyScene,
                         testing::Values(
                             +[] { return test::make_zoo(); }, +[] { return test::make_linked(); }, &make_with_own_frames),
                         [](const auto& scene) { return std::string(kSceneNames[scene.index]); });

/// Bodies and axes on the way to the bodies asked for are those of calc_kinematics, to the bit, and nothing else has changed.
TEST_P(AnyScene, MovingLinks_AreTheKinematicsOfTheBodiesAskedFor) {
  const auto model = Model::make(GetParam()());
  core::Random random(4, 0);
  MovingLinks links;
  bool left_out = false;
  for (int sample = 0; sample < 50; ++sample) {
    const VectorXd before = random_configuration(*model, random);
    VectorXd q = before;
    std::vector<char> moving(static_cast<std::size_t>(model->n_a()));
    for (int j = 0; j < model->n_a(); ++j) {
      if (!random.chance(0.5)) continue;
      moving[static_cast<std::size_t>(j)] = 1;
      q[model->n_qu() + j] += random.normal();
    }
    const std::vector<int> bodies{random.index(static_cast<int>(model->bodies().size())),
                                  random.index(static_cast<int>(model->bodies().size()))};
    const Kinematics old = kinematics_at(*model, before), expected = kinematics_at(*model, q);
    Kinematics partial = old;
    links.select(*model, moving, bodies);
    links.update(*model, q, partial);
    for (std::size_t b = 0; b < model->bodies().size(); ++b) {
      const bool asked = std::find(bodies.begin(), bodies.end(), static_cast<int>(b)) != bodies.end();
      const Pose &X = partial.X_WB[b], &now = expected.X_WB[b], &then = old.X_WB[b];
      const bool is_now = X.R == now.R && X.p == now.p, is_then = X.R == then.R && X.p == then.p;
      EXPECT_TRUE(is_now || (!asked && is_then));
      left_out |= !is_now;
      if (!asked) continue;
      for (const int dof : model->bodies()[b].dofs) {
        EXPECT_EQ(partial.axis_W.col(dof), expected.axis_W.col(dof));
        EXPECT_EQ(partial.origin_W.col(dof), expected.origin_W.col(dof));
      }
    }
  }
  EXPECT_TRUE(left_out) << "every link was moved for any two bodies";
}

TEST_P(AnyScene, AxesAndOrigins_AreTheDerivativeOfEveryBodyThroughRetract) {
  const auto model = Model::make(GetParam()());
  core::Random random(1, 0);
  const double h = 6e-6;  // cbrt of the accuracy of a pose: truncation and rounding both near 4e-11
  for (int sample = 0; sample < 20; ++sample) {
    const VectorXd q = random_configuration(*model, random);
    const Kinematics k = kinematics_at(*model, q);
    for (int i = 0; i < model->n_v(); ++i) {
      EXPECT_NEAR(k.axis_W.col(i).norm(), 1, 1e-12);
      VectorXd delta = VectorXd::Zero(model->n_v()), q_plus = q, q_minus = q;
      delta[i] = h;
      retract(*model, q, delta, q_plus);
      retract(*model, q, -delta, q_minus);
      const Kinematics plus = kinematics_at(*model, q_plus), minus = kinematics_at(*model, q_minus);
      double moved = 0;
      for (std::size_t b = 0; b < model->bodies().size(); ++b) {
        for (int corner = 0; corner < 4; ++corner) {  // origin and three more points: the whole motion
          const Vector3d p_B = corner == 0 ? Vector3d::Zero() : Vector3d(Vector3d::Unit(corner - 1));
          const Vector3d expected = (plus.X_WB[b] * p_B - minus.X_WB[b] * p_B) / (2 * h);
          const Vector3d got = point_velocity(*model, k, model->bodies()[b], i, k.X_WB[b] * p_B);
          EXPECT_LT((got - expected).norm(), 2e-9) << model->bodies()[b].name << " by " << model->dofs()[static_cast<std::size_t>(i)].name;
          moved = std::max(moved, expected.norm());
        }
      }
      EXPECT_GT(moved, 0.1) << "nothing moves with " << model->dofs()[static_cast<std::size_t>(i)].name;
    }
  }
}

TEST(Kinematics, PlanarObjects_HaveTheStatedCoordinates) {
  const std::tuple<ObjectJoint, int, int, int> kinds[] = {
      {ObjectJoint::PlanarXY, 0, 1, 2}, {ObjectJoint::PlanarYZ, 1, 2, 0}, {ObjectJoint::PlanarXZ, 0, 2, 1}};
  for (const auto& [joint, first, second, normal] : kinds) {
    Scene scene;
    scene.objects.push_back(test::make_object("part", joint));
    const auto model = Model::make(scene);
    EXPECT_EQ(model->planar_axis(), normal);
    const VectorXd q = (VectorXd(3) << 0.3, -0.4, 0.5).finished();
    const Pose X = object_pose(*model, q, 0);
    EXPECT_LT((X.p - 0.3 * Vector3d::Unit(first) + 0.4 * Vector3d::Unit(second)).norm(), 1e-15);
    EXPECT_LT((X.R - Eigen::AngleAxisd(0.5, Vector3d::Unit(normal)).toRotationMatrix()).norm(), 1e-15);
  }
}

TEST(Kinematics, WrongLength_IsRefused) {
  const auto model = Model::make(test::make_zoo());
  KinematicsWorkspace work(*model);
  Kinematics k;
  EXPECT_THROW(calc_kinematics(*model, VectorXd::Zero(3), work, k), core::InvalidInput);
  VectorXd q = model->neutral(), delta = VectorXd::Zero(model->n_v());
  EXPECT_THROW(retract(*model, q, q, q), core::InvalidInput);
  EXPECT_THROW(local(*model, q, delta, delta), core::InvalidInput);
}

/// Increments of every size, the last of them a turn of almost π of the free object.
std::vector<VectorXd> sample_increments(const Model& model, core::Random& random, int at_rotation) {
  std::vector<VectorXd> out{VectorXd::Zero(model.n_v())};
  for (const double scale : {1e-12, 1e-9, 1e-5, 0.99e-4, 1.01e-4, 1e-2, 0.3}) out.push_back(random_vector(random, model.n_v(), scale));
  for (const double angle : {3.0, std::numbers::pi - 1e-3, std::numbers::pi - 1e-7}) {
    VectorXd delta = random_vector(random, model.n_v(), 1);
    delta.segment<3>(at_rotation) *= angle / delta.segment<3>(at_rotation).norm();
    out.push_back(delta);
  }
  return out;
}

TEST(Manifold, LocalUndoesRetract) {
  const auto model = Model::make(test::make_zoo());
  const int at_rotation = model->objects()[1].v_begin + 3;
  core::Random random(2, 0);
  for (int repeat = 0; repeat < 50; ++repeat) {
    const VectorXd q0 = random_configuration(*model, random);
    for (const VectorXd& delta : sample_increments(*model, random, at_rotation)) {
      VectorXd q1 = q0, back(model->n_v());
      retract(*model, q0, delta, q1);
      require_configuration(*model, "q1", q1);
      local(*model, q0, q1, back);
      EXPECT_LT((back - delta).norm(), 1e-14 * (1 + 4 * delta.norm())) << delta.transpose();
    }
  }
}

TEST(Manifold, RetractUndoesLocal_UpToTheSignOfTheQuaternion) {
  const auto model = Model::make(test::make_zoo());
  const ObjectInfo& object = model->objects()[1];
  core::Random random(3, 0);
  for (int repeat = 0; repeat < 200; ++repeat) {
    const VectorXd q0 = random_configuration(*model, random, 2), q1 = random_configuration(*model, random, 2);
    VectorXd delta(model->n_v()), out(model->n_q()), other(model->n_v());
    local(*model, q0, q1, delta);
    EXPECT_LE(delta.segment<3>(object.v_begin + 3).norm(), std::numbers::pi + 1e-12);
    retract(*model, q0, delta, out);
    if (out.segment<4>(object.q_begin + 3).dot(q1.segment<4>(object.q_begin + 3)) < 0) out.segment<4>(object.q_begin + 3) *= -1;
    EXPECT_LT((out - q1).norm(), 1e-13);

    VectorXd q1_negated = q1;  // the same rotation
    q1_negated.segment<4>(object.q_begin + 3) *= -1;
    local(*model, q0, q1_negated, other);
    EXPECT_LT((other - delta).norm(), 1e-13);
  }
}

TEST(Manifold, RotationVector_IsInBodyAxes) {
  const auto model = test::load_task("allegro_ball");
  core::Random random(4, 0);
  const VectorXd q = random_configuration(*model, random);
  VectorXd delta = VectorXd::Zero(model->n_v()), q_next = q;
  delta.segment<3>(3) = Vector3d(0.3, -0.5, 0.7);
  retract(*model, q, delta, q_next);
  const Eigen::AngleAxisd turn(delta.segment<3>(3).norm(), delta.segment<3>(3).normalized());
  EXPECT_LT((object_pose(*model, q_next, 0).R - object_pose(*model, q, 0).R * turn.toRotationMatrix()).norm(), 1e-14);
  EXPECT_EQ(q_next.head<3>(), q.head<3>());
}

TEST(Manifold, Retract_MayWriteOverItsInput) {
  const auto model = Model::make(test::make_zoo());
  core::Random random(5, 0);
  const VectorXd q = random_configuration(*model, random), delta = random_vector(random, model->n_v(), 1);
  VectorXd separate(model->n_q()), same = q;
  retract(*model, q, delta, separate);
  retract(*model, same, delta, same);
  EXPECT_EQ(separate, same);
}

TEST(Manifold, PlanarAngle_IsAPlainDifference) {
  const auto model = test::load_task("planar_hand");
  VectorXd q0 = model->neutral(), q1 = q0, delta(7);
  q0[2] = -3;
  q1[2] = 4;
  local(*model, q0, q1, delta);
  EXPECT_EQ(delta[2], 7);
}

/// A rigid body of particles: M_ij = Σ m v_i·v_j, with velocities by central differences of the poses.
void expect_mass_of_particles(const Scene& scene) {
  const auto model = Model::make(scene);
  core::Random random(6, 0);
  const VectorXd q = random_configuration(*model, random);
  const Kinematics k = kinematics_at(*model, q);
  for (int object = 0; object < static_cast<int>(model->objects().size()); ++object) {
    const ObjectInfo& info = model->objects()[static_cast<std::size_t>(object)];
    const ObjectSpec& spec = model->scene().objects[static_cast<std::size_t>(object)];
    // Six particles on the principal axes with the wanted second moments: Σ m p pᵀ = ½ tr(I) 1 − I.
    const Eigen::Matrix3d second = 0.5 * spec.inertia.trace() * Eigen::Matrix3d::Identity() - spec.inertia;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(second);
    ASSERT_GT(axes.eigenvalues().minCoeff(), 0);
    MatrixXd expected = MatrixXd::Zero(info.n_v, info.n_v), got(info.n_v, info.n_v);
    const double m = spec.mass / 6, h = 6e-6;
    for (int particle = 0; particle < 6; ++particle) {
      const int axis = particle / 2;
      const Vector3d p_B =
          spec.p_BCom + (particle % 2 ? 1 : -1) * std::sqrt(axes.eigenvalues()[axis] / (2 * m)) * axes.eigenvectors().col(axis);
      Eigen::Matrix3Xd velocity(3, info.n_v);
      for (int i = 0; i < info.n_v; ++i) {
        VectorXd delta = VectorXd::Zero(model->n_v()), q_plus = q, q_minus = q;
        delta[info.v_begin + i] = h;
        retract(*model, q, delta, q_plus);
        retract(*model, q, -delta, q_minus);
        velocity.col(i) = (object_pose(*model, q_plus, object) * p_B - object_pose(*model, q_minus, object) * p_B) / (2 * h);
      }
      expected += m * velocity.transpose() * velocity;
    }
    calc_object_mass(*model, k, object, got);
    EXPECT_LT((got - expected).norm(), 1e-8 * expected.norm()) << info.name;
    EXPECT_LT((got - got.transpose()).norm(), 1e-14);
    if (info.n_q == 7 && spec.p_BCom.isZero(0)) {  // translation and rotation do not mix
      EXPECT_LT((got.topLeftCorner(3, 3) - spec.mass * MatrixXd::Identity(3, 3)).norm(), 1e-14);
      EXPECT_LT(got.topRightCorner(3, 3).norm(), 1e-14);
      EXPECT_LT((got.bottomRightCorner(3, 3) - spec.inertia).norm(), 1e-14) << "body axes";
    }
  }
}

TEST(ObjectMass, IsThatOfTheKineticEnergyOfManyParticles) {
  Scene scene = test::make_zoo();
  expect_mass_of_particles(scene);
  scene.objects[1].p_BCom = {0.1, -0.3, 0.2};
  ASSERT_EQ(scene.objects[1].joint, ObjectJoint::Free);
  expect_mass_of_particles(scene);
}

TEST(ObjectMass, OfOneThatCarriesOthers_IsThatOfAllThatMove) {
  const auto model = Model::make(test::make_linked());
  core::Random random(9, 0);
  const int hinge = model->object_index("hinge");
  const auto& info = model->objects()[static_cast<std::size_t>(hinge)];
  double mass = 0;
  for (int sample = 0; sample < 5; ++sample) {
    const VectorXd q = random_configuration(*model, random);
    const Kinematics k = kinematics_at(*model, q);
    double energy2 = 0;  // m v² + ωᵀIω at unit speed
    mass = 0;
    for (const char* name : {"hinge", "drawer", "knob"}) {
      const int object = model->object_index(name);
      const auto& spec = model->scene().objects[static_cast<std::size_t>(object)];
      const Pose X_WB = object_pose(*model, q, object);
      const Vector3d axis = k.axis_W.col(info.v_begin);
      const Vector3d v = axis.cross(X_WB * spec.p_BCom - k.origin_W.col(info.v_begin));
      energy2 += spec.mass * v.squaredNorm() + axis.dot(X_WB.R * spec.inertia * X_WB.R.transpose() * axis);
      mass += spec.mass;
    }
    MatrixXd M_u(1, 1);
    calc_object_mass(*model, k, hinge, M_u);
    EXPECT_NEAR(M_u(0, 0), energy2, 1e-12 * energy2);
  }
  EXPECT_NEAR(info.carried_mass, mass, 1e-14);
  EXPECT_EQ(model->objects().back().parent, model->object_index("drawer"));
}

TEST_P(AnyScene, MassAndGravity_HaveTheDerivativesOfCentralDifferences) {
  const auto model = Model::make(GetParam()());
  core::Random random(11, 0);
  const double h = 1e-5;
  const int n = model->n_vu();
  for (int sample = 0; sample < 3; ++sample) {
    const VectorXd q = random_configuration(*model, random);
    for (int object = 0; object < static_cast<int>(model->objects().size()); ++object) {
      const ObjectInfo& info = model->objects()[static_cast<std::size_t>(object)];
      VectorXd v(info.n_v);
      for (double& x : v) x = random.normal();
      const auto at = [&](const VectorXd& where) {  // (M_u v, τᵘ)
        const Kinematics k = kinematics_at(*model, where);
        MatrixXd M_u(info.n_v, info.n_v);
        VectorXd tau(n);
        calc_object_mass(*model, k, object, M_u);
        calc_gravity(*model, k, tau);
        return std::pair<VectorXd, VectorXd>(M_u * v, tau.segment(info.v_begin, info.n_v));
      };
      MatrixXd momentum(info.n_v, n), gravity(info.n_v, n), want_momentum(info.n_v, n), want_gravity(info.n_v, n);
      calc_object_derivatives(*model, kinematics_at(*model, q), object, v, momentum, gravity);
      for (int j = 0; j < n; ++j) {
        VectorXd delta = VectorXd::Zero(model->n_v()), q_plus = q, q_minus = q;
        delta[j] = h;
        retract(*model, q, delta, q_plus);
        retract(*model, q, -delta, q_minus);
        const auto plus = at(q_plus), minus = at(q_minus);
        want_momentum.col(j) = (plus.first - minus.first) / (2 * h);
        want_gravity.col(j) = (plus.second - minus.second) / (2 * h);
      }
      const double scale = 1 + at(q).first.norm() + at(q).second.norm();
      EXPECT_LT((momentum - want_momentum).cwiseAbs().maxCoeff(), 1e-8 * scale) << info.name;
      EXPECT_LT((gravity - want_gravity).cwiseAbs().maxCoeff(), 1e-8 * scale) << info.name;
    }
  }
}

TEST(Objects, ThatHangOnOthers_AreNotPairedWithThem) {
  const auto model = Model::make(test::make_linked());
  const auto name_of = [&](int geometry) {
    return model->bodies()[static_cast<std::size_t>(model->geometries()[static_cast<std::size_t>(geometry)].body)].name;
  };
  bool hinge_knob = false;
  for (const Pair& pair : model->pairs()) {
    const std::pair<std::string, std::string> names{name_of(pair.geometry_a), name_of(pair.geometry_b)};
    EXPECT_NE(names, std::pair(std::string("hinge"), std::string("drawer")));
    EXPECT_NE(names, std::pair(std::string("drawer"), std::string("knob")));
    hinge_knob |= names == std::pair(std::string("hinge"), std::string("knob"));
  }
  EXPECT_TRUE(hinge_knob) << "they are not linked";
}

TEST_P(AnyScene, Gravity_IsMinusTheDerivativeOfThePotential) {
  const auto model = Model::make(GetParam()());
  core::Random random(7, 0);
  const VectorXd q = random_configuration(*model, random);
  VectorXd tau(model->n_vu());
  calc_gravity(*model, kinematics_at(*model, q), tau);
  const auto potential = [&](const VectorXd& at) {
    double energy = 0;
    for (int i = 0; i < static_cast<int>(model->objects().size()); ++i) {
      const ObjectSpec& spec = model->scene().objects[static_cast<std::size_t>(i)];
      energy -= spec.mass * model->scene().gravity.dot(object_pose(*model, at, i) * spec.p_BCom);
    }
    return energy;
  };
  const double h = 6e-6;
  for (int i = 0; i < model->n_vu(); ++i) {
    VectorXd delta = VectorXd::Zero(model->n_v()), q_plus = q, q_minus = q;
    delta[i] = h;
    retract(*model, q, delta, q_plus);
    retract(*model, q, -delta, q_minus);
    EXPECT_NEAR(tau[i], -(potential(q_plus) - potential(q_minus)) / (2 * h), 1e-7) << i;  // potential ~ 1e2 J: rounding 2e-14/1e-5
  }
  EXPECT_GT(tau.norm(), 10);
}

TEST(RequireConfiguration, NamesWhatIsWrong) {
  const auto model = test::load_task("allegro_ball");
  const auto message = [&](const VectorXd& q) {
    try {
      require_configuration(*model, "start.q", q);
    } catch (const core::InvalidInput& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  VectorXd q = model->neutral();
  EXPECT_EQ(message(q), "");
  EXPECT_EQ(message(VectorXd::Zero(4)), "start.q: got 4 numbers, expected 23");
  q[8] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message(q), "start.q[8]: got nan, expected a finite number");
  q = model->neutral();
  q[6] = 1.001;
  EXPECT_EQ(message(q), "start.q[3..6]: got a quaternion of length 1.001, expected length 1");
}

}  // namespace
}  // namespace stiction::world
