#include "stiction/planning/tools.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

constexpr double kTool = 0.5;        ///< share of the drawn subgoals that are about tools
constexpr double kBehindDraw = 0.8;  ///< share of these subgoals that are places from which the tool can push
constexpr int kDraws = 20;           ///< most draws of such a place
constexpr int kAdvances = 30;        ///< most steps in which a tool approaches an object
constexpr double kAway = 0.3;        ///< least cosine between the way of the pushed object and the contact normal
constexpr double kStanding = 0.5;    ///< share of the places at the present height of the tool

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Lower bound on the distance of a pair, from its bounding spheres.
double gap_of_spheres(const world::Model& model, const world::Kinematics& kinematics, int pair) {
  const auto& a = model.geometries()[at(model.pairs()[at(pair)].geometry_a)];
  const auto& b = model.geometries()[at(model.pairs()[at(pair)].geometry_b)];
  const Eigen::Vector3d between = kinematics.X_WB[at(a.body)] * a.p_BCenter - kinematics.X_WB[at(b.body)] * b.p_BCenter;
  return between.norm() - a.bounding_radius - b.bounding_radius;
}

}  // namespace

Tools::Tools(const Setting& setting) : setting_(setting) {
  const world::Model& model = setting.model;
  const auto n = model.objects().size();
  const Eigen::Vector3d& gravity = model.scene().gravity;
  up_ = gravity.norm() > 0 ? Eigen::Vector3d(-gravity.normalized()) : Eigen::Vector3d::Zero();
  meetings_.resize(n);
  radii_.assign(n, 0);
  for (const auto& geometry : model.geometries()) {
    const auto owner = std::ranges::find_if(model.objects(), [&](const auto& object) { return object.body == geometry.body; });
    object_of_.push_back(owner == model.objects().end() ? -1 : static_cast<int>(owner - model.objects().begin()));
    if (object_of_.back() >= 0)
      radii_[at(object_of_.back())] = std::max(radii_[at(object_of_.back())], geometry.p_BCenter.norm() + geometry.bounding_radius);
  }
  std::vector<char> held(n, 0), wanted(n, 0);  // robots can touch it; it is or carries an object that they cannot touch
  for (const int o : setting.goal.out_of_touch()) {
    for (const int carrier : chain_of(model, o)) wanted[at(carrier)] = 1;
  }
  for (std::size_t i = 0; i < model.pairs().size(); ++i) {
    const auto& pair = model.pairs()[i];
    const int a = object_of_[at(pair.geometry_a)], b = object_of_[at(pair.geometry_b)];  // in a pair, objects come first
    if (a >= 0 && setting.chains.mask_of_pair(static_cast<int>(i)) != 0) held[at(a)] = 1;
    if (b >= 0 && wanted[at(a)] != wanted[at(b)])
      meetings_[at(wanted[at(a)] ? b : a)].push_back({static_cast<int>(i), wanted[at(a)] ? a : b});
  }
  for (std::size_t o = 0; o < n; ++o) {
    if (held[o] != 0 && !meetings_[o].empty()) objects_.push_back(static_cast<int>(o));
  }
}

int Tools::draw(core::Random& random) const {
  if (objects_.empty() || !random.chance(kTool)) return -1;
  return objects_[at(random.index(static_cast<int>(objects_.size())))];
}

void Tools::draw_place(int object, const Eigen::VectorXd& q, core::Random& random, contact::GeometryWorkspace& work,
                       Eigen::VectorXd& q_u) const {
  if (random.chance(kBehindDraw) && draw_behind(object, q, random, work, q_u)) return;
  draw_anywhere(object, q, random, q_u);
}

Eigen::Vector3d Tools::draw_level(core::Random& random) const {
  Eigen::Vector3d direction(random.normal(), random.normal(), random.normal());
  direction -= direction.dot(up_) * up_;
  return direction.normalized();
}

/// Pose of the object, turned by a random angle about the vertical, or about a random axis without gravity.
world::Pose Tools::turned(int object, const Eigen::VectorXd& q, core::Random& random) const {
  world::Pose X_WB = world::object_pose(setting_.model, q, object);
  const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
  const Eigen::Vector3d axis =
      up_.norm() > 0 ? up_ : Eigen::Vector3d(Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized());
  X_WB.R = Eigen::AngleAxisd(angle, axis).toRotationMatrix() * X_WB.R;
  return X_WB;
}

void Tools::put(int object, const world::Pose& X_WB, Eigen::VectorXd& q) const {
  const auto& info = setting_.model.objects()[at(object)];
  q.segment(info.q_begin, info.n_q) = setting_.goal.space().coordinates(object, X_WB);
}

/// Draws a place within the longest way of the goal's objects to the goal, and at least within twice the size of the tool.
void Tools::draw_anywhere(int object, const Eigen::VectorXd& q, core::Random& random, Eigen::VectorXd& q_u) const {
  const world::Model& model = setting_.model;
  const auto& info = model.objects()[at(object)];
  double range = 2 * model.scales().object(object).length;
  for (const int o : setting_.goal.objects()) {
    Eigen::VectorXd q_goal = q;
    q_goal.head(model.n_qu()) = setting_.goal.nearest_to(q.head(model.n_qu()));
    range = std::max(range, (world::object_pose(model, q_goal, o).p - world::object_pose(model, q, o).p).norm());
  }
  if (info.n_v == 1) {  // a hinge or a slider
    const world::Dof& dof = model.dofs()[at(info.v_begin)];
    const double most = dof.kind == world::DofKind::Revolute ? std::numbers::pi : range;
    const double lower = std::max(dof.lower, q[info.q_begin] - most), upper = std::min(dof.upper, q[info.q_begin] + most);
    q_u[info.q_begin] = random.uniform(std::min(lower, upper), upper);
    return;
  }
  world::Pose X_WB = turned(object, q, random);
  X_WB.p += random.uniform(0, range) * draw_level(random);
  put(object, X_WB, q_u);
}

/// Moves the object along a direction until it touches an object of the goal. Each step is as long as the free distance.
bool Tools::slide_to(int object, const Eigen::Vector3d& direction, Eigen::VectorXd& q, contact::GeometryWorkspace& work, Meeting& met,
                     contact::Distance& distance) const {
  const world::Model& model = setting_.model;
  world::Pose X_WB = world::object_pose(model, q, object);
  double travelled = 0;
  for (int k = 0; k < kAdvances; ++k) {
    put(object, X_WB, q);
    world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
    double least = std::numeric_limits<double>::infinity();
    for (const Meeting& meeting : meetings_[at(object)]) {
      if (gap_of_spheres(model, work.kinematics, meeting.pair) > least) continue;
      const contact::Distance d = contact::pair_distance(model, work.kinematics, meeting.pair, work.contact_work);
      if (d.phi < least) least = d.phi, met = meeting, distance = d;
    }
    if (least < 0) return false;
    if (least < 0.5 * model.scales().contact_tolerance(met.pair)) return true;
    travelled += least;
    if (travelled > 2 * (radii_[at(object)] + radii_[at(met.of_goal)])) return false;  // the object has passed the other one
    X_WB.p += least * direction;
  }
  return false;
}

/// True if nothing overlaps the object. Robots do not count, because they will be elsewhere.
bool Tools::is_free_there(int object, contact::GeometryWorkspace& work) const {
  const world::Model& model = setting_.model;
  contact::Gaps gaps(model, work.kinematics, work.contact_work);
  for (std::size_t i = 0; i < model.pairs().size(); ++i) {
    const auto& pair = model.pairs()[i];
    const bool a = object_of_[at(pair.geometry_a)] == object, b = object_of_[at(pair.geometry_b)] == object;
    if (a == b || setting_.chains.mask_of_pair(static_cast<int>(i)) != 0) continue;
    const double least = -model.scales().contact_tolerance(static_cast<int>(i));
    if (gaps.calc(static_cast<int>(i), least) < least) return false;
  }
  return true;
}

/// Cosine between the contact normal towards the goal's object and the way of the touched point to the goal.
double Tools::goes_away(const Meeting& met, const contact::Distance& distance, const Eigen::VectorXd& q,
                        contact::GeometryWorkspace& work) const {
  const world::Model& model = setting_.model;
  const Eigen::VectorXd q_u = q.head(model.n_qu());
  const Eigen::VectorXd e = setting_.goal.difference(q_u, setting_.goal.nearest_to(q_u));
  const bool first = object_of_[at(model.pairs()[at(met.pair)].geometry_a)] == met.of_goal;
  const Eigen::Vector3d point = first ? distance.p_WA : distance.p_WB;
  const Eigen::Vector3d normal = first ? distance.nhat_BA_W : Eigen::Vector3d(-distance.nhat_BA_W);
  Eigen::Vector3d way = Eigen::Vector3d::Zero();
  for (const int o : chain_of(model, met.of_goal)) {
    const auto& info = model.objects()[at(o)];
    for (int v = info.v_begin; v < info.v_begin + info.n_v; ++v) {
      const Eigen::Vector3d axis = work.kinematics.axis_W.col(v), origin = work.kinematics.origin_W.col(v);
      way += e[v] * (model.dofs()[at(v)].kind == world::DofKind::Revolute ? Eigen::Vector3d(axis.cross(point - origin)) : axis);
    }
  }
  return way.norm() > 0 ? normal.dot(way.normalized()) : 0;
}

bool Tools::draw_behind(int object, const Eigen::VectorXd& q, core::Random& random, contact::GeometryWorkspace& work,
                        Eigen::VectorXd& q_u) const {
  const auto& meetings = meetings_[at(object)];
  const auto& info = setting_.model.objects()[at(object)];
  if (info.n_v == 1 || info.parent >= 0) return false;  // an object on a joint cannot be put there
  Eigen::VectorXd placed = q;
  for (int k = 0; k < kDraws && !work.stop(); ++k) {
    const int target = meetings[at(random.index(static_cast<int>(meetings.size())))].of_goal;
    const Eigen::Vector3d direction = draw_level(random), centre = world::object_pose(setting_.model, q, target).p;
    world::Pose X_WB = turned(object, q, random);
    const double height = up_.dot(X_WB.p - centre), reach = radii_[at(object)] + radii_[at(target)];
    const double level = random.chance(kStanding) ? height : random.uniform(-radii_[at(target)], radii_[at(target)]);
    const Eigen::Vector3d aside = direction.cross(up_.norm() > 0 ? up_ : draw_level(random)).normalized();
    X_WB.p = centre + level * up_ - reach * direction + random.uniform(-1, 1) * radii_[at(target)] * aside;
    put(object, X_WB, placed);
    Meeting met{};
    contact::Distance distance;
    if (!slide_to(object, direction, placed, work, met, distance) || goes_away(met, distance, placed, work) < kAway ||
        !is_free_there(object, work))
      continue;
    q_u.segment(info.q_begin, info.n_q) = placed.segment(info.q_begin, info.n_q);
    return true;
  }
  return false;
}

std::vector<char> Tools::touchable(const std::vector<int>& objects, const Eigen::VectorXd& q, contact::GeometryWorkspace& work) const {
  const world::Model& model = setting_.model;
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  std::vector<char> held(model.objects().size(), 0);
  for (const int object : objects) {
    for (const int o : chain_of(model, object)) held[at(o)] = 1;
  }
  const std::vector<char> moved = held;
  contact::Gaps gaps(model, work.kinematics, work.contact_work);
  const auto pairs = model.pairs();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const int a = object_of_[at(pairs[i].geometry_a)], b = object_of_[at(pairs[i].geometry_b)];
    if (a < 0 || b < 0 || moved[at(a)] == moved[at(b)]) continue;
    const double near = threshold::kForceReach * model.scales().pair(static_cast<int>(i)).length;
    if (gaps.calc(static_cast<int>(i), near) < near) held[at(a)] = held[at(b)] = 1;
  }
  std::vector<char> out(pairs.size(), 0);
  bool any = false;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!setting_.chains.touches_object(static_cast<int>(i)) || setting_.chains.mask_of_pair(static_cast<int>(i)) == 0) continue;
    out[i] = held[at(object_of_[at(pairs[i].geometry_a)])];
    any |= out[i] != 0;
  }
  return any ? out : std::vector<char>{};
}

}  // namespace stiction::planning
