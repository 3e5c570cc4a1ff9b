#include <fmt/format.h>

#include "stiction/core/invalid_input.hpp"
#include "stiction/simulation/plant_impl.hpp"

namespace stiction::simulation {

void require_pushes(const world::Model& model, std::span<const Push> pushes) {
  for (const Push& push : pushes) {
    if (push.body >= static_cast<int>(model.bodies().size()))
      core::throw_invalid("push.body", fmt::format("{}", push.body), "the index of a body, or −1 for no force");
    if (!push.p_BP.allFinite() || !push.force_W.allFinite()) core::throw_invalid("push", "a number that is not finite", "finite numbers");
  }
}

void apply_pushes(const Plant::Impl& plant, std::span<const Push> pushes, mjData* data) {
  const mjModel* m = plant.mujoco.get();
  mju_zero(data->qfrc_applied, m->nv);
  for (const Push& push : pushes) {
    if (push.body < 0) continue;
    const int body = plant.body_id[static_cast<std::size_t>(push.body)];
    mjtNum point[3];
    mju_mulMatVec3(point, data->xmat + 9 * body, push.p_BP.data());
    mju_addTo3(point, data->xpos + 3 * body);
    const mjtNum no_torque[3] = {0, 0, 0};
    mj_applyFT(m, data, push.force_W.data(), no_torque, point, body, data->qfrc_applied);  // adds
  }
}

}  // namespace stiction::simulation
