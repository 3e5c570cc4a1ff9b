#include <algorithm>
#include <cmath>

#include "stiction/world/model_parts.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

/// The value nearest to 0 in [lower, upper].
double nearest_to_zero(double lower, double upper) { return std::clamp(0.0, lower, upper); }

/// Builds a Model::Impl from a scene: objects, then robots, then fixed bodies; then what follows from them.
class Builder {
 public:
  explicit Builder(const Scene& scene) : impl_(std::make_unique<Model::Impl>()), m_(*impl_), parts_(m_) { m_.scene = scene; }

  std::unique_ptr<Model::Impl> build() {
    const Scene& scene = m_.scene;
    parts_.guard("scene", [&] {
      core::require_finite("gravity", std::span(scene.gravity.data(), 3));
      core::require_positive("contact_distance", scene.contact_distance);
      if (scene.max_contacts && *scene.max_contacts < 1)
        core::throw_invalid("max_contacts", fmt::format("{}", *scene.max_contacts), "an integer ≥ 1");
    });
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      parts_.guard(fmt::format("objects[{}]", i), [&] { add_object(parts_, scene.objects[i], static_cast<int>(i)); });
    }
    m_.n_vu = m_.n_v;
    m_.n_qu = m_.n_q;
    for (std::size_t i = 0; i < scene.robots.size(); ++i) {
      parts_.guard(fmt::format("robots[{}]", i), [&] {
        m_.scene.robots[i].contents = contents_of(scene.robots[i]);
        add_robot(parts_, scene.robots[i], static_cast<int>(i));
      });
    }
    m_.n_a = m_.n_v - m_.n_vu;
    for (std::size_t i = 0; i < scene.fixed.size(); ++i) {
      parts_.guard(fmt::format("fixed[{}]", i), [&] { add_fixed(scene.fixed[i]); });
    }
    number_followers();
    finish_vectors();
    add_pairs(parts_);
    find_planar_axis();
    return std::move(impl_);
  }

 private:
  void add_fixed(const FixedSpec& spec) {
    parts_.add_owner_name(spec.name);
    if (!is_rotation(spec.X_WB.R) || !spec.X_WB.p.allFinite()) core::throw_invalid("pose", "no rigid transform", "one");
    const int body = parts_.add_body(spec.name, BodyKind::Fixed, -1, {});
    m_.constant_poses.emplace_back(body, spec.X_WB);
    for (const auto& geometry : spec.geometries) parts_.add_geometry(body, geometry);
  }

  void number_followers() {
    const auto number = [&](int& axis) {
      if (axis >= kFollowers) axis += m_.n_v - kFollowers;
    };
    for (Body& body : m_.bodies) std::ranges::for_each(body.axes, number);
    for (LinkNode& node : m_.link_nodes) number(node.axis);
  }

  void finish_vectors() {
    m_.stiffness.resize(m_.n_a);
    m_.effort.resize(m_.n_a);
    m_.speed_limit.resize(m_.n_a);
    m_.lower.resize(m_.n_a);
    m_.upper.resize(m_.n_a);
    m_.command_lower.resize(m_.n_a);
    m_.command_upper.resize(m_.n_a);
    m_.neutral.setZero(m_.n_q);
    m_.reach = Eigen::Map<const Eigen::VectorXd>(parts_.reach.data(), static_cast<Eigen::Index>(parts_.reach.size()));
    for (int i = 0; i < m_.n_a; ++i) {
      const Dof& dof = m_.dofs[at(m_.n_vu + i)];
      m_.stiffness[i] = dof.stiffness;
      m_.effort[i] = dof.effort;
      m_.speed_limit[i] = dof.speed_limit;
      m_.lower[i] = dof.lower;
      m_.upper[i] = dof.upper;
      m_.command_lower[i] = dof.command_lower;
      m_.command_upper[i] = dof.command_upper;
      m_.neutral[m_.n_qu + i] = nearest_to_zero(dof.lower, dof.upper);
    }
    for (const ObjectNode& node : m_.object_nodes) {
      if (node.joint == ObjectJoint::Free) m_.neutral[node.q + 6] = 1;
      const Dof& first = m_.dofs[at(node.v)];
      if (node.n_v == 1) m_.neutral[node.q] = nearest_to_zero(first.lower, first.upper);
    }
  }

  /// Finds the normal of the plane in which all bodies move. Rotation about a fixed direction and translation normal to it keep all axes in that
  /// form, so one configuration decides.
  void find_planar_axis() {
    if (m_.n_v == 0) return;
    Kinematics kinematics;
    calc_kinematics(m_, m_.neutral, kinematics);
    for (int k = 0; k < 3; ++k) {
      bool all = true;
      const auto require = [&](int column, DofKind kind) {
        const double along = std::abs(kinematics.axis_W(k, column));
        all = all && (kind == DofKind::Revolute ? along > 1 - 1e-9 : along < 1e-9);
      };
      for (int i = 0; i < m_.n_v; ++i) require(i, m_.dofs[at(i)].kind);
      for (std::size_t i = 0; i < m_.followers.size(); ++i) require(m_.n_v + static_cast<int>(i), m_.followers[i].kind);
      if (all) m_.planar_axis = k;
      if (all) return;
    }
  }

  std::unique_ptr<Model::Impl> impl_;
  Model::Impl& m_;
  ModelParts parts_;
};

}  // namespace

std::unique_ptr<Model::Impl> build_model(const Scene& scene) { return Builder(scene).build(); }

}  // namespace stiction::world
