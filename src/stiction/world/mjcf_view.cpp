#include "stiction/world/mjcf_view.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/ellipsoid.hpp"

namespace stiction::world {
namespace {

bool has_spring(const mjtNum* linear, const mjtNum* higher, int i) {
  return linear[i] != 0 || std::any_of(higher + i * mjNPOLY, higher + (i + 1) * mjNPOLY, [](mjtNum k) { return k != 0; });
}

}  // namespace

MjcfView::MjcfView(const mjModel* m, const MjcfRoles& roles, const std::filesystem::path& file) : m_(m), roles_(roles), file_(file) {
  paired_.assign(static_cast<std::size_t>(m_->ngeom), false);
  for (int i = 0; i < m_->npair; ++i) {
    pair_read_.push_back(!is_kept_apart(i));
    for (const int geom : {m_->pair_geom1[i], m_->pair_geom2[i]}) {
      if (pair_read_.back()) paired_[static_cast<std::size_t>(geom)] = true;
    }
  }
}

bool MjcfView::is_kept_apart(int pair) const {
  const int one = m_->geom_bodyid[m_->pair_geom1[pair]], other = m_->geom_bodyid[m_->pair_geom2[pair]];
  for (int i = 0; i < m_->nexclude; ++i) {
    const int a = m_->exclude_signature[i] >> 16, b = m_->exclude_signature[i] & 0xffff;
    if ((a == one && b == other) || (a == other && b == one)) return true;
  }
  const int a = m_->body_weldid[one], b = m_->body_weldid[other];
  const auto hangs_on = [&](int below, int above) {
    return below != 0 && !is_on_free_body(below) && m_->body_weldid[m_->body_parentid[below]] == above;
  };
  return a == b || hangs_on(a, b) || hangs_on(b, a);
}

std::string MjcfView::given_name(mjtObj type, int id) const {
  const char* name = mj_id2name(m_, type, id);
  return name != nullptr ? name : "";
}

std::string MjcfView::describe(std::string_view element, mjtObj type, int id) const {
  const std::string name = given_name(type, id);
  return name.empty() ? fmt::format("{} {}", element, id) : fmt::format("{} '{}'", element, name);
}

std::optional<Shape> MjcfView::read_primitive(int geom) const {
  const mjtNum* size = m_->geom_size + 3 * geom;
  switch (m_->geom_type[geom]) {
    case mjGEOM_PLANE:
      return HalfSpace{};
    case mjGEOM_SPHERE:
      return Sphere{size[0]};
    case mjGEOM_CAPSULE:
      return Capsule{size[0], size[1]};
    case mjGEOM_CYLINDER:
      return Cylinder{size[0], size[1]};
    case mjGEOM_BOX:
      return Box{Eigen::Vector3d(size[0], size[1], size[2])};
    case mjGEOM_ELLIPSOID:
      return Mesh{std::make_shared<const ConvexMesh>(make_ellipsoid(Eigen::Vector3d(size[0], size[1], size[2])))};
    default:
      return std::nullopt;
  }
}

void MjcfView::require_supported() const {
  std::vector<std::string> faults;
  const auto refuse = [&](std::string_view element, mjtObj type, int id, std::string_view reason) {
    faults.push_back(fmt::format("{} ({})", describe(element, type, id), reason));
  };
  for (int b = 1; b < m_->nbody; ++b) {
    if (m_->body_mocapid[b] >= 0 && has_at_or_below(b, [&](int c) { return m_->body_jntnum[c] > 0; }))
      refuse("body", mjOBJ_BODY, b, "a mocap body that carries joints");
    const bool robot = !roles_.joints_of(b).empty() && roles_.of_body(b) == MjcfRole::Robot;
    if (robot && is_on_free_body(m_->body_parentid[b]))
      refuse("body", mjOBJ_BODY, b, "a joint on a body with a free joint; fixed_base: true makes that stand still");
  }
  for (int g = 0; g < m_->ngeom; ++g) {
    if (!collides(g)) continue;  // only seen
    if (m_->geom_type[g] == mjGEOM_HFIELD) refuse("geom", mjOBJ_GEOM, g, "a height field");
    if (m_->geom_type[g] == mjGEOM_SDF) refuse("geom", mjOBJ_GEOM, g, "a signed distance field");
  }
  for (int i = 0; i < m_->nflex; ++i) refuse("flex", mjOBJ_FLEX, i, "a deformable body");
  if (faults.empty()) return;
  throw core::InvalidInput(
      fmt::format("{}: mjcf: got {} unsupported element{}: {}, expected hinge, slide, ball and free joints; sphere, capsule, box, "
                  "cylinder, ellipsoid, plane and mesh geoms",
                  file_.string(), faults.size(), faults.size() == 1 ? "" : "s", fmt::join(faults, "; ")));
}

std::vector<std::string> MjcfView::list_passed_over(const MjcfMeaning& read) const {
  std::vector<std::string> names;
  const auto pass = [&](std::string_view element, mjtObj type, int id, std::string_view reason) {
    names.push_back(fmt::format("{} ({})", describe(element, type, id), reason));
  };
  for (int b = 1; b < m_->nbody; ++b) {
    if (roles_.is_object(b) && roles_.top(b) == b && !object_collides(b)) {
      const bool free = is_free(m_->body_jntadr[b]);
      pass("body", mjOBJ_BODY, b, free ? "a free joint and no geom that collides" : "joints without a motor and no geom that collides");
    }
  }
  for (int b = 1; b < m_->nbody; ++b) {
    if (m_->body_mocapid[b] >= 0 && has_at_or_below(b, [&](int c) { return has_colliding_geom(c); }))
      pass("body", mjOBJ_BODY, b, "a mocap body that collides, which stands still here");
  }
  for (int j = 0; j < m_->njnt; ++j) {
    if (const std::string reason = describe_spring(j); !reason.empty()) pass("joint", mjOBJ_JOINT, j, reason);
    if (is_ball(j) && m_->jnt_limited[j] && roles_.moves(j)) pass("joint", mjOBJ_JOINT, j, "a limit of a ball joint");
  }
  for (int g = 0; g < m_->ngeom; ++g) {
    const mjtNum* velocity = m_->geom_surfacevel + 6 * g;
    if (std::any_of(velocity, velocity + 6, [](mjtNum v) { return v != 0; })) pass("geom", mjOBJ_GEOM, g, "a moving surface");
    if (collides(g) && m_->geom_adhesion[g] != 0) pass("geom", mjOBJ_GEOM, g, "an adhesive surface");
  }
  for (int i = 0; i < m_->neq; ++i) {
    if (m_->eq_active0[i] && !read.equality[static_cast<std::size_t>(i)])
      pass("equality", mjOBJ_EQUALITY, i, "a constraint beside joints and contacts");
  }
  for (int i = 0; i < m_->ntendon; ++i) {  // a tendon without spring or limit only measures
    const auto tendon = static_cast<std::size_t>(i);
    if (has_spring(m_->tendon_stiffness, m_->tendon_stiffnesspoly, i) && !read.tendon_spring[tendon])
      pass("tendon", mjOBJ_TENDON, i, "a tendon with a spring");
    if (m_->tendon_limited[i] && !read.tendon_limit[tendon]) pass("tendon", mjOBJ_TENDON, i, "a tendon with a limit");
  }
  for (int i = 0; i < m_->npair; ++i) {
    if (!pair_read_[static_cast<std::size_t>(i)])
      pass("pair", mjOBJ_PAIR, i, "a contact pair of bodies that are excluded or that a joint links");
  }
  for (int i = 0; i < m_->nplugin; ++i) pass("plugin", mjOBJ_PLUGIN, i, "a plugin");
  for (int i = 0; i < m_->nactuator; ++i) {
    if (drives_joints(i)) continue;
    if (!is_on_joint(i))
      pass("actuator", mjOBJ_ACTUATOR, i, "not on a joint");
    else if (is_free(m_->actuator_trnid[2 * i]))
      pass("actuator", mjOBJ_ACTUATOR, i, "on a free joint");
    else if (roles_.of_joint(m_->actuator_trnid[2 * i]) == MjcfRole::Object)
      pass("actuator", mjOBJ_ACTUATOR, i, "on the joint of an object");
  }
  return names;
}

bool MjcfView::has_linear_spring(int joint) const {
  const mjtNum* higher = m_->jnt_stiffnesspoly + joint * mjNPOLY;
  return m_->jnt_stiffness[joint] > 0 && slides_or_turns(joint) && std::all_of(higher, higher + mjNPOLY, [](mjtNum k) { return k == 0; });
}

std::string MjcfView::describe_spring(int joint) const {
  if (!has_spring(m_->jnt_stiffness, m_->jnt_stiffnesspoly, joint) || !roles_.moves(joint)) return "";
  if (has_linear_spring(joint)) return "";
  return slides_or_turns(joint) ? "a passive spring that is not linear" : "a passive spring of a ball or a free joint";
}

bool is_position_servo(const mjModel& m, int actuator) {
  return m.actuator_gaintype[actuator] == mjGAIN_FIXED && m.actuator_biastype[actuator] == mjBIAS_AFFINE &&
         m.actuator_dyntype[actuator] != mjDYN_INTEGRATOR && m.actuator_gainprm[mjNGAIN * actuator] != 0 &&
         m.actuator_biasprm[mjNBIAS * actuator + 1] < 0;
}

std::optional<std::pair<double, double>> commanded_positions(const mjModel& m, int actuator) {
  if (!is_position_servo(m, actuator) || !m.actuator_ctrllimited[m.actuator_ctrladr[actuator]]) return std::nullopt;
  const mjtNum *commands = m.actuator_ctrlrange + 2 * m.actuator_ctrladr[actuator], *gain = m.actuator_gainprm + mjNGAIN * actuator,
               *bias = m.actuator_biasprm + mjNBIAS * actuator;
  const double gear = m.actuator_gear[6 * m.actuator_outadr[actuator]];
  if (gear == 0) return std::nullopt;
  const auto position = [&](double command) { return -(gain[0] * command + bias[0]) / (bias[1] * gear); };
  return std::minmax({position(commands[0]), position(commands[1])});
}

bool MjcfView::is_on_joint(int actuator) const {
  return m_->actuator_trntype[actuator] == mjTRN_JOINT || m_->actuator_trntype[actuator] == mjTRN_JOINTINPARENT;
}

bool MjcfView::has_colliding_geom(int body) const {
  const int begin = m_->body_geomadr[body];
  for (int g = begin; g >= 0 && g < begin + m_->body_geomnum[body]; ++g) {
    if (collides(g)) return true;
  }
  return false;
}

bool MjcfView::has_at_or_below(int top, const std::function<bool(int)>& has) const {
  for (int b = top; b < m_->nbody; ++b) {
    int up = b;
    while (up > top) up = m_->body_parentid[up];
    if (up == top && has(b)) return true;
  }
  return false;
}

bool MjcfView::object_collides(int top) const {
  for (int b = top; b < m_->nbody; ++b) {
    int up = b;
    while (up > top) up = m_->body_parentid[up];
    if (up == top && roles_.is_object(b) && has_colliding_geom(b)) return true;
  }
  return false;
}

bool MjcfView::is_on_free_body(int body) const {
  for (; body != 0; body = m_->body_parentid[body]) {
    for (const int joint : roles_.joints_of(body)) {
      if (is_free(joint)) return true;
    }
  }
  return false;
}

bool MjcfView::couples_joints(int equality) const {
  if (m_->eq_type[equality] != mjEQ_JOINT) return false;
  const int joint = m_->eq_obj1id[equality], leader = m_->eq_obj2id[equality];
  return is_motor(joint) && (leader < 0 || is_motor(leader));
}

std::optional<std::map<int, double>> MjcfView::joints_of_tendon(int tendon) const {
  std::map<int, double> out;
  for (int w = m_->tendon_adr[tendon]; w < m_->tendon_adr[tendon] + m_->tendon_num[tendon]; ++w) {
    if (m_->wrap_type[w] != mjWRAP_JOINT) return std::nullopt;
    if (m_->wrap_prm[w] == 0) continue;
    if (!is_motor(m_->wrap_objid[w])) return std::nullopt;
    out[m_->wrap_objid[w]] += m_->wrap_prm[w];
  }
  return out;
}

bool MjcfView::drives_joints(int actuator) const {
  if (m_->actuator_trntype[actuator] != mjTRN_TENDON) return false;
  const auto joints = joints_of_tendon(m_->actuator_trnid[2 * actuator]);
  return joints && !joints->empty();
}

}  // namespace stiction::world
