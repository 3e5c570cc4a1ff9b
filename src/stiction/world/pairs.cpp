#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "stiction/world/joint_values.hpp"
#include "stiction/world/model_parts.hpp"
#include "stiction/world/overlap.hpp"
#include "stiction/world/reach_ball.hpp"
#include "stiction/world/read.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

/// Number of pairs beyond which the broad phase alone takes longer than a step of an ordinary scene.
constexpr std::size_t kMany = 20000;
/// Factor on the radius of a reach ball, because springs and motors give way and joints may exceed their limits a little.
constexpr double kBeyondLimits = 1.1;

/// Finds the pairs of geometries that may touch: they move relative to each other, no filter excludes them, and no joint links their bodies.
class PairFinder {
 public:
  explicit PairFinder(ModelParts& parts) : parts_(parts), m_(parts.m) {}

  void add_pairs() {
    check_filters();
    parts_.guard("contacts", [&] { find_contacts(); });
    Kinematics rest;
    std::vector<Ball> balls;
    parts_.guard("scene", [&] {
      const Eigen::VectorXd q = rest_configuration();
      calc_kinematics(m_, q, rest);
      for (const Geometry& geometry : m_.geometries) balls.push_back(ball_of(geometry, rest, q));
    });
    std::map<std::vector<int>, int> support_index;
    const std::vector<Filter> filters = find_filters();
    for (std::size_t i = 0; i < m_.geometries.size(); ++i) {
      for (std::size_t j = i + 1; j < m_.geometries.size(); ++j) {
        const Geometry& a = m_.geometries[i];  // bodies stand in the order objects, robots, fixed: a comes first
        const Geometry& b = m_.geometries[j];
        if (!may_touch(a, b) || !may_push(a, b)) continue;
        Pair pair{static_cast<int>(i), static_cast<int>(j), 0, m_.scene.contact_distance, -1};
        bool excluded = false;
        for (const Filter& filter : filters) {
          if (!((filter.a[i] && filter.b[j]) || (filter.a[j] && filter.b[i]))) continue;
          if (filter.max_distance)
            pair.max_distance = *filter.max_distance;
          else
            excluded = true;
        }
        if (excluded || never_meet(balls[i], balls[j], b, rest, pair.max_distance) || overlap_at_rest(a, b, rest)) continue;
        set_friction(a, b, pair);
        pair.max_force = std::min(a.max_force, b.max_force);
        std::vector<int> support;
        const auto& dofs_a = m_.bodies[at(a.body)].dofs;
        const auto& dofs_b = m_.bodies[at(b.body)].dofs;
        std::set_union(dofs_a.begin(), dofs_a.end(), dofs_b.begin(), dofs_b.end(), std::back_inserter(support));
        const auto [found, added] = support_index.emplace(support, static_cast<int>(m_.supports.size()));
        if (added) m_.supports.push_back(std::move(support));
        pair.support = found->second;
        m_.pairs.push_back(pair);
      }
    }
    if (m_.pairs.size() > kMany)
      parts_.add_note(
          m_.scene.name.empty() ? "scene" : m_.scene.name,
          fmt::format("{} bodies, of which {} pairs of shapes may touch: every step looks at all of them; exclude those that never meet "
                      "(`filters`), or let bodies stand still (`objects` of a scene's `file`)",
                      m_.bodies.size(), m_.pairs.size()));
    for (const auto& [robot, names] : overlapping_) {
      parts_.add_note(
          robot, fmt::format("{} pair{} of its links overlap{} at rest and never touch{}: {}", names.size(), names.size() == 1 ? "" : "s",
                             names.size() == 1 ? "s" : "", names.size() == 1 ? "es" : "", list_some(names)));
    }
  }

 private:
  /// A filter, and the geometries that its patterns match: a file may exclude thousands of pairs.
  struct Filter {
    std::vector<bool> a, b;
    std::optional<double> max_distance;
  };

  std::vector<Filter> find_filters() const {
    const auto find = [&](const std::string& pattern) {
      std::vector<bool> out;
      for (const Geometry& geometry : m_.geometries) out.push_back(geometry_matches(pattern, geometry));
      return out;
    };
    std::vector<Filter> filters;
    for (const FilterSpec& filter : m_.scene.filters) filters.push_back({find(filter.a), find(filter.b), filter.max_distance});
    return filters;
  }

  bool geometry_matches(const std::string& pattern, const Geometry& geometry) const {
    const Body& body = m_.bodies[at(geometry.body)];
    if (matches_pattern(pattern, body.name) || matches_pattern(pattern, geometry.name)) return true;
    return body.kind == BodyKind::Robot && matches_pattern(pattern, m_.robots[at(body.owner)].name);
  }

  void check_filters() {
    std::vector<std::string> names;
    for (const auto& robot : m_.robots) names.push_back(robot.name);
    for (const auto& body : m_.bodies) names.push_back(body.name);
    for (const auto& geometry : m_.geometries) names.push_back(geometry.name);
    for (std::size_t i = 0; i < m_.scene.filters.size(); ++i) {
      const FilterSpec& filter = m_.scene.filters[i];
      parts_.guard(fmt::format("filters[{}]", i), [&] {
        for (const std::string& pattern : {filter.a, filter.b}) {
          if (std::none_of(names.begin(), names.end(), [&](const std::string& name) { return matches_pattern(pattern, name); })) {
            core::throw_invalid("name", fmt::format("unknown body or geometry '{}'", pattern), "one of " + list_with_hint(pattern, names));
          }
        }
        if (filter.max_distance) core::require_nonnegative("max_distance", *filter.max_distance);
      });
    }
  }

  void find_contacts() {
    std::vector<std::string> names;
    for (const Geometry& geometry : m_.geometries) names.push_back(geometry.name);
    const auto find = [&](const std::string& name) {
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end())
        core::throw_invalid("name", fmt::format("unknown geometry '{}'", name), "one of " + list_with_hint(name, names));
      return static_cast<int>(found - names.begin());
    };
    for (const ContactSpec& contact : m_.scene.contacts) {
      core::require_nonnegative("friction", contact.friction);
      core::require_nonnegative("torsional", contact.torsional);
      core::require_nonnegative("rolling", contact.rolling);
      const int a = find(contact.a), b = find(contact.b);
      contacts_[{std::min(a, b), std::max(a, b)}] = &contact;
    }
  }

  /// Sets the friction of a pair. Moments and priorities follow MuJoCo's rules; μ is the harmonic mean, which is nearer to the smoother surface.
  void set_friction(const Geometry& a, const Geometry& b, Pair& pair) const {
    if (const auto own = contacts_.find({pair.geometry_a, pair.geometry_b}); own != contacts_.end()) {
      pair.friction = own->second->friction;
      pair.torsional = own->second->torsional;
      pair.rolling = own->second->rolling;
      return;
    }
    const SurfaceRule &one = a.rule, &other = b.rule;
    const int lead = one.priority - other.priority;
    const int dimension = lead > 0 ? one.dimension : lead < 0 ? other.dimension : std::max(one.dimension, other.dimension);
    const auto larger = [&](double x, double y) { return lead > 0 ? x : lead < 0 ? y : std::max(x, y); };
    if (dimension == 1) return;
    pair.friction = lead > 0                      ? a.friction
                    : lead < 0                    ? b.friction
                    : a.friction + b.friction > 0 ? 2 * a.friction * b.friction / (a.friction + b.friction)
                                                  : 0.0;
    if (dimension >= 4) pair.torsional = larger(one.torsional, other.torsional);
    if (dimension == 6) pair.rolling = larger(one.rolling, other.rolling);
  }

  static bool masks_match(const ContactMask& a, const ContactMask& b) {
    if (a.file != b.file) return (a.type | a.affinity | b.type | b.affinity) != 0;
    return ((a.type & b.affinity) | (b.type & a.affinity)) != 0;
  }

  bool may_touch(const Geometry& a, const Geometry& b) const {
    const Body& body_a = m_.bodies[at(a.body)];
    const Body& body_b = m_.bodies[at(b.body)];
    if (body_a.dofs.empty() && body_b.dofs.empty()) return false;
    const int index_a = static_cast<int>(&a - m_.geometries.data()), index_b = static_cast<int>(&b - m_.geometries.data());
    if (!masks_match(parts_.masks[at(index_a)], parts_.masks[at(index_b)]) && !contacts_.contains({index_a, index_b})) return false;
    const int group_a = parts_.group[at(a.body)], group_b = parts_.group[at(b.body)];
    return group_a != group_b && !parts_.adjacent.contains({group_a, group_b}) && !parts_.adjacent.contains({group_b, group_a});
  }

  /// False for a pair of an object and a link that may not touch objects (RobotSpec::push_with).
  bool may_push(const Geometry& a, const Geometry& b) const {
    const Body &object = m_.bodies[at(a.body)], &link = m_.bodies[at(b.body)];
    if (object.kind != BodyKind::Object || link.kind != BodyKind::Robot) return true;
    const RobotSpec& robot = m_.scene.robots[at(link.owner)];
    const std::string_view name = std::string_view(link.name).substr(robot.name.size() + 1);
    return robot.push_with.empty() ||
           std::any_of(robot.push_with.begin(), robot.push_with.end(), [&](const auto& pattern) { return matches_pattern(pattern, name); });
  }

  /// Ball that a geometry never leaves, whatever moves.
  Ball ball_of(const Geometry& geometry, const Kinematics& kinematics, const Eigen::VectorXd& q) const {
    const Body& body = m_.bodies[at(geometry.body)];
    const Ball ball = calc_reach_ball(m_, kinematics, q, body, kinematics.X_WB[at(geometry.body)] * geometry.p_BCenter);
    return {ball.center, kBeyondLimits * ball.radius + geometry.bounding_radius};
  }

  /// True if two geometries are always farther apart than max_distance [m], whatever moves. A fixed half-space or box counts with its shape, any
  /// other geometry with its ball.
  bool never_meet(const Ball& a, const Ball& b, const Geometry& other, const Kinematics& rest, double max_distance) const {
    double gap = (a.center - b.center).norm() - a.radius - b.radius;
    if (m_.bodies[at(other.body)].kind == BodyKind::Fixed) {
      const Pose X_WG = rest.X_WB[at(other.body)] * other.X_BG;
      const Eigen::Vector3d p_G = X_WG.R.transpose() * (a.center - X_WG.p);
      if (std::holds_alternative<HalfSpace>(other.shape)) gap = p_G.z() - a.radius;
      if (const Box* const box = std::get_if<Box>(&other.shape)) gap = (p_G.cwiseAbs() - box->half_extents).cwiseMax(0).norm() - a.radius;
    }
    return gap > max_distance;
  }

  /// True if two links of one robot overlap at rest. Such an overlap is by design, so the links form no pair.
  bool overlap_at_rest(const Geometry& a, const Geometry& b, const Kinematics& rest) {
    const Body &body_a = m_.bodies[at(a.body)], &body_b = m_.bodies[at(b.body)];
    if (body_a.kind != BodyKind::Robot || body_b.kind != BodyKind::Robot || body_a.owner != body_b.owner) return false;
    if (!overlap(a.shape, rest.X_WB[at(a.body)] * a.X_BG, b.shape, rest.X_WB[at(b.body)] * b.X_BG)) return false;
    const std::string& robot = m_.robots[at(body_a.owner)].name;
    const auto link = [&](const Body& body) { return std::string_view(body.name).substr(robot.size() + 1); };
    auto& names = overlapping_[robot];
    if (const std::string pair = fmt::format("{} and {}", link(body_a), link(body_b)); names.empty() || names.back() != pair)
      names.push_back(pair);
    return true;
  }

  Eigen::VectorXd rest_configuration() {
    Eigen::VectorXd q = m_.neutral;
    if (auto& rest = m_.scene.rest; !rest.empty()) {
      const auto own = own_joint_values(m_.links, m_.n_vu, m_.n_a,
                                        Eigen::Map<const Eigen::VectorXd>(rest.data(), static_cast<Eigen::Index>(rest.size())));
      if (!own) core::require_size("rest", static_cast<long>(rest.size()), m_.n_a);
      core::require_finite("rest", rest);
      q.tail(m_.n_a) = *own;
      rest.assign(own->begin(), own->end());
    }
    return q;
  }

  ModelParts& parts_;
  Model::Impl& m_;
  std::map<std::pair<int, int>, const ContactSpec*> contacts_{};   ///< by the indices of the two geometries, the smaller first
  std::map<std::string, std::vector<std::string>> overlapping_{};  ///< pairs of links per robot
};

}  // namespace

void add_pairs(ModelParts& parts) { PairFinder(parts).add_pairs(); }

}  // namespace stiction::world
