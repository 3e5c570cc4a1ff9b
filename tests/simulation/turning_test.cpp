// Contacts that resist turning and rolling: analytic laws at three scales, and numbers of files beside MuJoCo's own.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "simulation/scenes.hpp"
#include "stiction/simulation/plant_impl.hpp"
#include "stiction/world/mjcf.hpp"
#include "support/temporary_folder.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using world::ObjectJoint;

constexpr double kMu = 0.6;
constexpr double kScales[] = {0.005, 0.04, 0.5};  // radii [m]

/// Something round on a floor whose surface has the rule.
Rig make_rig(const world::Shape& shape, double mass, const world::SurfaceRule& rule, const Vector3d& gravity = {0, 0, -kG},
             const PlantOptions& options = {}, double mu = kMu) {
  world::Scene scene = empty_scene(gravity);
  scene.objects.push_back(solid(ObjectJoint::Free, shape, mass, mu));
  scene.objects[0].geometries[0].rule = rule;
  scene.fixed.push_back(ground(mu));
  return Rig(scene, options);
}

Eigen::VectorXd at_height(double height) {
  Eigen::VectorXd q(7);
  q << 0, 0, height, 0, 0, 0, 1;
  return q;
}

double water(double radius) { return 1000 * 4.0 / 3 * M_PI * radius * radius * radius; }  // of a ball [kg]

/// The speed of coordinate `index` at 30 % and at 70 % of the time in which it would come to rest; at the end there is none.
void expect_even_deceleration(Rig& rig, const Eigen::VectorXd& q0, const Eigen::VectorXd& v0, int index, double deceleration,
                              const std::string& what) {
  const double rest = std::abs(v0[index]) / deceleration;
  rig.run.record_interval = rest / 10;
  ASSERT_EQ(rig.hold(q0, {}, 1.5 * rest, &v0), Status::Solved) << rig.result.message;
  const auto& r = rig.result;
  const Eigen::Index early = 3, late = 7;
  const double got = (std::abs(r.v(index, early)) - std::abs(r.v(index, late))) /
                     (r.times[static_cast<std::size_t>(late)] - r.times[static_cast<std::size_t>(early)]);
  EXPECT_NEAR(got, deceleration, 0.03 * deceleration) << what;
  EXPECT_LT(std::abs(r.v(index, r.v.cols() - 1)), 0.01 * std::abs(v0[index])) << what;
}

/// τ = μ_t m g on 2/5 m r².
TEST(Turning, BallThatSpinsOnThePlane_StopsByItsMoment) {
  for (const double r : kScales) {
    const double torsional = 0.05 * r;
    Rig rig = make_rig(world::Sphere{r}, water(r), {.dimension = 4, .torsional = torsional});
    const double deceleration = 2.5 * torsional * kG / (r * r);
    Eigen::VectorXd v0 = Eigen::VectorXd::Zero(6);
    v0[5] = deceleration * 1.0;  // a second
    expect_even_deceleration(rig, at_height(r), v0, 5, deceleration, fmt::format("r = {}", r));
  }
}

/// Each of the points on the rim slips at ω R and turns at ω: of all forces in the cone those that take the most power have the moment f_n √(μ²R² + μ_t²).
/// On a smooth floor: a sliding contact opens by what it slips times μ (M.3). And no larger: MuJoCo's three points of a cylinder on a plane change places as it
/// tilts, and from radii of 0.25 m on they throw it up.
TEST(Turning, DiscThatSpinsOnThePlane_StopsBySlidingAndTurningTogether) {
  constexpr double kSmooth = 0.1;
  for (const double r : {0.005, 0.04, 0.1}) {
    const double torsional = 0.05 * r, half = 0.1 * r, mass = 3000 * M_PI * r * r * 2 * half;
    const double deceleration = kG * std::hypot(kSmooth * r, torsional) / (0.5 * r * r);
    Eigen::VectorXd v0 = Eigen::VectorXd::Zero(6);
    v0[5] = deceleration * 0.4;
    Rig rig = make_rig(world::Cylinder{r, half}, mass, {.dimension = 4, .torsional = torsional}, {0, 0, -kG}, {}, kSmooth);
    expect_even_deceleration(rig, at_height(half), v0, 5, deceleration, fmt::format("r = {}", r));
  }
}

/// m a = −F and I a/r = F r − μ_r m g: a = 5/7 μ_r g/r.
TEST(Rolling, BallOnThePlane_RollsToRest) {
  for (const double r : kScales) {
    const double rolling = 0.02 * r, deceleration = 5.0 / 7 * rolling * kG / r;
    Eigen::VectorXd v0 = Eigen::VectorXd::Zero(6);
    v0[0] = deceleration * 2;
    v0[4] = v0[0] / r;
    Rig rig = make_rig(world::Sphere{r}, water(r), {.dimension = 6, .torsional = 0, .rolling = rolling});
    expect_even_deceleration(rig, at_height(r), v0, 0, deceleration, fmt::format("r = {}", r));
    Rig without = make_rig(world::Sphere{r}, water(r), {.dimension = 4, .torsional = 0.1 * r, .rolling = rolling});
    ASSERT_EQ(without.hold(at_height(r), {}, 1, &v0), Status::Solved);
    EXPECT_NEAR(without.v_end()[0], v0[0], 0.02 * v0[0]) << "condim 4 has no rolling friction: r = " << r;
  }
}

/// A ball rests on a slope of less than μ_r/r, and rolls down a steeper one. The friction F that turns it is part of the cone, so that the moment is
/// μ_r f_n √(1 − (F/μ f_n)²).
TEST(Rolling, BallOnASlope_RollsFromMomentOverRadiusOn) {
  constexpr double r = 0.04, kRolling = 0.1 * r;
  for (const double share : {0.9, 1.2}) {
    const double theta = std::atan(share * kRolling / r);
    Rig rig =
        make_rig(world::Sphere{r}, water(r), {.dimension = 6, .rolling = kRolling}, kG * Vector3d(std::sin(theta), 0, -std::cos(theta)));
    ASSERT_EQ(rig.hold(at_height(r), {}, 1), Status::Solved);
    double down = 0, moment = 1;
    for (int i = 0; i < 20; ++i) {
      down = 5.0 / 7 * kG * (std::sin(theta) - moment * kRolling / r * std::cos(theta));
      moment = std::sqrt(1 - std::pow((kG * std::sin(theta) - down) / (kMu * kG * std::cos(theta)), 2));
    }
    if (share < 1)
      EXPECT_LT(std::abs(rig.v_end()[0]), 1e-3);
    else  // the second half: the onset is smooth
      EXPECT_NEAR((rig.v_end()[0] - rig.result.v(0, rig.result.v.cols() / 2)) / 0.5, down, 0.02 * down);
  }
}

/// A can that falls from its rim with some spin rolls round it for seconds, like a coin. Moments that one would choose by default do not stop it, those of a
/// patch of a quarter of its radius do.
TEST(Turning, CanThatFellOnItsRim_StopsByTheMomentOfAPatchAndNotByLess) {
  constexpr double kTilt = 0.5;
  for (const double r : {0.005, 0.02, 0.1}) {
    const double half = 0.7 * r;
    Eigen::VectorXd q0 = at_height(r * std::sin(kTilt) + half * std::cos(kTilt)), v0 = Eigen::VectorXd::Zero(6);
    q0[3] = std::sin(kTilt / 2), q0[6] = std::cos(kTilt / 2);
    v0.tail<3>() = 3 * std::sqrt(0.02 / r) * Vector3d(0, std::sin(kTilt), std::cos(kTilt));  // about the vertical, in its axes
    const auto turns_after = [&](double duration, const world::SurfaceRule& rule) {
      Rig rig = make_rig(world::Cylinder{r, half}, 1000 * M_PI * r * r * 2 * half, rule, {0, 0, -kG}, {}, 0.5);
      EXPECT_EQ(rig.hold(q0, {}, duration, &v0), Status::Solved);
      return rig.v_end().tail<3>().norm();
    };
    const double without = turns_after(3, {});
    EXPECT_GT(without, 0.3 * std::sqrt(kG / r)) << r;
    EXPECT_GT(turns_after(3, {.dimension = 6, .torsional = 0.02 * r, .rolling = 0.005 * r}), 0.7 * without) << r;
    EXPECT_LT(turns_after(1, {.dimension = 4, .torsional = 0.25 * r}), 0.01 * without) << r;
  }
}

/// Less friction turns less, rolling is not of it, and what does not slide does not turn.
TEST(Turning, FrictionScale_ScalesMomentsAboutTheNormalAlone) {
  const world::SurfaceRule rule{.dimension = 6, .torsional = 0.01, .rolling = 0.002};
  PlantOptions options;
  for (const double scale : {1.0, 0.5, 0.0}) {
    options.contact.friction_scale = scale;
    const Rig rig = make_rig(world::Sphere{0.1}, 1, rule, {0, 0, -kG}, options);
    const mjModel* m = rig.plant->impl().mujoco.get();
    ASSERT_EQ(m->npair, 1);
    EXPECT_EQ(m->pair_dim[0], scale > 0 ? 6 : 1);
    if (scale == 0) continue;
    EXPECT_DOUBLE_EQ(m->pair_friction[0], scale * kMu);
    EXPECT_DOUBLE_EQ(m->pair_friction[2], scale * rule.torsional);
    EXPECT_DOUBLE_EQ(m->pair_friction[3], rule.rolling);
    EXPECT_DOUBLE_EQ(m->pair_friction[4], rule.rolling);
  }
}

/// Balls that overlap on a floor, in all combinations of condim, moments and priority, by defaults classes and pairs: contacts of MuJoCo's own model have the
/// numbers that pairs of the plant have.
TEST(Turning, FileReachesThePlant_WithTheNumbersOfMuJoCosContacts) {
  std::string bodies, pairs;
  int count = 0;
  for (const int condim : {1, 3, 4, 6}) {
    for (const int priority : {0, 1}) {
      for (const auto& [torsional, rolling] : {std::pair(0.003, 0.0002), std::pair(0.02, 0.00005)}) {
        bodies += fmt::format(
            R"(<body name="b{0}" pos="{5} 0 0.05"><freejoint/><geom name="g{0}" size=".1" condim="{1}" priority="{2}" friction=".5 {3} {4}"/></body>)",
            count, condim, priority, torsional, rolling, 0.001 * count);
        ++count;
      }
    }
  }
  bodies += R"(<body name="soft" pos="0 0.01 .05"><freejoint/><geom name="pad" class="pad" size=".1"/></body>)";
  pairs =
      R"(<pair geom1="g0" geom2="g15" condim="4" friction=".5 .5 .007"/><pair geom1="floor" geom2="g5" condim="6" friction=".5 .5 .004 .0003 .0003"/>
             <pair geom1="g2" geom2="g9" condim="3" friction=".5 .5 .007"/><pair geom1="g3" geom2="pad" condim="1"/>)";
  const auto file = stiction::test::folder_of_the_process() / "surfaces.xml";
  std::ofstream(file) << fmt::format(
      R"(<mujoco><default><geom friction=".5"/><default class="pad"><geom condim="4" friction=".5 .011 .0007"/></default></default>
         <worldbody><geom name="floor" type="plane" size="1 1 1" friction=".5 .0001 .0004"/>{}</worldbody><contact>{}</contact></mujoco>)",
      bodies, pairs);
  world::RobotSpec robot;
  robot.name = "r";
  robot.mjcf = file;
  world::Scene scene;
  world::add_mjcf(scene, robot);
  const auto plant = Plant::make(world::Model::make(scene));
  const mjModel* ours = plant->impl().mujoco.get();

  char error[1000] = "";
  const std::unique_ptr<mjModel, DeleteMujoco> theirs(mj_loadXML(file.c_str(), nullptr, error, sizeof(error)));
  ASSERT_NE(theirs, nullptr) << error;
  const std::unique_ptr<mjData, DeleteMujoco> data(mj_makeData(theirs.get()));
  mj_forward(theirs.get(), data.get());
  const auto name = [](const mjModel* m, int geom) {
    const std::string full = mj_id2name(m, mjOBJ_GEOM, geom);
    return full.substr(full.rfind('/') + 1);
  };
  std::map<std::set<std::string>, int> pair_of;
  for (int i = 0; i < ours->npair; ++i) pair_of[{name(ours, ours->pair_geom1[i]), name(ours, ours->pair_geom2[i])}] = i;
  std::set<int> dimensions;
  ASSERT_EQ(data->ncon, 18 * 17 / 2);
  for (int c = 0; c < data->ncon; ++c) {
    const mjContact& contact = data->contact[c];
    const std::set<std::string> names{name(theirs.get(), contact.geom[0]), name(theirs.get(), contact.geom[1])};
    ASSERT_TRUE(pair_of.contains(names)) << *names.begin() << ' ' << *names.rbegin();
    const int pair = pair_of.at(names);
    EXPECT_EQ(ours->pair_dim[pair], contact.dim) << *names.begin() << ' ' << *names.rbegin();
    dimensions.insert(contact.dim);
    constexpr int kNumbers[] = {0, 0, 0, 2, 3, 3, 5};
    for (int k = 0; k < kNumbers[contact.dim]; ++k)
      EXPECT_DOUBLE_EQ(ours->pair_friction[5 * pair + k], contact.friction[k]) << *names.begin() << ' ' << *names.rbegin() << ", " << k;
  }
  EXPECT_EQ(dimensions, (std::set<int>{1, 3, 4, 6}));
}

}  // namespace
}  // namespace stiction::simulation::test
