// A controller as ros2_control shapes one: an arm presses on a wall that its reference does not know. No simulator: the wall is a stiff spring.
#include <cstdio>

#include "control/arm_scene.hpp"
#include "stiction/control/controller.hpp"

using namespace stiction;

int main() {
  const auto model = control::test::make_arm();
  const int link = control::test::find_body(*model, "arm/link_7");
  control::ContactController controller(model, {.lambda_max = 15, .force_threshold = 5});

  const double dt = 0.005, wall_y = 0.02, wall_stiffness = 2e4;  // [s], [m], [N/m]
  Eigen::VectorXd q = control::test::posture(), q_ref = q, q_cmd = q;
  controller.configure(q);
  world::KinematicsWorkspace work(*model);
  world::Kinematics kinematics;
  double force = 0;

  for (int tick = 0; tick < 1000; ++tick) {
    // What a robot reports: joint positions, and a force on its last link.
    calc_kinematics(*model, q, work, kinematics);
    const Eigen::Vector3d p = kinematics.X_WB[static_cast<std::size_t>(link)].p;
    force = std::max(0.0, wall_stiffness * (p.y() - wall_y));
    const control::ContactForce contact{.id = 0, .body = link, .p_WC = p, .force_W = Eigen::Vector3d(0, -force, 0)};

    // The reference turns the base by 0.3 rad in 3 s: through the wall.
    q_ref[0] = 0.3 * std::min(1.0, tick * dt / 3);
    const auto& command = controller.update({.time = tick * dt, .q = q, .q_ref = q_ref, .contacts = {&contact, 1}}, dt);
    if (command.status != core::Status::Solved) return 1;
    q_cmd = command.q_cmd;

    // The robot: K (q_cmd − q) + Jᵀ f = 0 is approached in a few ticks. Row y of J is axis × (p − origin).
    for (int j = 0; j < model->n_a(); ++j) {
      const double lever = kinematics.axis_W.col(j).cross(p - kinematics.origin_W.col(j)).y(), K = model->stiffness()[j];
      q[j] += 0.05 * (q_cmd[j] - q[j] - lever * force / K);
    }
  }
  std::printf("the reference is %.0f mm behind the wall, the force is %.2f N\n", 1e3 * (0.3 * 0.6 - wall_y), force);
  return force > 14 && force < 15.5 ? 0 : 1;
}
