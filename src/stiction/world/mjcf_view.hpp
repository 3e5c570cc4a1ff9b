#pragma once

#include <mujoco/mujoco.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace stiction::world {

/// What a compiled MJCF says of its elements: names, which of them collide, hang together or mean nothing here.
class MjcfView {
 public:
  MjcfView(const mjModel* m, const std::filesystem::path& file) : m_(m), file_(file) {}

  std::string given_name(mjtObj type, int id) const;
  std::string body_name(int body) const;
  std::string joint_name(int joint) const;
  std::string exclude_name(int body) const;
  /// Names become parts of other names here.
  static std::string usable(std::string name);

  bool is_free(int body) const { return m_->body_jntnum[body] == 1 && m_->jnt_type[m_->body_jntadr[body]] == mjJNT_FREE; }
  bool collides(int geom) const { return (m_->geom_contype[geom] | m_->geom_conaffinity[geom]) != 0; }
  bool is_on_joint(int actuator) const;
  bool slides_or_turns(int joint) const { return m_->jnt_type[joint] == mjJNT_HINGE || m_->jnt_type[joint] == mjJNT_SLIDE; }
  /// y − y₀ = a₀ + a₁ (x − x₀) between two joints, or y − y₀ = a₀.
  bool couples_joints(int equality) const;
  /// A free body and what is welded to it collide.
  bool object_collides(int top) const;

  /// What kinematics and contacts cannot do without is there. @throws core::InvalidInput that names all the rest
  void require_supported() const;
  /// Forces beside those of servos and contacts, and free bodies that are only seen: they mean nothing here.
  std::vector<std::string> list_passed_over() const;

 protected:
  const mjModel* m_;
  const std::filesystem::path& file_;

 private:
  std::string describe(std::string_view element, mjtObj type, int id, std::string_view reason) const;
  bool has_colliding_geom(int body) const;
  bool is_only_seen(int top) const;
  bool is_on_free_body(int body) const;
};

}  // namespace stiction::world
