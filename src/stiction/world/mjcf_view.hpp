#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stiction/world/mjcf_roles.hpp"
#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Marks the constraints of an MJCF that are read or have no effect.
struct MjcfMeaning {
  std::vector<bool> equality, tendon_limit, tendon_spring;  ///< per equality and tendon of the file
};

/// True for an actuator with the force c·command + b₀ − k_p q − k_v q̇ at once, whatever its name in the file.
bool is_position_servo(const mjModel& m, int actuator);
/// Joint positions between which an actuator on a joint may be commanded, if it is a position servo with a `ctrlrange` and a gear.
std::optional<std::pair<double, double>> commanded_positions(const mjModel& m, int actuator);

/// Queries on the elements of a compiled MJCF: their names, which of them collide or are coupled, and which are ignored.
class MjcfView {
 public:
  MjcfView(const mjModel* m, const MjcfRoles& roles, const std::filesystem::path& file);

  std::string given_name(mjtObj type, int id) const;
  /// "ELEMENT 'NAME'", or "ELEMENT NUMBER" without a name
  std::string describe(std::string_view element, mjtObj type, int id) const;
  const std::string& body_name(int body) const { return roles_.names().body(body); }
  const std::string& joint_name(int joint) const { return roles_.names().joint(joint); }

  bool is_free(int joint) const { return m_->jnt_type[joint] == mjJNT_FREE; }
  double reference(int joint) const { return m_->qpos0[m_->jnt_qposadr[joint]]; }  ///< value of the joint at the pose of the file
  bool is_ball(int joint) const { return m_->jnt_type[joint] == mjJNT_BALL; }
  /// True if the geom has a type or an affinity, or touches another geom by a contact pair of the file.
  bool collides(int geom) const {
    return (m_->geom_contype[geom] | m_->geom_conaffinity[geom]) != 0 || paired_[static_cast<std::size_t>(geom)];
  }
  /// False for a contact pair of geoms that cannot touch.
  bool acts(int pair) const {
    return pair_read_[static_cast<std::size_t>(pair)] || masks_match(m_->pair_geom1[pair], m_->pair_geom2[pair]);
  }
  bool is_on_joint(int actuator) const;
  bool slides_or_turns(int joint) const { return m_->jnt_type[joint] == mjJNT_HINGE || m_->jnt_type[joint] == mjJNT_SLIDE; }
  /// True if a joint of the robot follows another one by y − y₀ = a₀ + a₁ (x − x₀) + … + a₄ (x − x₀)⁴, or is fixed at y − y₀ = a₀.
  bool couples_joints(int equality) const;
  /// True for a hinge or a slide of the robot.
  bool is_motor(int joint) const { return slides_or_turns(joint) && roles_.of_joint(joint) == MjcfRole::Robot; }
  /// Joints of a fixed tendon and their nonzero coefficients; nullopt if one of these joints does not belong to the robot.
  std::optional<std::map<int, double>> joints_of_tendon(int tendon) const;
  /// True if the actuator acts on a tendon over joints of the robot only.
  bool drives_joints(int actuator) const;
  /// True if an object, a body welded to it or a body that hangs on it collides.
  bool object_collides(int top) const;
  /// True if the joint has a spring and the spring is linear.
  bool has_linear_spring(int joint) const;

  /// Shape of a geom of any kind except mesh, height field and signed distance field.
  std::optional<Shape> read_primitive(int geom) const;

  /// Checks that kinematics and contacts support all essential elements. @throws core::InvalidInput that names all unsupported ones
  void require_supported() const;
  /// Lists ignored elements: forces other than those of servos and contacts, and free bodies that are only visual.
  std::vector<std::string> list_passed_over(const MjcfMeaning& read) const;

 protected:
  const mjModel* m_;
  const MjcfRoles& roles_;
  const std::filesystem::path& file_;

 private:
  bool masks_match(int geom, int other) const {
    return ((m_->geom_contype[geom] & m_->geom_conaffinity[other]) | (m_->geom_contype[other] & m_->geom_conaffinity[geom])) != 0;
  }
  /// True if the bodies of a contact pair cannot touch: the file excludes them, they are welded together, or a joint links them.
  bool is_kept_apart(int pair) const;
  bool has_colliding_geom(int body) const;
  bool has_at_or_below(int top, const std::function<bool(int)>& has) const;
  bool is_on_free_body(int body) const;
  /// Describes why the spring of a joint is not read; empty if it is read.
  std::string describe_spring(int joint) const;

  std::vector<bool> paired_{};  ///< per geom
  std::vector<bool> pair_read_{};
};

}  // namespace stiction::world
