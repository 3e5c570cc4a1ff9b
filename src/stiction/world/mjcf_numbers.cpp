#include "stiction/world/mjcf_numbers.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/number.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

bool is_finite(mjtNum x) { return std::abs(x) <= core::kLargestNumber; }
bool is_number(mjtNum x) { return !std::isnan(x); }
bool is_finite_or_none(mjtNum x) { return is_finite(x) && x >= 0; }

/// Looks through one compiled model.
class NumberChecker {
 public:
  explicit NumberChecker(const mjModel& model) : m_(model) {}

  std::vector<std::string> find() {
    look("pos and quat of the bodies", mjOBJ_BODY, m_.nbody, m_.body_pos, 3, is_finite);
    look("pos and quat of the bodies", mjOBJ_BODY, m_.nbody, m_.body_quat, 4, is_finite);
    look("mass of the bodies", mjOBJ_BODY, m_.nbody, m_.body_mass, 1, is_finite);
    look("inertia of the bodies", mjOBJ_BODY, m_.nbody, m_.body_inertia, 3, is_finite);
    look("inertia of the bodies", mjOBJ_BODY, m_.nbody, m_.body_ipos, 3, is_finite);
    look("inertia of the bodies", mjOBJ_BODY, m_.nbody, m_.body_iquat, 4, is_finite);
    look_at_joints();
    look("pos and quat of the geoms", mjOBJ_GEOM, m_.ngeom, m_.geom_pos, 3, is_finite);
    look("pos and quat of the geoms", mjOBJ_GEOM, m_.ngeom, m_.geom_quat, 4, is_finite);
    look("size of the geoms", mjOBJ_GEOM, m_.ngeom, m_.geom_size, 3, is_finite);
    look("friction of the geoms", mjOBJ_GEOM, m_.ngeom, m_.geom_friction, 3, is_finite_or_none);
    look("pos and quat of the sites", mjOBJ_SITE, m_.nsite, m_.site_pos, 3, is_finite);
    look("pos and quat of the sites", mjOBJ_SITE, m_.nsite, m_.site_quat, 4, is_finite);
    pick("gear of the actuators", mjOBJ_ACTUATOR, m_.nactuator,
         [&](int i) { return m_.actuator_outnum[i] == 0 || is_finite(m_.actuator_gear[6 * m_.actuator_outadr[i]]); });
    look("gains of the actuators", mjOBJ_ACTUATOR, m_.nactuator, m_.actuator_gainprm, mjNGAIN, is_finite);
    look("gains of the actuators", mjOBJ_ACTUATOR, m_.nactuator, m_.actuator_biasprm, mjNBIAS, is_finite);
    look("ranges of the actuators", mjOBJ_ACTUATOR, m_.nactuator, m_.actuator_forcerange, 2, is_number);
    pick("ranges of the actuators", mjOBJ_ACTUATOR, m_.nactuator, [&](int i) {
      const mjtNum* commands = m_.actuator_ctrlrange + 2 * m_.actuator_ctrladr[i];
      return m_.actuator_ctrlnum[i] == 0 || (is_number(commands[0]) && is_number(commands[1]));
    });
    look("qpos of the keyframes", mjOBJ_KEY, m_.nkey, m_.key_qpos, m_.nq, is_finite);
    if (!std::all_of(m_.opt.gravity, m_.opt.gravity + 3, is_finite)) out_.emplace_back("gravity");
    return std::move(out_);
  }

 private:
  void look_at_joints() {
    look("pos and axis of the joints", mjOBJ_JOINT, m_.njnt, m_.jnt_pos, 3, is_finite);
    look("pos and axis of the joints", mjOBJ_JOINT, m_.njnt, m_.jnt_axis, 3, is_finite);
    look("range of the joints", mjOBJ_JOINT, m_.njnt, m_.jnt_range, 2, is_number);
    look("stiffness of the joints", mjOBJ_JOINT, m_.njnt, m_.jnt_stiffness, 1, is_finite);
    pick("ref and springref of the joints", mjOBJ_JOINT, m_.njnt, [&](int j) {
      const int q = m_.jnt_qposadr[j];
      return m_.jnt_type[j] == mjJNT_FREE || (is_finite(m_.qpos0[q]) && is_finite(m_.qpos_spring[q]));
    });
    pick("damping, frictionloss and armature of the joints", mjOBJ_JOINT, m_.njnt, [&](int j) {
      const int v = m_.jnt_dofadr[j];
      return is_finite_or_none(m_.dof_damping[v]) && is_finite_or_none(m_.dof_frictionloss[v]) && is_finite_or_none(m_.dof_armature[v]);
    });
  }

  template <class Good>
  void look(std::string_view what, mjtObj type, int count, const mjtNum* numbers, int width, const Good& good) {
    pick(what, type, count, [&](int i) { return std::all_of(numbers + i * width, numbers + (i + 1) * width, good); });
  }

  /// Adds the elements that are not good. One element can have several bad numbers, and is named once for each kind.
  template <class Good>
  void pick(std::string_view what, mjtObj type, int count, const Good& good) {
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) {
      if (good(i)) continue;
      const char* name = mj_id2name(&m_, type, i);
      names.push_back(name != nullptr && *name != '\0' ? fmt::format("'{}'", name) : fmt::format("#{}", i));
    }
    if (names.empty()) return;
    const std::string entry = fmt::format("{} {}", what, list_some(names));
    if (out_.empty() || out_.back() != entry) out_.push_back(entry);
  }

  const mjModel& m_;
  std::vector<std::string> out_{};
};

}  // namespace

void require_numbers(const mjModel& model, const std::filesystem::path& file) {
  const std::vector<std::string> found = NumberChecker(model).find();
  if (found.empty()) return;
  throw core::InvalidInput(
      fmt::format("{}: mjcf: got numbers that are not finite, or negative friction or damping: {}, expected finite numbers, and friction "
                  "and damping ≥ 0",
                  file.string(), fmt::join(found, "; ")));
}

}  // namespace stiction::world
