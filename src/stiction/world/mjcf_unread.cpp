#include "stiction/world/mjcf_unread.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "stiction/world/mjcf_view.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

/// Looks through one compiled model.
class UnreadFinder {
 public:
  UnreadFinder(const mjModel& model, const std::function<bool(int)>& is_robot) : m_(model), is_robot_(is_robot) {
    mj_defaultSolRefImp(solref_.data(), solimp_.data());
  }

  std::vector<std::string> find() {
    look_at_geoms();
    look_at_pairs();
    look_at_joints();
    look_at_servos();
    look_at_options();
    return std::move(out_);
  }

 private:
  std::string name(mjtObj type, int id) const {
    const char* given = mj_id2name(&m_, type, id);
    return given != nullptr && *given != '\0' ? given : fmt::format("#{}", id);
  }

  /// Adds an entry if the attribute of an element has an effect. @param changes  effect of ignoring the attribute
  template <class Has>
  void look(std::string_view attribute, std::string_view elements, mjtObj type, int count, std::string_view changes, const Has& has) {
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) {
      if (has(i)) names.push_back(name(type, i));
    }
    if (!names.empty()) out_.push_back(fmt::format("{} of {} {} ({})", attribute, elements, list_some(names), changes));
  }

  bool is_soft(const mjtNum* solref, const mjtNum* solimp) const {
    return !std::equal(solref_.begin(), solref_.end(), solref) || !std::equal(solimp_.begin(), solimp_.end(), solimp);
  }

  void look_at_geoms() {
    const auto look_at = [&](std::string_view attribute, std::string_view changes, const auto& has) {
      look(attribute, "geoms", mjOBJ_GEOM, m_.ngeom, changes,
           [&](int g) { return (m_.geom_contype[g] | m_.geom_conaffinity[g]) != 0 && has(g); });
    };
    look_at("margin", "contact begins at the surface, so that things rest that much nearer to each other",
            [&](int g) { return m_.geom_margin[g] != 0; });
    look_at("gap", "contact_distance of the scene says from where on contacts are looked at", [&](int g) { return m_.geom_gap[g] != 0; });
    look_at("condim 6", "contacts resist rolling in simulation, but plans do without", [&](int g) { return m_.geom_condim[g] > 4; });
    look_at("solmix, solref, solimp", "contacts are rigid",
            [&](int g) { return m_.geom_solmix[g] != 1 || is_soft(m_.geom_solref + mjNREF * g, m_.geom_solimp + mjNIMP * g); });
  }

  void look_at_pairs() {
    look("friction along a second direction", "contact pairs", mjOBJ_PAIR, m_.npair, "that along the first one counts in all", [&](int i) {
      const mjtNum* friction = m_.pair_friction + 5 * i;
      return (m_.pair_dim[i] > 1 && friction[0] != friction[1]) || (m_.pair_dim[i] == 6 && friction[3] != friction[4]);
    });
  }

  void look_at_joints() {
    const auto look_at = [&](std::string_view attribute, std::string_view changes, const auto& has) {
      look(attribute, "joints", mjOBJ_JOINT, m_.njnt, changes, has);
    };
    const auto is_free = [&](int j) { return m_.jnt_type[j] == mjJNT_FREE; };
    look_at("armature", "objects have the inertia of their bodies alone",
            [&](int j) { return !is_robot_(j) && m_.dof_armature[m_.jnt_dofadr[j]] != 0; });
    look_at("frictionloss", "free objects move without", [&](int j) { return is_free(j) && m_.dof_frictionloss[m_.jnt_dofadr[j]] != 0; });
    look_at("damping of higher order", "damping is linear", [&](int j) {
      const mjtNum* terms = m_.dof_dampingpoly + mjNPOLY * m_.jnt_dofadr[j];
      return std::any_of(terms, terms + mjNPOLY, [](mjtNum d) { return d != 0; });
    });
    look_at("margin", "limits begin at the range", [&](int j) { return m_.jnt_margin[j] != 0; });
    look_at("solreflimit, solimplimit, solreffriction, solimpfriction", "limits and friction are rigid", [&](int j) {
      const int dof = m_.jnt_dofadr[j];
      return is_soft(m_.jnt_solref + mjNREF * j, m_.jnt_solimp + mjNIMP * j) ||
             is_soft(m_.dof_solref + mjNREF * dof, m_.dof_solimp + mjNIMP * dof);
    });
    look("solref, solimp", "equalities", mjOBJ_EQUALITY, m_.neq, "joints follow each other exactly", [&](int i) {
      return m_.eq_active0[i] && m_.eq_type[i] == mjEQ_JOINT && is_soft(m_.eq_solref + mjNREF * i, m_.eq_solimp + mjNIMP * i);
    });
    look("damping, frictionloss", "tendons", mjOBJ_TENDON, m_.ntendon, "tendons hold nothing",
         [&](int i) { return m_.tendon_damping[i] != 0 || m_.tendon_frictionloss[i] != 0; });
  }

  bool is_on_joint(int actuator) const {
    return m_.actuator_trntype[actuator] == mjTRN_JOINT || m_.actuator_trntype[actuator] == mjTRN_JOINTINPARENT;
  }
  /// True if the commands of a servo cannot move its joint through its whole range.
  bool has_narrow_commands(int i) const {
    const int joint = m_.actuator_trnid[2 * i];
    const auto positions = is_on_joint(i) ? commanded_positions(m_, i) : std::nullopt;
    if (!positions) return false;
    if (!m_.jnt_limited[joint]) return true;
    const auto [low, high] = *positions;
    const double rounding = 1e-6 * (m_.jnt_range[2 * joint + 1] - m_.jnt_range[2 * joint]);
    return low > m_.jnt_range[2 * joint] + rounding || high < m_.jnt_range[2 * joint + 1] - rounding;
  }

  void look_at_servos() {
    const auto look_at = [&](std::string_view attribute, std::string_view changes, const auto& has) {
      look(attribute, "actuators", mjOBJ_ACTUATOR, m_.nactuator, changes, [&](int i) { return is_on_joint(i) && has(i); });
    };
    look_at("ctrlrange", "commands may be anywhere in the range of the joint", [&](int i) { return has_narrow_commands(i); });
    look_at("damping", "motors do without", [&](int i) { return m_.actuator_damping[i] != 0; });
    look_at("dyntype and delay", "joints feel commands at once",
            [&](int i) { return m_.actuator_dyntype[i] != mjDYN_NONE || m_.actuator_delay[i] != 0; });
    look_at("gaintype and biastype", "motors give any force within their range", [&](int i) {
      return m_.actuator_gaintype[i] != mjGAIN_FIXED ||
             (m_.actuator_biastype[i] != mjBIAS_NONE && m_.actuator_biastype[i] != mjBIAS_AFFINE);
    });
  }

  void look_at_options() {
    mjOption usual;
    mj_defaultOption(&usual);
    const mjOption& opt = m_.opt;
    if (!std::equal(opt.gravity, opt.gravity + 3, usual.gravity))
      out_.push_back(fmt::format("option gravity {:g} {:g} {:g} (that of the scene counts, which is [0, 0, -9.81] where it says none)",
                                 opt.gravity[0], opt.gravity[1], opt.gravity[2]));
    if (opt.density != 0 || opt.viscosity != 0 || std::any_of(opt.wind, opt.wind + 3, [](mjtNum w) { return w != 0; }))
      out_.emplace_back("option wind, density, viscosity (nothing flows)");
    if ((opt.enableflags & mjENBL_OVERRIDE) != 0) out_.emplace_back("flag override (each geom has its own friction)");
    constexpr struct {
      int flag;
      std::string_view name;
    } kFlags[] = {{mjDSBL_CONSTRAINT, "constraint"}, {mjDSBL_EQUALITY, "equality"},         {mjDSBL_FRICTIONLOSS, "frictionloss"},
                  {mjDSBL_LIMIT, "limit"},           {mjDSBL_CONTACT, "contact"},           {mjDSBL_DAMPER, "damper"},
                  {mjDSBL_GRAVITY, "gravity"},       {mjDSBL_FILTERPARENT, "filterparent"}, {mjDSBL_ACTUATION, "actuation"}};
    std::vector<std::string> names;
    for (const auto& [flag, flag_name] : kFlags) {
      if ((opt.disableflags & flag) != 0) names.emplace_back(flag_name);
    }
    if (!names.empty()) out_.push_back(fmt::format("flags that switch off {} (these act)", list_some(names)));
    if (opt.disableactuator != 0) out_.emplace_back("option actuatorgroupdisable (all actuators act)");
  }

  const mjModel& m_;
  const std::function<bool(int)>& is_robot_;
  std::array<mjtNum, mjNREF> solref_{};
  std::array<mjtNum, mjNIMP> solimp_{};
  std::vector<std::string> out_{};
};

}  // namespace

std::vector<std::string> list_unread(const mjModel& model, const std::function<bool(int joint)>& is_robot) {
  return UnreadFinder(model, is_robot).find();
}

}  // namespace stiction::world
