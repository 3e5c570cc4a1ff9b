// Postures in contact, and paths from one to another.
#include "stiction/contact/free_path.hpp"

#include "stiction/contact/contact_sampler.hpp"
#include "stiction/contact/gap_gradient.hpp"
#include "stiction/contact/pinch.hpp"
#include "stiction/contact/within_reach.hpp"
#include "stiction/world/scales.hpp"
#include "world/allegro.hpp"
#include "world/gripper.hpp"

namespace stiction::contact {
namespace {

/// Smallest gap of the pairs that the branches move, and the smallest one to an object.
std::pair<double, double> gaps(const world::Model& model, const world::RobotChains& chains, world::ChainMask moving,
                               const Eigen::VectorXd& q, GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  std::vector<int> pairs;
  chains.pairs_of(moving, pairs);
  double all = 1e9, object = 1e9;
  for (const int pair : pairs) {
    const double phi = pair_distance(model, work.kinematics, pair, work.contact_work).phi;
    all = std::min(all, phi);
    if (chains.touches_object(pair)) object = std::min(object, phi);
  }
  return {all, object};
}

TEST(ContactSampler, Generic_TouchesAndDoesNotPenetrate) {
  for (const char* task : {"planar_pushing", "planar_hand", "allegro_ball"}) {
    const auto model = world::test::load_task(task);
    const world::RobotChains chains(*model);
    GeometryWorkspace work(*model);
    Eigen::VectorXd q = model->neutral();
    if (model->n_a() == 16) q = world::test::allegro_start();
    if (model->n_a() == 4) q[1] = 0.35;
    core::Random random(7, 0);
    int found = 0;
    for (int draw = 0; draw < 100; ++draw) {
      const world::ChainMask grasp = draw_grasp(chains, GenericSampler{}, random);
      const auto sample = sample_contact(*model, chains, GenericSampler{}, grasp, q, random, work);
      if (!sample) continue;
      ++found;
      EXPECT_EQ(sample->moved & ~grasp, 0u);
      Eigen::VectorXd touching = q;
      touching.tail(model->n_a()) = sample->q_a;
      const auto [all, object] = gaps(*model, chains, sample->moved, touching, work);
      const double touching_gap = 0.101 * world::share::kContact * model->scales().robots().length;
      EXPECT_GE(all, -touching_gap);
      EXPECT_LE(object, touching_gap);
      EXPECT_TRUE((sample->q_a.array() >= model->lower().array()).all() && (sample->q_a.array() <= model->upper().array()).all());
      for (int c = 0; c < chains.size(); ++c) {
        if (sample->moved >> c & 1) continue;
        for (const int j : chains.joints(c)) EXPECT_EQ(sample->q_a[j], q[model->n_qu() + j]);
      }
    }
    EXPECT_GT(found, 60) << task;
  }
}

/// The object that both fingers of the gripper hold between them; −1: none.
int pinched_object(const world::Model& model, const Eigen::VectorXd& q, GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  const double touching_gap = 0.101 * world::share::kContact * model.scales().robots().length;
  std::vector<std::pair<int, Eigen::Vector3d>> left, right;  // object, and the way that the finger pushes it
  for (int i = 0; i < static_cast<int>(model.pairs().size()); ++i) {
    const world::Pair& pair = model.pairs()[static_cast<std::size_t>(i)];
    const int held = model.geometries()[static_cast<std::size_t>(pair.geometry_a)].body;
    if (model.bodies()[static_cast<std::size_t>(held)].kind != world::BodyKind::Object) continue;
    const std::string& finger = model.geometries()[static_cast<std::size_t>(pair.geometry_b)].name;
    const Distance d = pair_distance(model, work.kinematics, i, work.contact_work);
    if (std::abs(d.phi) > touching_gap) continue;
    if (finger.find("left_finger") != std::string::npos) left.emplace_back(held, d.nhat_BA_W);
    if (finger.find("right_finger") != std::string::npos) right.emplace_back(held, d.nhat_BA_W);
  }
  for (const auto& [held, push] : left) {
    for (const auto& [also, against] : right) {
      if (held == also && push.dot(against) < -0.7) return held;
    }
  }
  return -1;
}

TEST(ContactSampler, AGripperTakesObjectsBetweenItsFingers) {
  const std::filesystem::path packages[] = {stiction::test::package_dir()};
  const auto model = world::Model::make(world::load_scene(stiction::test::source_dir() / "models/stacking.yaml", packages));
  const world::RobotChains chains(*model);
  GeometryWorkspace work(*model);
  Eigen::VectorXd q_start = model->neutral();  // boxes side by side on the ground
  for (int i = 0; i < 10; ++i) q_start.segment<3>(7 * i) = Eigen::Vector3d(0.4 + 0.25 * (i / 5), -0.5 + 0.25 * (i % 5), 0.04);
  const auto share_of_pinches = [&](double probability) {
    GenericSampler sampler;
    sampler.pinch_probability = probability;
    core::Random random(5, 0);
    Eigen::VectorXd q = q_start;
    int found = 0, pinches = 0;
    for (int draw = 0; draw < 100; ++draw) {
      const auto sample = sample_contact(*model, chains, sampler, chains.all(), q_start, random, work);
      if (!sample) continue;
      ++found;
      q.tail(model->n_a()) = sample->q_a;
      pinches += pinched_object(*model, q, work) >= 0;
    }
    return static_cast<double>(pinches) / found;
  };
  EXPECT_LT(share_of_pinches(0), 0.03) << "branches that are brought to objects one by one hardly ever hold one";
  EXPECT_GT(share_of_pinches(1), 0.2);
}

/// A hand of four fingers is no gripper, and its draws stay as they are.
TEST(ContactSampler, AHandOfManyFingersHasNoPinch) {
  const auto model = world::test::load_task("allegro_plate");
  const world::RobotChains chains(*model);
  core::Random random(5, 0);
  std::vector<int> scratch;
  for (int c = 0; c < chains.size(); ++c) EXPECT_FALSE(draw_pinch(*model, chains, c, chains.all(), {}, random, scratch));
  EXPECT_EQ(random.bits(), core::Random(5, 0).bits());
}

/// Whatever posture it is asked in: a pair that touches in another posture of the same joints is within reach.
TEST(WithinReach, NeverLeavesOutAPairThatTouches) {
  for (const char* task : {"planar_pushing", "allegro_ball", "allegro_plate", "iiwa_bimanual"}) {
    const auto model = world::test::load_task(task);
    const world::RobotChains chains(*model);
    GeometryWorkspace work(*model);
    core::Random random(3, 0);
    int touching = 0, out_of_reach = 0;
    Eigen::VectorXd q = model->neutral();
    const Eigen::VectorXd lower = model->lower().cwiseMax(-1.0), upper = model->upper().cwiseMin(1.0);
    for (int draw = 0; draw < 200; ++draw) {
      const int chain = random.index(chains.size());
      const auto moving = joint_flags(*model, chains.joints(chain));
      for (int k = 0; k < 3 && model->n_qu() > 3; ++k) q[k] = 0.2 * random.normal();
      for (int j = 0; j < model->n_a(); ++j) q[model->n_qu() + j] = random.uniform(lower[j], upper[j]);
      Eigen::VectorXd other = q;
      for (const int j : chains.joints(chain)) other[model->n_qu() + j] = random.uniform(lower[j], upper[j]);
      for (const int pair : chains.object_pairs(chain)) {
        world::calc_kinematics(*model, other, work.kinematics_work, work.kinematics);
        const bool touches = pair_distance(*model, work.kinematics, pair, work.contact_work).phi <= 0;
        world::calc_kinematics(*model, q, work.kinematics_work, work.kinematics);
        const bool within = may_touch(*model, work.kinematics, q, moving, pair);
        EXPECT_TRUE(within || !touches) << task << ", pair " << pair;
        touching += touches;
        out_of_reach += !within;
      }
    }
    EXPECT_GT(touching, 0) << task;
    if (model->n_a() == 16) {
      EXPECT_GT(out_of_reach, 100) << task;
    }
  }
}

TEST(FindPath, KeepsItsClearanceBetweenTheContacts) {
  const auto model = world::test::load_task("allegro_ball");
  const world::RobotChains chains(*model);
  GeometryWorkspace work(*model);
  const Eigen::VectorXd q = world::test::allegro_start();
  core::Random random(8, 0);
  int found = 0;
  for (int draw = 0; draw < 60 && found < 15; ++draw) {
    const world::ChainMask grasp = draw_grasp(chains, GenericSampler{}, random);
    const auto sample = sample_contact(*model, chains, GenericSampler{}, grasp, q, random, work);
    if (!sample) continue;
    std::vector<Eigen::VectorXd> path;
    const PathOptions options;
    if (find_path(*model, chains, sample->moved, q, sample->q_a, options, random, work, path) != PathOutcome::Found) continue;
    ++found;
    EXPECT_EQ(path.back(), sample->q_a);
    // Once clear of its first contacts a finger stays clear until it comes back: fine samples of the whole path.
    Eigen::VectorXd at = q, from = q.tail(16);
    bool clear = false, back = false;
    for (const auto& posture : path) {
      for (int k = 1; k <= 25; ++k) {
        at.tail(16) = from + k / 25.0 * (posture - from);
        const double gap = gaps(*model, chains, sample->moved, at, work).first;
        EXPECT_GT(gap, -5e-4) << "leaving or reaching a contact";
        if (gap > 0.9 * options.clearance) {
          EXPECT_FALSE(back) << "touched something on the way";
          clear = true;
        } else if (clear) {
          back = true;
        }
      }
      from = posture;
    }
    EXPECT_TRUE(clear);
  }
  EXPECT_GE(found, 15);
}

/// A ball at the end of an arm of 1 m that turns about z, and a plate of 1 cm across its way.
std::shared_ptr<const world::Model> make_arm_and_plate() {
  world::Scene scene;
  world::RobotSpec& arm = scene.robots.emplace_back();
  arm.name = "arm";
  arm.urdf = "./";
  arm.text =
      "<robot name='arm'><link name='base'/><link name='tip'><collision><origin xyz='1 0 0'/><geometry><sphere radius='0.001'/></geometry>"
      "</collision></link><joint name='turn' type='revolute'><parent link='base'/><child link='tip'/><axis xyz='0 0 1'/>"
      "<limit lower='-2' upper='2' effort='10'/></joint></robot>";
  world::FixedSpec& plate = scene.fixed.emplace_back();
  plate.name = "plate";
  plate.X_WB.p.x() = 1;
  plate.geometries = {{"box", world::Box{{0.3, 0.005, 0.3}}, {}, 1.0}};
  return world::Model::make(scene);
}

/// On sliders and hinges, with a finger that slides on them.
TEST(FindPath, AGripperKeepsHalfOfItsClearanceEverywhere) {
  const world::test::RobotFolder folder;
  const auto model = world::test::make_gripper(folder, 0.1);
  const world::RobotChains chains(*model);
  GeometryWorkspace work(*model);
  core::Random random(5, 0);
  const PathOptions options{.clearance = 4e-3};
  Eigen::VectorXd q = world::test::gripper_start(*model);
  int found = 0, bent = 0;
  for (int draw = 0; draw < 400 && found < 40; ++draw) {
    Eigen::VectorXd goal = q;
    for (int j = 0; j < model->n_a(); ++j) goal[model->n_qu() + j] = random.uniform(model->lower()[j], model->upper()[j]);
    goal[model->n_qu() + 2] = random.uniform(-0.3, -0.1);  // beside the cube
    if (gaps(*model, chains, chains.all(), goal, work).first < options.clearance) continue;
    std::vector<Eigen::VectorXd> path;
    if (find_path(*model, chains, chains.all(), q, goal.tail(model->n_a()), options, random, work, path) != PathOutcome::Found) continue;
    ++found, bent += path.size() > 1;
    Eigen::VectorXd at = q, from = q.tail(model->n_a());
    for (const auto& posture : path) {
      for (int k = 1; k <= 200; ++k) {
        at.tail(model->n_a()) = from + k / 200.0 * (posture - from);
        EXPECT_GE(gaps(*model, chains, chains.all(), at, work).first, 0.5 * options.clearance - 1e-9);
      }
      from = posture;
    }
    q = goal;
  }
  EXPECT_EQ(found, 40);
  EXPECT_GE(bent, 10);
}

TEST(FindPath, LongArm_IsNotLedThroughAThinPlate) {
  const auto model = make_arm_and_plate();
  const world::RobotChains chains(*model);
  GeometryWorkspace work(*model);
  for (int k = 0; k < 200; ++k) {  // steps of 1 mm: any step that is longer than the plate is thick jumps over it from some of these places
    const Eigen::VectorXd q = Eigen::VectorXd::Constant(1, -0.4 - 1e-3 * k), goal = Eigen::VectorXd::Constant(1, 0.4);
    core::Random random(1, static_cast<std::uint64_t>(k));
    std::vector<Eigen::VectorXd> path;
    EXPECT_EQ(find_path(*model, chains, 1, q, goal, {.max_extensions = 10}, random, work, path), PathOutcome::NotFound) << q[0];
    const Eigen::VectorXd this_side = Eigen::VectorXd::Constant(1, -0.1);
    EXPECT_EQ(find_path(*model, chains, 1, q, this_side, {}, random, work, path), PathOutcome::Found) << q[0];
  }
}

}  // namespace
}  // namespace stiction::contact
