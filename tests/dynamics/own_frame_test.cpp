// A free object may have its frame anywhere: the step moves it as it moves the same object with the frame at its centre of mass.
#include "dynamics/systems.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// An L of two boxes on the ground, beside a finger; its frame is moved by `shift` in its own axes.
std::shared_ptr<const world::Model> make(const Vector3d& shift) {
  world::Scene scene = empty_scene();
  scene.gravity = {0, 0, -9.81};
  scene.contact_distance = 0.05;
  world::ObjectSpec object;
  object.name = "angle";
  object.joint = world::ObjectJoint::Free;
  object.mass = 0.4;
  for (const auto& [name, half, at] : {std::tuple("long", Vector3d(0.06, 0.02, 0.02), Vector3d(0.02, 0, 0)),
                                       std::tuple("short", Vector3d(0.02, 0.03, 0.02), Vector3d(-0.02, 0.05, 0))}) {
    world::GeometrySpec part{.name = name, .shape = world::Box{half}, .X_BG = {}, .friction = 0.6};
    part.X_BG.p = at + shift;
    object.geometries.push_back(part);
  }
  const world::VolumeProperties solid = world::calc_volume_properties(object.geometries);
  object.p_BCom = solid.center;
  object.inertia = object.mass / solid.volume * solid.inertia;
  scene.objects = {object};
  scene.robots = {pusher()};
  scene.robots[0].X_WBase.p = {0.1, 0, 0.1};
  scene.fixed.push_back(half_space(Vector3d::UnitZ(), Vector3d::Zero(), 0.5));
  return world::Model::make(scene);
}

struct Moved {
  Vector3d com, turned;  // of the centre of mass, to first order in the step, and of the body [m, rad]
  std::vector<Vector3d> lambda;
};

Moved step_of(const Vector3d& shift, const StepOptions& options) {
  const auto model = make(shift);
  const Vector3d c = model->scene().objects[0].p_BCom;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.3, Vector3d(0.02, 0.01, 1).normalized()));
  VectorXd q = model->neutral(), u(2);
  q.head<3>() = Vector3d(0, 0.17, 0.0215) - turn * shift;
  q.segment<4>(3) = turn.coeffs();
  q.tail(2) << 0.02, 0;
  u << 0.05, -0.01;
  StepWorkspace work(model);
  StepResult r;
  EXPECT_EQ(step(*model, {q, u}, options, work, r), Status::Solved);
  Moved out{r.delta.head<3>() + turn * Vector3d(r.delta.segment<3>(3)).cross(c), r.delta.segment<3>(3), {}};
  for (const auto& contact : r.contacts) out.lambda.push_back(contact.lambda);
  return out;
}

TEST(OwnFrame, StepOfTheSameObject_HasTheSameForcesAndMotion) {
  for (const bool smoothed : {false, true}) {
    StepOptions options;
    if (smoothed) options.smoothing = Analytic{500};
    const Moved there = step_of(-make(Vector3d::Zero())->scene().objects[0].p_BCom, options);  // the frame at the centre of mass
    double pushed = 0;
    for (const auto& lambda : there.lambda) pushed = std::max(pushed, std::hypot(lambda[1], lambda[2]));
    ASSERT_GT(pushed, 1e-3) << "nothing pushes: the test would say nothing";
    for (const Vector3d& shift : {Vector3d(0, 0, 0), Vector3d(0.3, -0.1, 0.2)}) {
      const Moved here = step_of(shift, options);
      ASSERT_EQ(here.lambda.size(), there.lambda.size());
      EXPECT_NEAR((here.com - there.com).norm(), 0, 1e-7) << smoothed;
      EXPECT_NEAR((here.turned - there.turned).norm(), 0, 1e-6) << smoothed;
      for (std::size_t i = 0; i < here.lambda.size() && smoothed; ++i)  // exact: four corners share the weight in many ways
        EXPECT_NEAR((here.lambda[i] - there.lambda[i]).norm(), 0, 1e-6 * 0.4 * 9.81 * 0.1) << i;
    }
  }
}

}  // namespace
}  // namespace stiction::dynamics::test
