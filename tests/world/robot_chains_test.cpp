#include "stiction/world/robot_chains.hpp"

#include "world/test_scenes.hpp"

namespace stiction::world::test {
namespace {

TEST(RobotChains, Allegro_HasFourFingersAndAllPairs) {
  const auto model = load_task("allegro_ball");
  const RobotChains chains(*model);
  ASSERT_EQ(chains.size(), 4);
  std::size_t with_object = 0;
  for (int c = 0; c < 4; ++c) {
    EXPECT_EQ(chains.joints(c).size(), 4u);
    with_object += chains.object_pairs(c).size();
  }
  EXPECT_EQ(with_object, 18u);  // the palm's pair moves with no finger
}

}  // namespace
}  // namespace stiction::world::test
