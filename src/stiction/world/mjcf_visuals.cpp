#include "stiction/world/mjcf_visuals.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "stiction/world/mjcf_view.hpp"

namespace stiction::world {
namespace {

using Eigen::Vector4d;
using Bounds = Eigen::AlignedBox3d;

Pose read_pose(const mjtNum* position, const mjtNum* wxyz) {
  return {Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]).normalized().toRotationMatrix(), {position[0], position[1], position[2]}};
}

class VisualLister : private MjcfView {
 public:
  VisualLister(const mjModel& m, const MjcfRoles& roles, const std::filesystem::path& file, const std::map<int, Pose>& X_OB)
      : MjcfView(&m, roles, file), X_OB_(X_OB) {}

  void list(RobotTree& tree) const {
    for (int body = 0; body < m_->nbody; ++body) {
      const auto place = find_place(body);
      if (!place) continue;
      const std::vector<Bounds> only_seen = bounds_of_pictures(body);
      for (int g = m_->body_geomadr[body]; g >= 0 && g < m_->body_geomadr[body] + m_->body_geomnum[body]; ++g) {
        if (!is_shown(g) || (collides(g) && m_->geom_matid[g] < 0 && is_covered(bounds_of(g), only_seen))) continue;
        auto form = read_form(g);
        if (!form) {
          tree.unseen.push_back(fmt::format("{}: a height field or a signed distance field", body_name(body)));
          continue;
        }
        const Vector4d c = color_of(g);
        const Pose X_BG = read_pose(m_->geom_pos + 3 * g, m_->geom_quat + 4 * g);
        tree.visuals.push_back(
            {.owner = place->first, .X_BV = place->second * X_BG, .form = std::move(*form), .color = std::array{c[0], c[1], c[2], c[3]}});
      }
    }
  }

 private:
  /// Name of the link or object that a body of the file belongs to, and the body's pose in it; nullopt if the scene has no such body.
  std::optional<std::pair<std::string, Pose>> find_place(int body) const {
    if (roles_.of_body(body) == MjcfRole::Robot) return std::pair{body_name(body), Pose{}};
    const int top = roles_.of_body(body) == MjcfRole::Object ? roles_.top(body) : 0;
    Pose X;
    for (int b = body; b != top; b = m_->body_parentid[b]) X = read_pose(m_->body_pos + 3 * b, m_->body_quat + 4 * b) * X;
    if (top == 0) return std::pair{std::string(), X};
    const auto object = X_OB_.find(top);
    if (object == X_OB_.end()) return std::nullopt;  // the object does not collide, so the scene leaves it out
    return std::pair{body_name(top), object->second * X};
  }

  bool is_shown(int g) const {
    constexpr int kGroups = 3;                                                    // groups that MuJoCo's viewer shows by default
    if (m_->body_mocapid[m_->geom_bodyid[g]] >= 0 && !collides(g)) return false;  // marker of a mocap body
    return m_->geom_type[g] != mjGEOM_PLANE && m_->geom_group[g] < kGroups && color_of(g)[3] > 0;
  }

  Bounds bounds_of(int g) const {
    const Pose X_BG = read_pose(m_->geom_pos + 3 * g, m_->geom_quat + 4 * g);
    const mjtNum* box = m_->geom_aabb + 6 * g;
    const Eigen::Vector3d middle = X_BG * Eigen::Vector3d(box[0], box[1], box[2]);
    const Eigen::Vector3d half = X_BG.R.cwiseAbs() * Eigen::Vector3d(box[3], box[4], box[5]);
    return {middle - half, middle + half};
  }

  /// Bounds of the visual-only geoms of a body. The geoms of a link share one box; each geom of the world has its own.
  std::vector<Bounds> bounds_of_pictures(int body) const {
    std::vector<Bounds> out;
    for (int g = m_->body_geomadr[body]; g >= 0 && g < m_->body_geomadr[body] + m_->body_geomnum[body]; ++g) {
      if (collides(g) || !is_shown(g)) continue;
      if (out.empty() || body == 0)
        out.push_back(bounds_of(g));
      else
        out.front().extend(bounds_of(g));
    }
    return out;
  }

  /// True if more than half of a box is inside one of the others.
  static bool is_covered(const Bounds& box, const std::vector<Bounds>& others) {
    return std::any_of(others.begin(), others.end(), [&](const Bounds& other) {
      const Eigen::Vector3d common = other.intersection(box).sizes().cwiseMax(0), all = box.sizes();
      return common.cwiseQuotient(all.cwiseMax(1e-9)).prod() > 0.5;
    });
  }

  std::optional<std::variant<Shape, VisualFile>> read_form(int g) const {
    if (const auto shape = read_primitive(g)) return *shape;
    if (m_->geom_type[g] != mjGEOM_MESH) return std::nullopt;
    return VisualFile{.file = {}, .number = m_->geom_dataid[g]};
  }

  /// The geom's own colour, else the colour of its material; for a texture the mean colour.
  Vector4d color_of(int g) const {
    const Vector4d own = Eigen::Map<const Eigen::Vector4f>(m_->geom_rgba + 4 * g).cast<double>();
    const int material = m_->geom_matid[g];
    if (material < 0) return own;
    const bool is_default = own == Vector4d(0.5, 0.5, 0.5, 1);
    Vector4d color = is_default ? Eigen::Map<const Eigen::Vector4f>(m_->mat_rgba + 4 * material).cast<double>() : own;
    const int texture = m_->mat_texid[mjNTEXROLE * material + mjTEXROLE_RGB];
    if (texture >= 0) color.head<3>().array() *= mean_of_texture(texture).array();
    return color;
  }

  Eigen::Vector3d mean_of_texture(int texture) const {
    constexpr std::int64_t kPixels = 4096;  // largest number of sampled pixels
    const int channels = m_->tex_nchannel[texture];
    const std::int64_t count = std::int64_t{m_->tex_width[texture]} * m_->tex_height[texture];
    if (channels < 3 || count == 0) return Eigen::Vector3d::Ones();
    const std::int64_t step = std::max<std::int64_t>(1, count / kPixels);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::int64_t number = 0;
    for (std::int64_t i = 0; i < count; i += step, ++number) {
      const mjtByte* pixel = m_->tex_data + m_->tex_adr[texture] + i * channels;
      sum += Eigen::Vector3d(pixel[0], pixel[1], pixel[2]) / 255;
    }
    return sum / static_cast<double>(number);
  }

  const std::map<int, Pose>& X_OB_;
};

}  // namespace

void list_mjcf_visuals(const mjModel& m, const MjcfRoles& roles, const std::filesystem::path& file, const std::map<int, Pose>& X_OB,
                       RobotTree& tree) {
  VisualLister(m, roles, file, X_OB).list(tree);
}

}  // namespace stiction::world
