#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "stiction/world/mjcf_roles.hpp"
#include "stiction/world/scene.hpp"

namespace stiction::world {

/// Which constraints of an MJCF are read, or change nothing.
struct MjcfMeaning {
  std::vector<bool> equality, tendon_limit, tendon_spring;  ///< per equality and tendon of the file
};

/// What a compiled MJCF says of its elements: names, which of them collide, hang together or mean nothing here.
class MjcfView {
 public:
  MjcfView(const mjModel* m, const MjcfRoles& roles, const std::filesystem::path& file);

  std::string given_name(mjtObj type, int id) const;
  std::string body_name(int body) const;
  std::string joint_name(int joint) const;
  /// Names become parts of other names here.
  static std::string usable(std::string name);

  bool is_free(int joint) const { return m_->jnt_type[joint] == mjJNT_FREE; }
  double reference(int joint) const { return m_->qpos0[m_->jnt_qposadr[joint]]; }  ///< its value at the pose of the file
  bool is_ball(int joint) const { return m_->jnt_type[joint] == mjJNT_BALL; }
  /// Type and affinity, in which contact pairs of their own have bits that no geom of the file has.
  const ContactMask& mask(int geom) const { return masks_[static_cast<std::size_t>(geom)]; }
  bool collides(int geom) const { return (mask(geom).type | mask(geom).affinity) != 0; }
  bool is_on_joint(int actuator) const;
  bool slides_or_turns(int joint) const { return m_->jnt_type[joint] == mjJNT_HINGE || m_->jnt_type[joint] == mjJNT_SLIDE; }
  /// A joint of the robot follows another one by y − y₀ = a₀ + a₁ (x − x₀) + … + a₄ (x − x₀)⁴, or stands at y − y₀ = a₀.
  bool couples_joints(int equality) const;
  /// A hinge or a slide of the robot.
  bool is_motor(int joint) const { return slides_or_turns(joint) && roles_.of_joint(joint) == MjcfRole::Robot; }
  /// Joints of a fixed tendon and their coefficients, without those that are 0; nullopt where others than the robot's count.
  std::optional<std::map<int, double>> joints_of_tendon(int tendon) const;
  /// On a tendon over joints of the robot alone.
  bool drives_joints(int actuator) const;
  /// An object, what is welded to it or what hangs on it collides.
  bool object_collides(int top) const;
  /// The spring is linear, and there is one.
  bool has_linear_spring(int joint) const;

  /// Of every kind but a mesh, a height field and a signed distance field.
  std::optional<Shape> read_primitive(int geom) const;

  /// What kinematics and contacts cannot do without is there. @throws core::InvalidInput that names all the rest
  void require_supported() const;
  /// Forces beside those of servos and contacts, and free bodies that are only seen: they mean nothing here.
  std::vector<std::string> list_passed_over(const MjcfMeaning& read) const;

 protected:
  const mjModel* m_;
  const MjcfRoles& roles_;
  const std::filesystem::path& file_;

 private:
  std::string describe(std::string_view element, mjtObj type, int id, std::string_view reason) const;
  void find_masks();
  /// No filter of the scene lets the bodies of a contact pair touch: they are excluded, or a joint links them.
  bool is_kept_apart(int pair) const;
  bool has_colliding_geom(int body) const;
  bool has_at_or_below(int top, const std::function<bool(int)>& has) const;
  bool is_on_free_body(int body) const;
  /// Empty where the spring of a joint is read.
  std::string describe_spring(int joint) const;

  std::vector<ContactMask> masks_{};  ///< per geom
  std::vector<bool> pair_read_{};
};

}  // namespace stiction::world
