// Queries: broad phase against brute force, order, limits, frames, planar models, determinism, refusals.
#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "contact/scenes.hpp"
#include "stiction/core/invalid_input.hpp"
#include "support/message_of.hpp"

namespace stiction::contact {
namespace {

using stiction::test::message_of;
using test::Fixture;
using test::Random;
using test::Vector3d;

std::vector<Contact> brute_force(const Fixture& s, double margin, double cutoff) {
  std::vector<Contact> out;
  for (int i = 0; i < static_cast<int>(s.model->pairs().size()); ++i) {
    const Distance d = s.distance(i);
    if (!(d.phi < std::min(s.model->pairs()[i].max_distance + margin, cutoff))) continue;
    out.push_back({.pair = i,
                   .id = 0,
                   .phi = d.phi,
                   .p_WA = d.p_WA,
                   .p_WB = d.p_WB,
                   .nhat_BA_W = d.nhat_BA_W,
                   .t1_W = Vector3d::Zero(),
                   .t2_W = Vector3d::Zero(),
                   .friction = 0});
  }
  return out;
}

void expect_same(const std::vector<Contact>& got, const std::vector<Contact>& want, double tolerance) {
  ASSERT_EQ(got.size(), want.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i].pair, want[i].pair);
    EXPECT_NEAR(got[i].phi, want[i].phi, tolerance);
    EXPECT_LE((got[i].p_WA - want[i].p_WA).norm(), tolerance);
    EXPECT_LE((got[i].p_WB - want[i].p_WB).norm(), tolerance);
    EXPECT_LE((got[i].nhat_BA_W - want[i].nhat_BA_W).norm(), tolerance);
  }
}

/// The nearest point of each pair.
std::vector<Contact> nearest_of_pairs(const std::vector<Contact>& contacts) {
  std::vector<Contact> out;
  for (const Contact& c : contacts) {
    if (out.empty() || out.back().pair != c.pair) {
      out.push_back(c);
    } else if (c.phi < out.back().phi) {
      out.back() = c;
    }
  }
  return out;
}

void expect_identical(const std::vector<Contact>& a, const std::vector<Contact>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].pair, b[i].pair);
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].phi, b[i].phi);
    EXPECT_EQ(a[i].p_WA, b[i].p_WA);
    EXPECT_EQ(a[i].p_WB, b[i].p_WB);
    EXPECT_EQ(a[i].nhat_BA_W, b[i].nhat_BA_W);
    EXPECT_EQ(a[i].t1_W, b[i].t1_W);
  }
}

TEST(Query, RandomConfigurations_EqualBruteForce) {
  Fixture s(test::make_busy_scene());
  ASSERT_GT(s.model->pairs().size(), 40u);
  Random random(1);
  std::size_t found = 0;
  for (int i = 0; i < 400; ++i) {
    s.move_to_random(random);
    const double margin = i % 2 ? 0.03 : 0.0, cutoff = i % 3 ? 1e300 : 0.01;
    const auto contacts = s.query_contacts({.margin = margin, .cutoff = cutoff});
    // The composed pose of a geometry differs by rounding from the test's, and flat features amplify it.
    expect_same(nearest_of_pairs(contacts), brute_force(s, margin, cutoff), 1e-8);
    found += contacts.size();
  }
  EXPECT_GT(found, 2000u);
}

TEST(Query, Contacts_HaveStableIdsFrictionAndRightHandedFrames) {
  Fixture s(test::make_busy_scene());
  Random random(2);
  std::vector<char> met(s.model->pairs().size(), 0);
  for (int i = 0; i < 100; ++i) {
    s.move_to_random(random);
    const auto contacts = s.query_contacts();
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const Contact& c = contacts[k];
      EXPECT_EQ(c.id >> 8, static_cast<std::uint64_t>(c.pair));
      EXPECT_TRUE(k == 0 || contacts[k - 1].id < c.id);
      met[c.pair] = 1;
      EXPECT_EQ(c.friction, s.model->pairs()[c.pair].friction);
      Eigen::Matrix3d F;
      F << c.nhat_BA_W, c.t1_W, c.t2_W;
      EXPECT_LE((F.transpose() * F - Eigen::Matrix3d::Identity()).norm(), 1e-12);
      EXPECT_LE((c.nhat_BA_W.cross(c.t1_W) - c.t2_W).norm(), 1e-12);
      EXPECT_LE((c.p_WA - c.p_WB - c.phi * c.nhat_BA_W).norm(), 1e-14);
    }
  }
  EXPECT_GT(std::count(met.begin(), met.end(), 1), 40);
}

TEST(Query, TurningNormal_FrameIsContinuousOutsideTheCapAroundMinusZ) {
  world::Scene scene;
  scene.objects = {test::make_object("a", world::Sphere{0.1}), test::make_object("b", world::Sphere{0.1})};
  scene.contact_distance = 10;
  Fixture s(scene);
  Vector3d last_t1 = Vector3d::Zero(), last_n = Vector3d::Zero();
  bool first = true;
  const double step = 1e-3;
  for (double polar = 0; polar < std::acos(-0.989); polar += step) {  // a spiral from +z down to the cap
    Eigen::VectorXd q = s.model->neutral();
    q.head<3>() = Vector3d(std::sin(polar) * std::cos(3 * polar), std::sin(polar) * std::sin(3 * polar), std::cos(polar));
    s.move_to(q);
    const auto contacts = s.query_contacts();
    ASSERT_EQ(contacts.size(), 1u);
    if (!first) {
      EXPECT_LT((contacts[0].t1_W - last_t1).norm(), 20 * (contacts[0].nhat_BA_W - last_n).norm());
    }
    last_t1 = contacts[0].t1_W;
    last_n = contacts[0].nhat_BA_W;
    first = false;
  }
}

TEST(Query, MaxContacts_KeepsTheNearestInOrderOfPair) {
  world::Scene scene = test::make_busy_scene();
  Fixture all(scene);
  scene.max_contacts = 5;
  Fixture five(scene);
  Random random_a(3), random_b(3);
  int cut = 0;
  for (int i = 0; i < 100; ++i) {
    all.move_to_random(random_a);
    five.move_to_random(random_b);
    std::vector<Contact> want = all.query_contacts();
    const auto got = five.query_contacts();
    std::stable_sort(want.begin(), want.end(), [](const Contact& a, const Contact& b) { return a.phi < b.phi; });
    if (want.size() > 5) {
      want.resize(5);
      ++cut;
    }
    std::sort(want.begin(), want.end(), [](const Contact& a, const Contact& b) { return a.id < b.id; });
    expect_identical(got, want);
  }
  EXPECT_GT(cut, 50);
}

TEST(Query, MaxContactsWithTies_KeepsTheLowerPairs) {
  world::Scene scene;
  scene.contact_distance = 1;
  scene.max_contacts = 2;
  scene.objects = {test::make_object("ball", world::Sphere{0.1})};
  world::FixedSpec posts{.name = "posts", .X_WB = {}, .geometries = {}};
  for (int i = 0; i < 4; ++i) {
    posts.geometries.push_back({"p" + std::to_string(i),
                                world::Sphere{0.1},
                                {Eigen::Matrix3d::Identity(), Vector3d(i % 2 ? 0.5 : 0, i % 2 ? 0 : 0.5, 0) * (i < 2 ? 1 : -1)},
                                1.0});
  }
  scene.fixed = {posts};
  Fixture s(scene);
  s.move_to(s.q);
  const auto contacts = s.query_contacts();
  ASSERT_EQ(contacts.size(), 2u);
  EXPECT_EQ(contacts[0].pair, 0);
  EXPECT_EQ(contacts[1].pair, 1);
}

TEST(Query, PairDistanceAndLowerBound_AgreeWithTheShapes) {
  Fixture s(test::make_busy_scene());
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    s.move_to_random(random, 0.5);
    for (const int pair : s.all_pairs()) {
      const Distance d = pair_distance(*s.model, s.kinematics, pair, s.work);
      EXPECT_NEAR(d.phi, s.distance(pair).phi, 1e-9);
      EXPECT_LE(calc_pair_lower_bound(*s.model, s.kinematics, pair, s.work), d.phi + 1e-12);
    }
  }
}

/// Whatever was asked of the workspace before.
TEST(Query, Gap_IsTheDistanceOrABoundThatIsEnough) {
  Fixture s(test::make_busy_scene());
  Random random(8);
  int cut = 0, bounded = 0;
  s.move_to_random(random, 1.0);
  const world::Kinematics elsewhere = s.kinematics;
  Gaps gaps(*s.model, s.kinematics, s.work);
  for (int i = 0; i < 100; ++i) {
    s.move_to_random(random, i % 2 ? 0.2 : 1.0);
    gaps.forget();
    for (const int pair : s.all_pairs()) {
      if (random.uniform(0, 1) < 0.2) pair_distance(*s.model, elsewhere, pair, s.work);
      const double phi = s.distance(pair).phi, enough = random.uniform(-0.02, 0.4);
      const double bound = calc_pair_lower_bound(*s.model, s.kinematics, pair, s.work);
      EXPECT_NEAR(gaps.calc(pair, enough), bound >= enough ? bound : std::min(phi, enough), 1e-9);
      cut += phi > enough && bound < enough, bounded += bound >= enough;
    }
  }
  EXPECT_GT(cut, 50);
  EXPECT_GT(bounded, 50);
}

/// The workspace may not have placed anything before.
TEST(Query, Gap_OfANewWorkspaceIsTheSame) {
  Fixture s(test::make_busy_scene());
  Random random(9);
  s.move_to_random(random, 0.2);
  Workspace fresh(*s.model);
  Gaps gaps(*s.model, s.kinematics, fresh);
  for (const int pair : s.all_pairs()) {
    const double phi = s.distance(pair).phi;
    EXPECT_NEAR(gaps.calc(pair, std::numeric_limits<double>::infinity()), phi, 1e-9);
  }
}

/// A pair keeps all its contacts or none, by the distance of its nearest points.
TEST(Query, NearDistances_LeaveOutWholePairs) {
  Fixture s(test::make_busy_scene());
  Random random(7);
  std::vector<double> near(s.model->pairs().size());
  std::size_t kept = 0, left_out = 0;
  for (int i = 0; i < 200; ++i) {
    s.move_to_random(random);
    for (double& d : near) d = random.uniform(-0.02, 0.06);
    const auto all = s.query_contacts();
    std::vector<Contact> want;
    for (const Contact& c : all) {
      const Distance d = s.distance(c.pair);
      if (d.phi < near[static_cast<std::size_t>(c.pair)]) want.push_back(c);
    }
    expect_identical(s.query_contacts({.near = near}), want);
    kept += want.size(), left_out += all.size() - want.size();
  }
  EXPECT_GT(kept, 200u);
  EXPECT_GT(left_out, 200u);
}

TEST(QueryPairs, Subset_IsInTheGivenOrderAndIgnoresMaxDistance) {
  Fixture s(test::make_busy_scene());
  Random random(5);
  std::vector<Contact> out;
  for (int i = 0; i < 50; ++i) {
    s.move_to_random(random);
    std::vector<int> pairs = s.all_pairs();
    std::reverse(pairs.begin(), pairs.end());
    query_pairs(*s.model, s.kinematics, pairs, 0.15, s.work, out);
    std::stable_sort(out.begin(), out.end(), [](const Contact& a, const Contact& b) { return a.pair < b.pair; });
    expect_same(out, s.query_contacts({.margin = 1.0, .cutoff = 0.15}), 1e-14);
  }
}

TEST(MinDistance, RandomConfigurations_EqualsBruteForceAndStopsEarlyCorrectly) {
  Fixture s(test::make_busy_scene());
  Random random(6);
  int stopped = 0;
  for (int i = 0; i < 200; ++i) {
    s.move_to_random(random, i % 2 ? 0.2 : 1.0);
    std::vector<int> pairs;
    for (const int p : s.all_pairs()) {
      if (random.uniform(0, 1) < 0.3) pairs.push_back(p);
    }
    double want = std::numeric_limits<double>::infinity();
    for (const int p : pairs) want = std::min(want, s.distance(p).phi);
    EXPECT_NEAR(calc_min_distance(*s.model, s.kinematics, pairs, -std::numeric_limits<double>::infinity(), s.work), want, 1e-9);
    const double got = calc_min_distance(*s.model, s.kinematics, pairs, 0.001, s.work);
    EXPECT_EQ(got < 0.001, want < 0.001);
    EXPECT_GE(got, want - 1e-9);
    if (got >= 0.001) {
      EXPECT_NEAR(got, want, 1e-9);
    }
    stopped += got < 0.001;
    for (const double distance : {-0.01, 0.001, 0.05, want - 1e-6, want + 1e-6}) {
      if (!std::isfinite(distance) || std::abs(distance - want) < 1e-9) continue;
      EXPECT_EQ(any_nearer(*s.model, s.kinematics, pairs, distance, s.work), want < distance) << distance << " for " << want;
    }
  }
  EXPECT_GT(stopped, 20);
  EXPECT_LT(stopped, 180);
  EXPECT_EQ(calc_min_distance(*s.model, s.kinematics, {}, 0.0, s.work), std::numeric_limits<double>::infinity());
  EXPECT_FALSE(any_nearer(*s.model, s.kinematics, {}, 1.0, s.work));
}

TEST(Query, PlanarModel_FramesLieInThePlane) {
  for (const auto& [joint, axis] : {std::pair(world::ObjectJoint::PlanarYZ, 0), std::pair(world::ObjectJoint::PlanarXZ, 1),
                                    std::pair(world::ObjectJoint::PlanarXY, 2)}) {
    world::Scene scene;
    scene.contact_distance = 10;
    scene.objects = {test::make_object("ball", world::Sphere{0.1}, joint), test::make_object("box", world::Box{{0.3, 0.3, 0.3}}, joint),
                     test::make_object("can", world::Cylinder{0.2, 0.1}, joint), test::make_object("pin", world::Capsule{0.1, 0.2}, joint)};
    Fixture s(scene);
    ASSERT_EQ(s.model->planar_axis(), axis);
    Random random(7);
    for (int i = 0; i < 300; ++i) {
      i == 0 ? s.move_to(s.model->neutral()) : s.move_to_random(random, i % 2 ? 0.2 : 1.0);  // from coincident to far apart
      for (const Contact& c : s.query_contacts()) {
        // A cylinder that lies in the plane is round across it: 0.3 m deep the way out through its side is as short as any.
        const auto is_can = [&](int g) { return s.model->geometries()[g].name == "can/g"; };
        if (axis != 2 && c.phi < -0.28 && (is_can(s.model->pairs()[c.pair].geometry_a) || is_can(s.model->pairs()[c.pair].geometry_b)))
          continue;
        const std::string what = "axis " + std::to_string(axis) + " pair " + std::to_string(c.pair) + " #" + std::to_string(i);
        EXPECT_NEAR(c.nhat_BA_W[axis], 0, 1e-9) << what;
        EXPECT_NEAR(c.t1_W[axis], 0, 1e-12) << what;
        EXPECT_LE((c.t1_W - Vector3d::Unit(axis).cross(c.nhat_BA_W)).norm(), 1e-9) << what;
        EXPECT_LE((c.t2_W - Vector3d::Unit(axis)).norm(), 1e-9) << what;
        EXPECT_NEAR(c.p_WA[axis], c.p_WB[axis], 1e-9) << what;
      }
    }
  }
}

TEST(Query, AnyHistoryAndThread_SameBits) {
  const world::Scene scene = test::make_busy_scene();
  Fixture s(scene);
  Random random(9);
  std::vector<Eigen::VectorXd> configurations;
  std::vector<std::vector<Contact>> forward;
  for (int i = 0; i < 60; ++i) {
    s.move_to_random(random);
    configurations.push_back(s.q);
    forward.push_back(s.query_contacts());
  }
  const auto backward = [&](Fixture& other, std::vector<std::vector<Contact>>& out) {
    out.resize(configurations.size());
    for (std::size_t i = configurations.size(); i-- > 0;) {
      other.move_to(configurations[i]);
      out[i] = other.query_contacts();
    }
  };
  Fixture one(scene), two(scene);
  std::vector<std::vector<Contact>> a, b;
  std::thread first([&] { backward(one, a); }), second([&] { backward(two, b); });
  first.join();
  second.join();
  for (std::size_t i = 0; i < forward.size(); ++i) {
    expect_identical(a[i], forward[i]);
    expect_identical(b[i], forward[i]);
  }
}

TEST(Query, PolytopesAfterOtherPoses_SameBitsAsAFreshWorkspace) {
  world::Scene scene;
  scene.contact_distance = 0.05;
  scene.objects = {test::make_object("a", test::make_mesh()), test::make_object("b", test::make_mesh()),
                   test::make_object("c", world::Box{{0.05, 0.06, 0.02}})};
  Fixture used(scene);
  Random random(11);
  const std::vector<int> pairs = used.all_pairs();
  int hits = 0, misses = 0;
  for (int i = 0; i < 3000; ++i) {
    // Every third pose is near the last one, so that what parted the bodies there still does, or only just does not any more.
    Eigen::VectorXd q = i % 3 ? used.q : used.model->neutral();
    for (int k = 0; k < 3; ++k) {
      if (i % 3) {
        q.segment<3>(7 * k) += random.in_cube(0.02);
      } else {
        q.segment<3>(7 * k) = random.in_cube(0.15);
        q.segment<4>(7 * k + 3) = Eigen::Quaterniond(random.rotation()).coeffs();
      }
    }
    used.move_to(q);
    Workspace fresh(*used.model);
    std::vector<Contact> want;
    query(*used.model, used.kinematics, {}, fresh, want);
    Workspace also_fresh(*used.model);
    const double stop_below = i % 2 ? -1 : 0.04;
    EXPECT_EQ(calc_min_distance(*used.model, used.kinematics, pairs, stop_below, used.work),
              calc_min_distance(*used.model, used.kinematics, pairs, stop_below, also_fresh));
    expect_identical(used.query_contacts(), want);
    hits += !want.empty();
    misses += want.empty();
  }
  EXPECT_GT(hits, 300);
  EXPECT_GT(misses, 300);
}

TEST(Query, NoPairs_NoContacts) {
  world::Scene scene;
  scene.objects = {test::make_object("alone", world::Sphere{0.1})};
  Fixture s(scene);
  s.move_to(s.q);
  EXPECT_TRUE(s.query_contacts().empty());
  Jacobians jacobians;
  calc_jacobians(*s.model, s.kinematics, {}, s.work, jacobians);
  EXPECT_EQ(jacobians.begin, std::vector<int>{0});
}

TEST(Query, BadInput_IsNamed) {
  Fixture s(test::make_busy_scene());
  world::Scene small;
  small.objects = {test::make_object("alone", world::Sphere{0.1})};
  Fixture other(small);
  s.move_to(s.q);
  std::vector<Contact> out;
  EXPECT_NE(message_of([&] { query(*s.model, s.kinematics, {.margin = -1}, s.work, out); }).find("margin"), std::string::npos);
  EXPECT_NE(message_of([&] { query(*s.model, s.kinematics, {.cutoff = std::nan("")}, s.work, out); }).find("cutoff"), std::string::npos);
  const double one[] = {0.1};
  EXPECT_NE(message_of([&] { query(*s.model, s.kinematics, {.near = one}, s.work, out); }).find("near"), std::string::npos);
  EXPECT_NE(message_of([&] { query(*s.model, s.kinematics, {}, other.work, out); }).find("work.pairs"), std::string::npos);
  EXPECT_NE(message_of([&] { query(*s.model, other.kinematics, {}, s.work, out); }).find("kinematics.X_WB"), std::string::npos);
  EXPECT_NE(message_of([&] { (void)pair_distance(*s.model, s.kinematics, 9999, s.work); }).find("9999"), std::string::npos);
  const int bad[] = {0, -1};
  EXPECT_NE(message_of([&] { query_pairs(*s.model, s.kinematics, bad, 1.0, s.work, out); }).find("-1"), std::string::npos);
}

TEST(Workspace, PairOfTwoHalfSpaces_Refused) {
  world::Scene scene;
  scene.objects = {test::make_object("floating_floor", world::HalfSpace{})};
  scene.fixed = {{"ground", {}, {{"plane", world::HalfSpace{}, {}, 1.0}}}};
  const std::string message = message_of([&] { Workspace work(*world::Model::make(scene)); });  // the model may refuse it first
  EXPECT_NE(message.find("half-space"), std::string::npos) << message;
}

}  // namespace
}  // namespace stiction::contact
