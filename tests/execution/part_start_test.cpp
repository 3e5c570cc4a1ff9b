#include "stiction/execution/closed_loop/part_start.hpp"

#include <gtest/gtest.h>

#include "planning/push_plan.hpp"
#include "stiction/contact/contact.hpp"
#include "stiction/execution/closed_loop/simulated_plant.hpp"
#include "stiction/planning/planner.hpp"

namespace stiction::execution::test {
namespace {

using Eigen::VectorXd;
using planning::test::load_model;

/// The ball of planar_pushing at −0.02 touches the box of 1 m at y = 0.5 − 0.1 …: each start says how deep it is inside.
struct Start {
  std::shared_ptr<const world::Model> model = load_model("planar_pushing");
  double gap(const VectorXd& q) const {
    world::KinematicsWorkspace work(*model);
    world::Kinematics kinematics;
    world::calc_kinematics(*model, q, work, kinematics);
    contact::Workspace contact_work(*model);
    double least = 1;
    for (int i = 0; i < static_cast<int>(model->pairs().size()); ++i)
      least = std::min(least, contact::pair_distance(*model, kinematics, i, contact_work).phi);
    return least;
  }
  VectorXd inside(double depth) const {
    VectorXd q = (VectorXd(5) << 0, 0.6, 0, 0, -0.02).finished();
    const double given = gap(q);
    q[4] += given + depth;  // the ball moves along y towards the box
    return q;
  }
  dynamics::StepOptions options() const { return planning::PlannerOptions{}.step_options(*model); }
};

TEST(PartStart, StartWithoutOverlap_StaysAsItIs) {
  const Start start;
  const VectorXd q = start.inside(-0.01);
  ASSERT_NEAR(start.gap(q), 0.01, 1e-9);
  const PartedStart parted = part_start(start.model, q, start.options());
  EXPECT_EQ(parted.q, q);
  EXPECT_EQ(parted.pair, -1);
  EXPECT_EQ(parted.overlap, 0);
}

TEST(PartStart, Overlap_IsTakenApartAndSaid) {
  const Start start;
  const VectorXd q = start.inside(0.03);
  ASSERT_NEAR(start.gap(q), -0.03, 1e-9);
  const PartedStart parted = part_start(start.model, q, start.options());
  EXPECT_NEAR(parted.overlap, 0.03, 1e-9);
  EXPECT_GE(parted.pair, 0);
  EXPECT_GT(parted.moved, 0.01);
  EXPECT_LT(parted.moved, 0.04);
  EXPECT_GT(start.gap(parted.q), -0.1 * 0.01 * 1.0) << "a tenth of what counts as contact of 1 m";
}

/// What began in the overlap is thrown; what was moved apart rests.
TEST(PartStart, PlantFromIt_HasNoEnergyOfTheOverlap) {
  const Start start;
  const VectorXd q = start.inside(0.03);
  const VectorXd parted = part_start(start.model, q, start.options()).q;
  const auto travel = [&](const VectorXd& from) {
    SimulatedPlant plant(start.model, from);
    const VectorXd u = from.tail(2);
    for (int k = 0; k < 200; ++k) EXPECT_TRUE(plant.command(u, 1e-3));
    return (plant.world().q().head(2) - from.head(2)).norm();
  };
  EXPECT_LT(travel(parted), 2e-3);
  EXPECT_GT(travel(q), 1e-2) << "the test would say nothing";
}

}  // namespace
}  // namespace stiction::execution::test
