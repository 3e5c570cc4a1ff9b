// Grippers that take hold of a free object.
#include "stiction/contact/pinch.hpp"

#include <gtest/gtest.h>

#include "stiction/contact/contact_sampler.hpp"
#include "stiction/world/scales.hpp"
#include "world/gripper.hpp"

namespace stiction::contact {
namespace {

constexpr double kStiffness = 400;
constexpr int kDraws = 100;

struct Gripper : world::test::RobotFolder {
  explicit Gripper(double mass, double command = 0) : model(world::test::make_gripper(*this, mass, 0.05, command)) {}

  /// Of kDraws samples with all branches the postures in which a part of either finger touches, with their commands.
  std::vector<ContactSample> draw_pinches() {
    const Eigen::VectorXd q = world::test::gripper_start(*model);
    GenericSampler sampler;
    sampler.pinch_probability = 1;
    core::Random random(5, 0);
    std::vector<ContactSample> out;
    for (int k = 0; k < kDraws; ++k) {
      auto sample = sample_contact(*model, chains, sampler, chains.all(), q, random, work);
      if (sample && touches(sample->q_a, 5) && touches(sample->q_a, 6)) out.push_back(std::move(*sample));
    }
    return out;
  }
  double gap(int pair, const Eigen::VectorXd& q_a) {
    Eigen::VectorXd q = world::test::gripper_start(*model);
    q.tail(7) = q_a;
    world::calc_kinematics(*model, q, work.kinematics_work, work.kinematics);
    return pair_distance(*model, work.kinematics, pair, work.contact_work).phi;
  }
  bool touches(const Eigen::VectorXd& q_a, int finger) {
    const double touching = 0.11 * world::share::kContact * model->scales().robots().length;
    return std::ranges::any_of(model->pairs(), [&](const world::Pair& pair) {
      const int i = static_cast<int>(&pair - model->pairs().data());
      const auto& dofs =
          model->bodies()[static_cast<std::size_t>(model->geometries()[static_cast<std::size_t>(pair.geometry_b)].body)].dofs;
      return chains.touches_object(i) && !dofs.empty() && dofs.back() == model->n_vu() + finger && gap(i, q_a) < touching;
    });
  }

  std::shared_ptr<const world::Model> model;
  world::RobotChains chains{*model};
  GeometryWorkspace work{*model};
};

/// The springs of both fingers give the same force, and nothing else is strained: five times the weight, or all that is left of the strokes. A part of it goes
/// into the fingers where the line between them is not along their strokes.
TEST(HoldPinch, PressesAsTheWeightNeedsAndTheStrokesAllow) {
  for (const double mass : {0.1, 0.5}) {
    Gripper gripper(mass);
    const double weight = 10 * mass;
    const auto pinches = gripper.draw_pinches();
    ASSERT_GT(pinches.size(), 20u);
    double difference = 0;
    for (const ContactSample& pinch : pinches) {
      const Eigen::VectorXd force = kStiffness * (pinch.u - pinch.q_a);
      const double most = std::min(5 * weight, kStiffness * (0.05 - std::max(pinch.q_a[5], pinch.q_a[6])));
      EXPECT_LE(force[5], most + 1e-6);
      EXPECT_GE(force[5], 0.9 * most);
      EXPECT_NEAR(force[6], force[5], 1e-6);
      EXPECT_LT((pinch.u - pinch.q_a).head(5).norm(), 1e-9);
      difference += std::abs(pinch.q_a[5] - pinch.q_a[6]) / static_cast<double>(pinches.size());
    }
    EXPECT_LT(difference, 0.1 * 0.05) << "as much is left to one finger as to the other";
  }
}

/// Commands of 1 m press as hard as five times the weight, where strokes of 50 mm would not hold the object.
TEST(HoldPinch, CommandsBeyondTheStrokePressAsTheWeightNeeds) {
  Gripper gripper(6, 1);
  int pressed = 0;
  for (const ContactSample& pinch : gripper.draw_pinches()) {
    if (pinch.u == pinch.q_a) continue;
    ++pressed;
    EXPECT_NEAR(kStiffness * (pinch.u - pinch.q_a)[5], 300, 30);
    EXPECT_LT(pinch.q_a[5], 0.05 + 1e-9);
  }
  EXPECT_GT(pressed, 20);
}

/// 30 N at each finger would be needed, and strokes of 50 mm give less than 20 N.
TEST(HoldPinch, WhatIsTooHeavyIsNotPressed) {
  Gripper gripper(6);
  for (const ContactSample& pinch : gripper.draw_pinches()) EXPECT_EQ(pinch.u, pinch.q_a);
}

/// Of all postures of the hand half are below the ground, and fingers around a cube of 40 mm reach into it unless the hand gives way.
TEST(DrawPinch, HandsKeepClearOfTheGround) {
  Gripper gripper(0.1);
  const auto pinches = gripper.draw_pinches();
  EXPECT_GT(pinches.size(), 40u) << "of " << kDraws;
  std::vector<int> pairs;
  gripper.chains.pairs_of(gripper.chains.all(), pairs);
  const double tolerance = world::share::kContact * gripper.model->scales().robots().length;
  for (const ContactSample& pinch : pinches) {
    for (const int i : pairs) EXPECT_GT(gripper.gap(i, pinch.q_a), gripper.chains.touches_object(i) ? -0.11 * tolerance : 0.0);
  }
}

}  // namespace
}  // namespace stiction::contact
