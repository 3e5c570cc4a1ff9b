#include "stiction/execution/open_loop/firm_grip.hpp"

#include <gtest/gtest.h>

#include "stiction/world/read.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution::test {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// A gripper whose fingers slide along x, on a slider along z, and a cube of 0.1 m and 0.2 kg between them.
class FirmGrip : public testing::Test {
 protected:
  FirmGrip() {
    trajectory_.u.resize(3, 4);
    trajectory_.q.resize(model_->n_q(), 4);
    set(0, 0.05, 0);    // on the ground
    set(1, 0.2, 1e-4);  // aloft, each finger pressing with 0.1 N
    set(2, 0.3, 0.02);  // with 20 N
    set(3, 0.4, 0);     // aloft without a grip
  }

  /// Knot k: the cube at height z, both fingers at its sides, their commands `strain` further in.
  void set(int k, double z, double strain) {
    VectorXd q = model_->neutral();
    q.head<3>() << 0, 0, z;
    q.tail<3>() << z, 0.06, -0.06;
    trajectory_.q.col(k) = q;
    trajectory_.u.col(k) = q.tail<3>() + Vector3d(0.1 * strain, -strain, strain);
  }

  Vector3d strain(int k) const { return trajectory_.u.col(k) - trajectory_.q.col(k).tail<3>(); }

  std::shared_ptr<const world::Model> model_ =
      world::Model::make(world::parse_scene("gravity: [0, 0, -9.81]\n"
                                            "robots: [{name: r, mjcf: \"<mujoco><worldbody><body><joint name='z' type='slide' axis='0 0 1' "
                                            "range='-2 2'/><inertial mass='1' pos='0 0 0' "
                                            "diaginertia='1 1 1'/><body><joint name='right' type='slide' axis='1 0 0' range='-0.1 "
                                            "0.1'/><geom type='box' size='.01 .02 .02' mass='1'/></body>"
                                            "<body><joint name='left' type='slide' axis='1 0 0' range='-0.1 0.1'/><geom type='box' "
                                            "size='.01 .02 .02' mass='1'/></body></body></worldbody>"
                                            "<actuator><position joint='z' kp='1000'/><position joint='right' kp='1000'/><position "
                                            "joint='left' kp='1000'/></actuator></mujoco>\"}]\n"
                                            "objects: [{name: cube, joint: free, mass: 0.2, shapes: [{box: {size: [0.1, 0.1, 0.1]}}]}]\n"
                                            "fixed: [{name: ground, shapes: [{half_space: {}}]}]\n",
                                            "."));
  Trajectory trajectory_;
};

TEST_F(FirmGrip, HoldsWhatIsAloftWithFiveWeights) {
  const std::vector<char> carried = find_carried(*model_, trajectory_);
  EXPECT_EQ(carried, (std::vector<char>{0, 1, 1, 1}));
  const Trajectory before = trajectory_;
  tighten_grips(*model_, carried, trajectory_);
  const double five_weights = 5 * 0.2 * 9.81;
  EXPECT_NEAR(1000 * strain(1).cwiseAbs().maxCoeff(), five_weights, 1e-9);
  EXPECT_LT(strain(1).normalized().cross(Vector3d(0.1, -1, 1).normalized()).norm(), 1e-9) << "forces keep their directions";
  for (const int k : {0, 2, 3}) EXPECT_EQ(trajectory_.u.col(k), before.u.col(k)) << "knot " << k << ": on the ground, firm, or no grip";
}

/// The push that lifts the cube grips it before it leaves the ground, and a push before it does not.
TEST_F(FirmGrip, BeginsWithThePushThatLifts) {
  set(1, 0.05, 1e-4);
  trajectory_.pieces = {{.kind = planning::SegmentKind::Contact, .first_knot = 0, .last_knot = 0},
                        {.kind = planning::SegmentKind::Contact, .first_knot = 1, .last_knot = 2},
                        {.kind = planning::SegmentKind::Regrasp, .first_knot = 2, .last_knot = 3}};
  const std::vector<char> carried = find_carried(*model_, trajectory_);
  EXPECT_EQ(carried, (std::vector<char>{0, 1, 1, 1}));
  tighten_grips(*model_, carried, trajectory_);
  EXPECT_NEAR(1000 * strain(1).cwiseAbs().maxCoeff(), 5 * 0.2 * 9.81, 1e-9);
  EXPECT_EQ(strain(0), Vector3d::Zero());
}

TEST_F(FirmGrip, CommandsStayWithinTheirRange) {
  trajectory_.q.col(1).tail<2>() << -0.0995, 0.0995;
  trajectory_.u.col(1).tail<2>() << -0.0996, 0.0996;
  tighten_grips(*model_, find_carried(*model_, trajectory_), trajectory_);
  EXPECT_EQ(trajectory_.u(1, 1), -0.1);
  EXPECT_EQ(trajectory_.u(2, 1), 0.1);
}

}  // namespace
}  // namespace stiction::execution::test
