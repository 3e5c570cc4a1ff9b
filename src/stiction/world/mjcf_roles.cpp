#include "stiction/world/mjcf_roles.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "stiction/core/invalid_input.hpp"
#include "stiction/world/yaml.hpp"

namespace stiction::world {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Appends the nearest joints at or above a body.
void add_joints_above(const mjModel& m, int body, std::vector<int>& out) {
  while (body != 0 && m.body_jntnum[body] == 0) body = m.body_parentid[body];
  for (int k = 0; k < m.body_jntnum[body]; ++k) out.push_back(m.body_jntadr[body] + k);
}

}  // namespace

std::vector<int> joints_of_actuator(const mjModel& m, int actuator) {
  std::vector<int> out;
  const int id = m.actuator_trnid[2 * actuator], other = m.actuator_trnid[2 * actuator + 1];
  switch (m.actuator_trntype[actuator]) {
    case mjTRN_JOINT:
    case mjTRN_JOINTINPARENT:
      out.push_back(id);
      break;
    case mjTRN_TENDON:
      for (int w = m.tendon_adr[id]; w < m.tendon_adr[id] + m.tendon_num[id]; ++w) {
        if (m.wrap_type[w] == mjWRAP_JOINT)
          out.push_back(m.wrap_objid[w]);
        else if (m.wrap_type[w] == mjWRAP_SITE)
          add_joints_above(m, m.site_bodyid[m.wrap_objid[w]], out);
      }
      break;
    case mjTRN_SITE:
      add_joints_above(m, m.site_bodyid[id], out);
      break;
    case mjTRN_SLIDERCRANK:
      add_joints_above(m, m.site_bodyid[id], out);
      if (other >= 0) add_joints_above(m, m.site_bodyid[other], out);
      break;
    case mjTRN_BODY:  // adhesion: the body sticks to others, and does not move itself
    default:
      break;
  }
  return out;
}

/// Decides the role of every body and joint.
struct MjcfRoles::Builder {
  MjcfRoles& out;
  const mjModel& m;
  const RobotSpec& spec;
  const std::filesystem::path& file;
  std::vector<int> tree{};       ///< per body: the topmost body with joints at or above it; 0 if there is none
  std::vector<bool> actuated{};  ///< for each body at the top of a tree: the tree has an actuator

  [[noreturn]] void fail(std::string_view got, std::string_view expected) const {
    throw core::InvalidInput(fmt::format("{}: mjcf: got {}, expected {}", file.string(), got, expected));
  }

  bool is_free(int joint) const { return m.jnt_type[joint] == mjJNT_FREE; }

  /// Finds a body that the scene names. @param what  list of the scene that contains the name
  int find_body(const std::string& name, std::string_view what) const {
    std::vector<std::string> moving;
    for (int b = 1; b < m.nbody; ++b) {
      if (out.names_.body(b) == name) {
        if (what == "robot" ? tree[at(b)] == 0 : m.body_jntnum[b] == 0)
          fail(fmt::format("body '{}' as {}, which no joint moves", name, what),
               what == "robot" ? "a body of a tree with joints" : "a body with a joint");
        return b;
      }
      if (m.body_jntnum[b] > 0) moving.push_back(out.names_.body(b));
    }
    fail(fmt::format("{} '{}', which is no body of the file", what, name),
         moving.empty() ? "none (no body has a joint)" : "one of " + list_with_hint(name, moving));
  }

  void find_trees() {
    tree.assign(at(m.nbody), 0);
    actuated.assign(at(m.nbody), false);
    for (int b = 1; b < m.nbody; ++b) {
      const int above = tree[at(m.body_parentid[b])];
      tree[at(b)] = above != 0 ? above : m.body_jntnum[b] > 0 ? b : 0;
    }
    for (int i = 0; i < m.nactuator; ++i) {
      for (const int joint : joints_of_actuator(m, i)) actuated[at(tree_of(joint))] = true;
    }
    for (const std::string& name : spec.split.robot) actuated[at(tree[at(find_body(name, "robot"))])] = true;
    for (bool again = true; again;) {  // a joint that follows a robot's joint belongs to the robot
      again = false;
      for (int i = 0; i < m.neq; ++i) {
        if (m.eq_active0[i] && share_role(joints_of_equality(i), m.eq_type[i] == mjEQ_JOINT ? 1 : 0)) again = true;
      }
    }
  }

  /// Joints that an equality of joints or of tendons couples, or that a `connect` closes to a loop. For an equality of joints, the follower comes
  /// first.
  std::vector<int> joints_of_equality(int i) const {
    std::vector<int> joints;
    if (m.eq_type[i] == mjEQ_CONNECT && m.eq_objtype[i] == mjOBJ_BODY) {
      const int tops[] = {tree[at(m.eq_obj1id[i])], tree[at(m.eq_obj2id[i])]};
      for (const int top : tops) {
        if (top > 0) joints.push_back(m.body_jntadr[top]);
      }
      if (std::ranges::any_of(joints, [&](int joint) { return is_free(joint); })) joints.clear();  // an object that the robot is to hold
    }
    if (m.eq_type[i] == mjEQ_JOINT && m.eq_obj2id[i] >= 0) joints = {m.eq_obj1id[i], m.eq_obj2id[i]};
    if (m.eq_type[i] != mjEQ_TENDON) return joints;
    for (const int tendon : {m.eq_obj1id[i], m.eq_obj2id[i]}) {
      for (int w = tendon < 0 ? 0 : m.tendon_adr[tendon]; tendon >= 0 && w < m.tendon_adr[tendon] + m.tendon_num[tendon]; ++w) {
        if (m.wrap_type[w] == mjWRAP_JOINT) joints.push_back(m.wrap_objid[w]);
      }
    }
    return joints;
  }

  /// Assigns the trees of all given joints to the robot if the tree of one of them belongs to it. @param first  first joint that counts for this test
  /// @returns whether another tree became the robot's
  bool share_role(const std::vector<int>& joints, std::size_t first) {
    bool any = false, more = false;
    for (std::size_t k = first; k < joints.size(); ++k) any = any || actuated[at(tree_of(joints[k]))];
    for (const int joint : joints) {
      more = more || (any && !actuated[at(tree_of(joint))]);
      if (any) actuated[at(tree_of(joint))] = true;
    }
    return more;
  }
  int tree_of(int joint) const { return tree[at(m.jnt_bodyid[joint])]; }

  /// True for a tree whose only joint is free. Such a tree is an object, whatever actuator acts on it.
  bool only_free(int top) const {
    for (int j = 0; j < m.njnt; ++j) {
      if (tree_of(j) == top && !is_free(j)) return false;
    }
    return true;
  }

  MjcfRole decide(int joint) const {
    const int top = tree_of(joint);
    if (!out.by_actuators_) {
      if (!is_free(joint)) return MjcfRole::Robot;
      return spec.fixed_base && !only_free(top) ? MjcfRole::Fixed : MjcfRole::Object;
    }
    if (!actuated[at(top)] || only_free(top)) return MjcfRole::Object;
    return is_free(joint) && spec.fixed_base ? MjcfRole::Fixed : MjcfRole::Robot;
  }

  void decide_joints() {
    for (int j = 0; j < m.njnt; ++j) out.joints_.push_back(decide(j));
    if (!spec.split.objects) return;
    std::vector<bool> named(at(m.nbody), false);
    for (const std::string& name : *spec.split.objects) named[at(find_body(name, "object"))] = true;
    for (int j = 0; j < m.njnt; ++j) {
      const int body = m.jnt_bodyid[j];
      if (named[at(body)])
        out.joints_[at(j)] = MjcfRole::Object;
      else if (out.joints_[at(j)] == MjcfRole::Object)
        out.joints_[at(j)] = MjcfRole::Fixed;
    }
  }

  void decide_bodies() {
    out.top_.assign(at(m.nbody), 0);
    out.bodies_.assign(at(m.nbody), out.by_actuators_ ? MjcfRole::Fixed : MjcfRole::Robot);
    for (int b = 1; b < m.nbody; ++b) {
      const int above = m.body_parentid[b];
      const std::vector<int> own = out.joints_of(b);
      out.top_[at(b)] = own.empty() ? out.top_[at(above)] : b;
      if (out.top_[at(b)] == 0) continue;
      const MjcfRole role = own.empty() ? out.bodies_[at(above)] : out.joints_[at(own[0])];
      out.bodies_[at(b)] = role;
      if (own.empty() || out.top_[at(above)] == 0) continue;
      const MjcfRole carrier = out.bodies_[at(above)];
      if (carrier == MjcfRole::Robot && role == MjcfRole::Object)
        fail(fmt::format("object '{}', which hangs on a joint of the robot", out.names_.body(b)), "a body that no robot carries");
      if (carrier == MjcfRole::Object && role == MjcfRole::Robot && out.by_actuators_)
        fail(fmt::format("object '{}', on which a joint of the robot hangs", out.names_.body(out.top_[at(above)])),
             "the body below as an object as well");
    }
    for (int b = m.nbody - 1; b > 0; --b) {  // fixed bodies that carry links of the robot
      const int above = m.body_parentid[b];
      if (out.bodies_[at(b)] == MjcfRole::Robot && above != 0 && out.top_[at(above)] == 0) out.bodies_[at(above)] = MjcfRole::Robot;
    }
  }

  void find_silent_motors() {
    if (out.by_actuators_ || m.nactuator == 0) return;
    for (int j = 0; j < m.njnt; ++j) {
      if (out.joints_[at(j)] == MjcfRole::Robot && !actuated[at(tree_of(j))]) out.silent_motors_.push_back(j);
    }
  }
};

MjcfRoles::MjcfRoles(const mjModel& m, const RobotSpec& spec, const std::filesystem::path& file)
    : m_(m), names_(m), by_actuators_(spec.split.by_actuators) {
  Builder builder{*this, m, spec, file};
  builder.find_trees();
  builder.decide_joints();
  builder.decide_bodies();
  builder.find_silent_motors();
}

std::vector<int> MjcfRoles::joints_of(int body) const {
  std::vector<int> out;
  for (int j = m_.body_jntadr[body]; j >= 0 && j < m_.body_jntadr[body] + m_.body_jntnum[body]; ++j) {
    if (moves(j)) out.push_back(j);
  }
  return out;
}

bool MjcfRoles::has_robot() const { return std::find(joints_.begin(), joints_.end(), MjcfRole::Robot) != joints_.end(); }

}  // namespace stiction::world
