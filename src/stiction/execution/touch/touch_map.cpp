#include "stiction/execution/touch/touch_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/touch/joint_path.hpp"
#include "stiction/world/robot_chains.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::execution {

using contact::PathOutcome;
using Eigen::VectorXd;

namespace {

world::FixedSpec make_ball(const std::string& name, const TouchedPlace& place, double radius) {
  world::FixedSpec out;
  out.name = name;
  out.X_WB.p = place.p_W - radius * place.n_W;
  out.geometries = {{.name = "ball", .shape = world::Sphere{radius + place.spread}, .X_BG = {}}};
  return out;
}

/// Computes distances of the arm from all bodies, or from fixed bodies only.
class Room {
 public:
  Room(const world::Model& model, bool fixed_alone) : model_(model), work_(model), q_(model.neutral()) {
    const world::RobotChains chains(model);
    std::vector<int> pairs;
    chains.pairs_of(chains.all(), pairs);
    for (const int p : pairs) {
      const world::Pair& pair = model.pairs()[static_cast<std::size_t>(p)];
      const int body = model.geometries()[static_cast<std::size_t>(pair.geometry_b)].body;
      if (!fixed_alone || model.bodies()[static_cast<std::size_t>(body)].kind == world::BodyKind::Fixed) pairs_.push_back(p);
    }
  }

  bool is_at_least(const VectorXd& q_a, double distance) {
    place(q_a);
    return !contact::any_nearer(model_, work_.kinematics, pairs_, distance, work_.contact_work);
  }

  /// True if the straight line between two postures is free. Postures are checked in steps within which no gap shrinks by more than its size at the step's
  /// begin: both sides of a pair may move, and no point of either travels farther than (G.1). The line keeps half of the clearance, or the smaller gap at one
  /// of its ends. In that case a step shrinks gaps by at most half of the clearance, and an overlap between two checks is less than a quarter of it.
  bool is_free(const VectorXd& from, const VectorXd& to, double clearance) {
    const double travel = calc_travel(model_, from, to), half = 0.5 * clearance;
    const double least = std::min({half, calc_gap(from), calc_gap(to)});
    if (least < 0) return false;
    for (double s = 0; s < 1;) {
      const double gap = calc_gap((1 - s) * from + s * to);
      if (gap < least) return false;
      s += std::max(gap, half) / (2 * travel);
    }
    return true;
  }

 private:
  /// Smallest gap if nothing overlaps, else any negative number [m].
  double calc_gap(const VectorXd& q_a) {
    place(q_a);
    return contact::calc_min_distance(model_, work_.kinematics, pairs_, 0, work_.contact_work);
  }

  void place(const VectorXd& q_a) {
    q_.tail(model_.n_a()) = q_a;
    world::calc_kinematics(model_, q_, work_.kinematics_work, work_.kinematics);
  }

  const world::Model& model_;
  contact::GeometryWorkspace work_;
  VectorXd q_;
  std::vector<int> pairs_;
};

/// Number of paths searched, of which the one with the least travel is taken: the lengths of paths from random trees differ by a factor.
constexpr int kPaths = 8;

/// Options of the path search. The clearance is the share of the length of the robots that regrasps keep as well.
contact::PathOptions make_path_options(const world::Model& known) {
  contact::PathOptions out;
  out.clearance = world::share::kClearance * known.scales().robots().length;
  out.max_extensions = 1000;
  out.shortcuts = 60;
  return out;
}

/// Checks every line of a path once more, since no simulation tests a route before the arm follows it.
bool is_free(Room& room, std::span<const VectorXd> path, double clearance) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (!room.is_free(path[i - 1], path[i], clearance)) return false;
  return true;
}

void find_shortest(const world::Model& model, const VectorXd& goal, const contact::PathOptions& options, core::Random& random,
                   const core::RunControl& control, Room& room, Route& out) {
  const world::RobotChains chains(model);
  contact::GeometryWorkspace work(model);
  work.control = &control;
  VectorXd q = model.neutral();
  q.tail(model.n_a()) = out.retreat.back();
  for (int k = 0; k < kPaths; ++k) {
    std::vector<VectorXd> path;
    const PathOutcome outcome = contact::find_path(model, chains, chains.all(), q, goal, options, random, work, path);
    if (outcome != PathOutcome::Found) {
      if (out.outcome != PathOutcome::Found) out.outcome = outcome;
      if (outcome != PathOutcome::NotFound) return;
      continue;
    }
    path.insert(path.begin(), out.retreat.back());
    if (path.size() > 2 && path[path.size() - 2] == path.back()) path.pop_back();
    if (!is_free(room, path, options.clearance)) continue;
    double travel = 0;
    for (std::size_t i = 1; i < path.size(); ++i) travel += calc_travel(model, path[i - 1], path[i]);
    if (out.outcome == PathOutcome::Found && travel >= out.travel) continue;
    out.outcome = outcome, out.travel = travel, out.postures = std::move(path);
    if (out.postures.size() == 2) return;  // a straight line cannot be improved
  }
}

}  // namespace

TouchMap::TouchMap(std::shared_ptr<const world::Model> known) : known_(std::move(known)) {}

double TouchMap::find_radius(const TouchedPlace& place, std::span<const VectorXd> visited) const {
  double radius = known_->scales().robots().length;
  for (int k = 0; k <= kHalves; ++k, radius /= 2) {
    world::Scene scene = known_->scene();
    scene.fixed = {make_ball("touch", {place.p_W, place.n_W, 0}, radius)};
    scene.filters.clear(), scene.contacts.clear();  // they may name bodies that are left out
    const auto model = world::Model::make(scene);
    Room room(*model, true);
    if (std::all_of(visited.begin(), visited.end(), [&](const VectorXd& q_a) { return room.is_at_least(q_a, -place.spread); }))
      return radius;
  }
  return 0;
}

void TouchMap::add(const TouchedPlace& place, double radius) {
  core::require_positive("radius", radius);
  balls_.push_back({place, radius});
}

std::shared_ptr<const world::Model> TouchMap::make_model(double share) const {
  world::Scene scene = known_->scene();
  for (const Ball& ball : balls_)
    scene.fixed.push_back(make_ball(fmt::format("touch_{}", &ball - balls_.data() + 1), ball.place, share * ball.radius));
  return world::Model::make(scene);
}

Route find_route(const TouchMap& map, std::span<const VectorXd> way, const VectorXd& goal, core::Random& random,
                 const core::RunControl& control) {
  const contact::PathOptions options = make_path_options(map.known());
  Route out;
  for (int k = 0; k <= TouchMap::kHalves && !control.stop(); ++k) {
    out = {};
    out.share = std::ldexp(1.0, -k);
    out.model = map.make_model(out.share);
    Room room(*out.model, false);
    std::size_t i = way.size();
    while (i > 0 && !room.is_at_least(way[i - 1], options.clearance)) out.retreat.push_back(way[--i]);
    if (i == 0) {
      out.outcome = PathOutcome::StartBlocked;
    } else if (!room.is_at_least(goal, 0)) {
      out.outcome = PathOutcome::GoalBlocked;  // find_path would search until its limit
    } else {
      out.retreat.push_back(way[i - 1]);
      find_shortest(*out.model, goal, options, random, control, room, out);
    }
    if (out.outcome == PathOutcome::Found || map.size() == 0) break;
  }
  return out;
}

std::string describe(PathOutcome outcome) {
  switch (outcome) {
    case PathOutcome::Found:
      return "a way was found";
    case PathOutcome::StartBlocked:
      return "there is no room where the arm is, nor on the way that it came";
    case PathOutcome::GoalBlocked:
      return "the goal lies in what was touched";
    case PathOutcome::NotFound:
      return "no way to the goal was found among what was touched";
  }
  return "";
}

}  // namespace stiction::execution
