// Forces from outside on the bodies of a plant that is driven command by command.
#include "simulation/scenes.hpp"
#include "stiction/simulation/stepped_plant.hpp"
#include "support/message_of.hpp"

namespace stiction::simulation::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;
using stiction::test::message_of;

/// A free box of 2 kg without gravity, its centre of mass beside its origin.
class PushedBox : public testing::Test {
 protected:
  std::shared_ptr<const world::Model> model = make();
  std::shared_ptr<const Plant> plant = Plant::make(model);
  int body = model->objects()[0].body;

  static std::shared_ptr<const world::Model> make() {
    world::Scene scene = empty_scene(Vector3d::Zero());
    scene.objects.push_back(solid(world::ObjectJoint::Free, world::Box{Vector3d(0.1, 0.1, 0.1)}, 2, 1));
    scene.objects[0].p_BCom = {0.05, 0, 0};
    return world::Model::make(scene);
  }

  /// The box after these pushes acted for 0.5 s from rest, and none for another 0.5 s.
  VectorXd pushed(std::span<const Push> pushes) const {
    SteppedPlant stepped(plant);
    const VectorXd none(0);
    stepped.reset(model->neutral(), none);
    stepped.set_pushes(pushes);
    EXPECT_EQ(stepped.advance(none, 0.5), Status::Solved) << stepped.message();
    stepped.set_pushes({});
    EXPECT_EQ(stepped.advance(none, 0.5), Status::Solved) << stepped.message();
    return stepped.q();
  }
};

TEST_F(PushedBox, ForceAtTheCentreOfMass_MovesItAsNewtonSays) {
  const Push push{.body = body, .p_BP = {0.05, 0, 0}, .force_W = {0, 4, 0}};
  const VectorXd q = pushed(std::array{push});
  EXPECT_NEAR(q[1], 0.5 * 2 * 0.25 + 1 * 0.5, 1e-3) << "a = F/m for half a second, then v = F t/m";
  EXPECT_NEAR((q - model->neutral()).tail<4>().norm(), 0, 1e-9) << "and does not turn it";
}

TEST_F(PushedBox, SeveralForces_AddUp) {
  const Push right{.body = body, .force_W = {0, 4, 0}}, left{.body = body, .force_W = {0, -4, 0}}, none{.body = body};
  const Push twice{.body = body, .force_W = {0, 8, 0}}, other{.body = body, .p_BP = {0, 0.1, 0.05}, .force_W = {1, 0, -2}};
  const VectorXd rest = model->neutral();
  EXPECT_EQ(pushed(std::array{right, left}), rest);
  EXPECT_GT((pushed(std::array{right, none}) - rest).norm(), 0.1) << "a push without a force is no reason to forget another";
  EXPECT_EQ(pushed(std::array{right, none}), pushed(std::array{right}));
  EXPECT_LT((pushed(std::array{right, right}) - pushed(std::array{twice})).norm(), 1e-12);
  EXPECT_GT((pushed(std::array{right, other}) - pushed(std::array{right})).norm(), 1e-2);
}

TEST_F(PushedBox, BadPushes_AreNamed) {
  SteppedPlant stepped(plant);
  const auto complaint = [&](const Push& push) { return message_of([&] { stepped.set_pushes(std::array{push}); }); };
  EXPECT_EQ(complaint({.body = 100}), "push.body: got 100, expected the index of a body, or −1 for no force");
  EXPECT_EQ(complaint({.body = body, .force_W = {0, std::nan(""), 0}}), "push: got a number that is not finite, expected finite numbers");
}

}  // namespace
}  // namespace stiction::simulation::test
