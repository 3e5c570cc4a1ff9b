// Smoothed steps of cylinders that stand on their caps (S.17).
#include <optional>

#include "dynamics/systems.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// A body of 1 kg and 0.2 m on the ground, 1 mm above it.
class Standing {
 public:
  explicit Standing(const world::Shape& shape) {
    world::Scene scene = empty_scene();
    scene.gravity = {0, 0, -9.81};
    scene.contact_distance = 0.1;
    world::ObjectSpec object;
    object.name = "o";
    object.joint = world::ObjectJoint::Free;
    object.mass = 1;
    object.inertia = Vector3d(5.8e-3, 5.8e-3, 5e-3).asDiagonal();
    object.geometries.push_back({.name = "o", .shape = shape, .X_BG = {}, .friction = 0.5});
    scene.objects.push_back(object);
    scene.fixed.push_back(half_space(Vector3d::UnitZ(), {0, 0, 0}, 0.5));
    model_ = world::Model::make(scene);
  }

  /// Rotation after a step from a tilt by `angle` about an axis across the vertical, about that axis [rad], and its slope there at the same height.
  /// @param resting  tilt at whose height the body is; its own if there is none
  std::pair<double, double> turned(double angle, double azimuth = 0, std::optional<double> resting = {}) const {
    const Vector3d axis(std::cos(azimuth), std::sin(azimuth), 0);
    VectorXd q(7);
    const double tilt = resting.value_or(angle);
    q.head<3>() << 0, 0, 0.1 * std::cos(tilt) + 0.1 * std::abs(std::sin(tilt)) + 1e-3;
    q.tail<4>() << std::sin(angle / 2) * axis, std::cos(angle / 2);
    StepWorkspace work(model_);
    StepResult r;
    const VectorXd u(0);
    EXPECT_EQ(step(*model_, {q, u}, {.smoothing = Analytic{100}, .regularisation = FixedEpsilon{1}, .with_A = true}, work, r),
              Status::Solved);
    VectorXd from_upright(6);
    VectorXd upright = q;
    upright.tail<4>() << 0, 0, 0, 1;
    world::local(*model_, upright, r.q_next, from_upright);
    return {axis.dot(from_upright.tail<3>()), axis.dot(r.A.bottomRightCorner(3, 3) * axis)};
  }

 private:
  std::shared_ptr<const world::Model> model_;
};

TEST(SmoothedCylinder, TinyTilt_TurnsItByAsLittle) {
  const Standing cylinder(world::Cylinder{0.1, 0.1}), box(world::Box{{0.1, 0.1, 0.1}});
  for (const double azimuth : {0.0, 0.3, 1.0}) {
    const double slope = cylinder.turned(0, azimuth).second;
    for (const double angle : {1e-9, 1e-7, 1e-5, 1e-4}) {
      const double plus = cylinder.turned(angle, azimuth).first, minus = cylinder.turned(-angle, azimuth).first;
      EXPECT_NEAR((plus - minus) / (2 * angle), slope, 1e-2) << angle << " about " << azimuth;
      EXPECT_NEAR(plus + minus, 0, 1e-2 * angle) << "odd";
    }
    EXPECT_NEAR(slope, box.turned(0, azimuth).second, 0.5) << "of the same order as a box";
  }
}

TEST(SmoothedCylinder, SlopeIsThatOfTheRotation) {
  const Standing cylinder(world::Cylinder{0.1, 0.1});
  constexpr double kStep = 1e-5;
  for (const double angle : {0.02, 0.05, 0.08, 0.12, 0.2}) {
    const double slope = (cylinder.turned(angle + kStep, 0, angle).first - cylinder.turned(angle - kStep, 0, angle).first) / (2 * kStep);
    EXPECT_NEAR(cylinder.turned(angle).second, slope, 1e-3 * std::max(1.0, std::abs(slope))) << angle;
  }
}

/// There is no jump between one tilt and the next, up to where the rim alone touches.
TEST(SmoothedCylinder, RotationIsContinuousInTheTilt) {
  const Standing cylinder(world::Cylinder{0.1, 0.1});
  constexpr double kFine = 1e-3;
  double before = cylinder.turned(0).first;
  for (double angle = kFine; angle < 0.3; angle += kFine) {
    const double now = cylinder.turned(angle).first;
    EXPECT_LT(std::abs(now - before), 3 * kFine) << angle;
    before = now;
  }
  EXPECT_GT(std::abs(before), 0.05) << "it never moved: the test would say nothing";
}

}  // namespace
}  // namespace stiction::dynamics::test
