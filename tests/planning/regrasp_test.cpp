#include "stiction/planning/regrasp.hpp"

#include "planning/systems.hpp"
#include "stiction/planning/object_space.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning::test {
namespace {

/// Smallest gap of the pairs that the branches move, and the smallest one to an object.
std::pair<double, double> gaps(const world::Model& model, const RobotChains& chains, ChainMask moving, const Eigen::VectorXd& q,
                               GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  std::vector<int> pairs;
  chains.pairs_of(moving, pairs);
  double all = 1e9, object = 1e9;
  for (const int pair : pairs) {
    const double phi = contact::pair_distance(model, work.kinematics, pair, work.contact_work).phi;
    all = std::min(all, phi);
    if (chains.touches_object(pair)) object = std::min(object, phi);
  }
  return {all, object};
}

TEST(RobotChains, Allegro_HasFourFingersAndAllPairs) {
  const auto model = load_model("allegro_ball");
  const RobotChains chains(*model);
  ASSERT_EQ(chains.size(), 4);
  std::size_t with_object = 0;
  for (int c = 0; c < 4; ++c) {
    EXPECT_EQ(chains.joints(c).size(), 4u);
    with_object += chains.object_pairs(c).size();
  }
  EXPECT_EQ(with_object, 18u);  // the palm's pair moves with no finger
}

TEST(ContactSampler, Generic_TouchesAndDoesNotPenetrate) {
  for (const char* task : {"planar_pushing", "planar_hand", "allegro_ball"}) {
    const auto model = load_model(task);
    const RobotChains chains(*model);
    GeometryWorkspace work(*model);
    Eigen::VectorXd q = model->neutral();
    if (model->n_a() == 16) q = allegro_start();
    if (model->n_a() == 4) q[1] = 0.35;
    core::Random random(7, 0);
    int found = 0;
    for (int draw = 0; draw < 100; ++draw) {
      const GraspDraw grasp = draw_grasp(chains, GenericSampler{}, random);
      const auto sample = sample_contact(*model, chains, GenericSampler{}, grasp, q, random, work);
      if (!sample) continue;
      ++found;
      EXPECT_EQ(sample->moved & ~grasp.moved, 0u);
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

TEST(FindPath, KeepsItsClearanceBetweenTheContacts) {
  const auto model = load_model("allegro_ball");
  const RobotChains chains(*model);
  GeometryWorkspace work(*model);
  const Eigen::VectorXd q = allegro_start();
  core::Random random(8, 0);
  int found = 0;
  for (int draw = 0; draw < 60 && found < 15; ++draw) {
    const GraspDraw grasp = draw_grasp(chains, GenericSampler{}, random);
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

TEST(FindPath, AmongSeveralPlaces_KeepsItsClearanceAtEach) {
  const auto model = load_model("allegro_ball");
  const RobotChains chains(*model);
  GeometryWorkspace work(*model);
  std::vector<Eigen::VectorXd> places(3, allegro_start());
  places[1][0] += 0.02;  // the ball, 20 mm from where the others have it
  places[2][1] -= 0.02;
  core::Random random(8, 0);
  int found = 0;
  for (int draw = 0; draw < 60 && found < 10; ++draw) {
    const GraspDraw grasp = draw_grasp(chains, GenericSampler{}, random);
    const auto sample = sample_contact(*model, chains, GenericSampler{}, grasp, places[0], random, work);
    if (!sample) continue;
    std::vector<Eigen::VectorXd> path;
    const PathOptions options;
    const Eigen::VectorXd start = places[0].tail(16);
    if (find_path(*model, chains, sample->moved, places, start, sample->q_a, options, random, work, path) != PathOutcome::Found) continue;
    ++found;
    std::vector<double> least;  // gap over all places, along the path
    Eigen::VectorXd from = start;
    for (const auto& posture : path) {
      for (int k = 1; k <= 25; ++k) {
        double gap = std::numeric_limits<double>::infinity();
        for (Eigen::VectorXd q : places) {
          q.tail(16) = from + k / 25.0 * (posture - from);
          gap = std::min(gap, gaps(*model, chains, sample->moved, q, work).first);
        }
        least.push_back(gap);
      }
      from = posture;
    }
    const auto free = [&](double gap) { return gap > 0.9 * options.clearance; };
    const auto first = std::find_if(least.begin(), least.end(), free);
    const auto last = std::find_if(least.rbegin(), least.rend(), free).base();
    ASSERT_NE(first, least.end());
    EXPECT_TRUE(std::all_of(first, last, free)) << "once clear at all places it stays so until it comes back";
  }
  EXPECT_GE(found, 10);
}

TEST(FitsCones, OnlyIfEveryForceDoes) {
  dynamics::Knot knot;
  EXPECT_TRUE(fits_cones(knot, 0.8)) << "no force";
  knot.contacts.resize(2);
  for (auto& c : knot.contacts) {
    c.contact.friction = 0.5;
    c.lambda = {10, 3, 2.4};  // ‖λ_t‖ = 3.84 of 5
  }
  EXPECT_TRUE(fits_cones(knot, 0.8)) << "3.84 of 4";
  EXPECT_FALSE(fits_cones(knot, 0.7)) << "3.84 of 3.5";
  knot.contacts[1].lambda[1] = 4;
  EXPECT_FALSE(fits_cones(knot, 0.8)) << "4.66 of 4";
}

TEST(TryRegrasp, AcceptedOnes_KeepTheObjectAtRestWithLessFriction) {
  const auto model = load_model("allegro_ball");
  const RobotChains chains(*model);
  GeometryWorkspace geometry(*model);
  dynamics::StepWorkspace steps(model);
  const ObjectSpace space(*model);
  PlannerOptions options;
  const Eigen::VectorXd q = allegro_start();
  RegraspCounts counts;
  for (int attempt = 0; attempt < 40; ++attempt) {
    core::Random random(9, static_cast<std::uint64_t>(attempt));
    Regrasp regrasp;
    if (!try_regrasp(*model, chains, options, q, q.tail(16), draw_grasp(chains, options.sampler, random), {}, random, geometry, steps,
                     regrasp, counts))
      continue;
    for (const double friction : {1.0, options.regrasp_friction}) {  // an own simulation of every knot
      dynamics::StepOptions step_options;
      step_options.friction_scale = friction;
      Eigen::VectorXd now = q;
      dynamics::StepResult result;
      steps.forget();
      for (const auto& knot : regrasp.knots) {
        ASSERT_EQ(dynamics::step(*model, {now, knot.u}, step_options, steps, result), core::Status::Solved);
        now = result.q_next;
        EXPECT_TRUE(objects_agree(*model, space, q, now, options.regrasp_tol_position + 1e-5, options.regrasp_tol_angle + 1e-4));
      }
    }
  }
  EXPECT_GT(counts.accepted, 10);
  EXPECT_EQ(counts.tried, 40);
  EXPECT_EQ(counts.accepted + counts.no_sample + counts.no_path + counts.object_moved + counts.failed_step, 40);
}

/// Regrasps of the planar hand at its start.
struct HandRegrasps {
  explicit HandRegrasps(const std::string& task = "planar_hand") : model(load_model(task)) {}

  std::shared_ptr<const world::Model> model;
  RobotChains chains{*model};
  GeometryWorkspace geometry{*model};
  dynamics::StepWorkspace steps{model};
  Eigen::VectorXd q = hand_problem().q_start;
  PlannerOptions options = hand_options();

  bool attempt(const GraspJudge& judge, core::Random& random, Regrasp& out, RegraspCounts& counts) {
    const GraspDraw draw = draw_grasp(chains, options.sampler, random);
    return try_regrasp(*model, chains, options, q, q.tail(4), draw, judge, random, geometry, steps, out, counts);
  }
};

TEST(FreeOnItsWay, TouchOnTheWayCountsAtItsEndsNot) {
  HandRegrasps hand;
  core::Random random(4, 0);
  const GraspDraw draw{hand.chains.all()};
  const auto sample = sample_contact(*hand.model, hand.chains, hand.options.sampler, draw, hand.q, random, hand.geometry);
  ASSERT_TRUE(sample);
  const auto at = [&](double share) {  // of the way from the start, which is free, to the contact sample
    dynamics::Knot knot;
    knot.q = hand.q;
    knot.q.tail(4) += share * (sample->q_a - hand.q.tail(4));
    return knot;
  };
  ASSERT_GT((sample->q_a - hand.q.tail(4)).cwiseAbs().maxCoeff(), 0.2);
  const auto is_free = [&](const std::vector<double>& shares) {
    std::vector<dynamics::Knot> knots;
    for (const double share : shares) knots.push_back(at(share));
    return is_free_on_its_way(*hand.model, hand.chains, knots, hand.geometry);
  };
  EXPECT_TRUE(is_free({0, 0.5, 1.05})) << "into contact";
  EXPECT_TRUE(is_free({1.05, 0.5, 0, 0.5, 1.05})) << "out of it and back";
  EXPECT_FALSE(is_free({0, 0.5, 1.05, 0.5})) << "touches on its way";
  EXPECT_FALSE(is_free({1.05, 1.6, 1.05})) << "never free";
  EXPECT_TRUE(is_free({1.05, 1.06, 1.05})) << "stays where it is";
}

/// A ball that only goes up and down: a finger that presses from the side, off its centre, lets it slide away, a step at a time.
TEST(TryRegrasp, AcceptedOnes_HoldTheObjectForAsLongAsCommandsRest) {
  HandRegrasps hand("planar_hand_fixed_y");
  const ObjectSpace space(*hand.model);
  hand.q = (Eigen::VectorXd(6) << 0.35, 0, hand_problem().q_start.tail(4)).finished();
  const double resting_move = kRestingMove * hand.model->scales().robots().length;  // in a step, when it was taken to rest
  RegraspCounts counts;
  for (int attempt = 0; attempt < 100; ++attempt) {
    core::Random random(13, static_cast<std::uint64_t>(attempt));
    Regrasp regrasp;
    if (!hand.attempt({}, random, regrasp, counts)) continue;
    Eigen::VectorXd now = regrasp.knots.back().q;
    dynamics::StepResult result;
    hand.steps.forget();
    for (int k = 0; k < 100; ++k) {
      ASSERT_EQ(dynamics::step(*hand.model, {now, regrasp.knots.back().u}, {}, hand.steps, result), core::Status::Solved);
      EXPECT_TRUE(objects_agree(*hand.model, space, now, result.q_next, 2 * resting_move, 2 * kRestingTurn)) << attempt << ", step " << k;
      now = result.q_next;
    }
  }
  EXPECT_GT(counts.accepted, 10);
}

/// Postures promise more the later they were drawn, and the first two of those that promise most turn out in the opposite order.
TEST(TryRegrasp, Trials_TakeWhatWasSimulatedBestOfThoseThatPromiseMost) {
  HandRegrasps hand;
  hand.options.grasp_trials = 2;
  RegraspCounts counts;
  int best_taken = 0;
  for (int attempt = 0; attempt < 40; ++attempt) {
    core::Random random(12, static_cast<std::uint64_t>(attempt));
    std::vector<Eigen::VectorXd> drawn, simulated;
    const auto command = [&](std::size_t i) { return Eigen::VectorXd::Constant(4, static_cast<double>(i)); };
    GraspJudge judge;
    judge.promise = [&](const Eigen::VectorXd& q) -> Promise {
      drawn.emplace_back(q.tail(4));
      return {-static_cast<double>(drawn.size()), command(drawn.size())};
    };
    judge.simulated = [&](const Eigen::VectorXd& q, const Eigen::VectorXd& u) {
      simulated.emplace_back(q.tail(4));
      EXPECT_EQ(u, command(drawn.size() + 1 - simulated.size())) << "that of the promise";
      return -static_cast<double>(simulated.size());
    };
    Regrasp regrasp;
    const bool held = hand.attempt(judge, random, regrasp, counts);
    ASSERT_EQ(simulated.size(), std::min<std::size_t>(2, drawn.size()));
    for (std::size_t i = 0; i < simulated.size(); ++i) EXPECT_EQ(simulated[i], drawn[drawn.size() - 1 - i]);
    if (!held || simulated.size() < 2) continue;
    best_taken += (regrasp.knots.back().u - simulated[1]).norm() < 1e-9;
  }
  EXPECT_GT(counts.accepted, 10);
  EXPECT_GT(best_taken, counts.accepted * 3 / 4) << "the others had no path";
}

}  // namespace
}  // namespace stiction::planning::test
