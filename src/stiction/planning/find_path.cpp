#include "stiction/planning/regrasp.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "stiction/world/scales.hpp"

namespace stiction::planning {
namespace {

using Posture = Eigen::VectorXd;

/// Postures that differ by less are one [joint units].
constexpr double kNoMove = 1e-12;

/// Collision queries of the moving branches among objects at rest, wherever they may be.
class FreeSpace {
 public:
  FreeSpace(const world::Model& model, const RobotChains& chains, ChainMask moving, std::span<const Eigen::VectorXd> places,
            double clearance, GeometryWorkspace& work)
      : model_(model), work_(work), places_(places.begin(), places.end()), clearance_(clearance), joints_(chains.joints_of(moving)) {
    chains.pairs_of(moving, pairs_);
    std::copy_if(pairs_.begin(), pairs_.end(), std::back_inserter(object_pairs_), [&](int pair) { return chains.touches_object(pair); });
  }

  const std::vector<int>& joints() const { return joints_; }
  bool stop() const { return work_.stop(); }

  /// The longest move of a joint on the way, in joint units.
  double move(const Posture& from, const Posture& to) const {
    double longest = 0;
    for (const int j : joints_) longest = std::max(longest, std::abs(to[j] - from[j]) / model_.scales().joint(j));
    return longest;
  }

  /// Smallest gap minus the clearance.
  double room(const Posture& q_a) {
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::VectorXd& q : places_) {
      const auto& pairs = &q == &places_.front() ? pairs_ : object_pairs_;  // the others are the same at all places
      q.tail(model_.n_a()) = q_a;
      world::calc_kinematics(model_, q, work_.kinematics_work, work_.kinematics);
      least = std::min(least, contact::calc_min_distance(model_, work_.kinematics, pairs, clearance_, work_.contact_work) - clearance_);
      if (least < 0) break;
    }
    return least;
  }

  /// The straight line is free. Advances by what the room at each posture allows: no point of the moving branches travels farther
  /// than Σ reach_j |Δq_j|, and both sides of a pair may move.
  bool line(const Posture& from, const Posture& to) {
    double speed = 0;
    for (const int j : joints_) speed += model_.reach()[j] * std::abs(to[j] - from[j]);
    const double length = move(from, to);
    if (length < kNoMove) return true;
    const double shortest = std::min(1.0, 0.02 / length);  // below this resolution the clearance itself is the guard
    for (double t = 0; t < 1.0;) {
      const double r = room((1 - t) * from + t * to);
      if (r < 0) return false;
      t += std::max(shortest, r / (2 * speed));
    }
    return room(to) >= 0;
  }

 private:
  const world::Model& model_;
  GeometryWorkspace& work_;
  std::vector<Eigen::VectorXd> places_;
  double clearance_;
  std::vector<int> joints_;
  std::vector<int> pairs_, object_pairs_;
};

struct PathTree {
  std::vector<Posture> postures;
  std::vector<int> parents;

  explicit PathTree(const Posture& root) : postures{root}, parents{-1} {}
  int nearest(const Posture& q_a) const {
    int best = 0;
    double best_distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < postures.size(); ++i) {
      const double d = (postures[i] - q_a).squaredNorm();
      if (d < best_distance) {
        best_distance = d;
        best = static_cast<int>(i);
      }
    }
    return best;
  }
  int add(const Posture& q_a, int parent) {
    postures.push_back(q_a);
    parents.push_back(parent);
    return static_cast<int>(postures.size()) - 1;
  }
  std::vector<Posture> to_root(int i) const {
    std::vector<Posture> path;
    for (; i >= 0; i = parents[static_cast<std::size_t>(i)]) path.push_back(postures[static_cast<std::size_t>(i)]);
    return path;
  }
};

/// One extension towards the target by at most `step`; the new node, or −1 when the line is blocked.
int extend(PathTree& tree, const Posture& target, double step, FreeSpace& space) {
  const int near = tree.nearest(target);
  const Posture& from = tree.postures[static_cast<std::size_t>(near)];
  const double length = space.move(from, target);
  if (length < kNoMove) return near;
  const Posture to = from + std::min(1.0, step / length) * (target - from);
  return space.line(from, to) ? tree.add(to, near) : -1;
}

std::pair<double, double> search_range(const world::Model& model, int joint, double a, double b) {
  // The surroundings of the two ends; the limits where those are nearer.
  const double pad = 0.8 * model.scales().joint(joint);
  return {std::max(model.lower()[joint], std::min(a, b) - pad), std::min(model.upper()[joint], std::max(a, b) + pad)};
}

bool connect(const world::Model& model, const Posture& start, const Posture& goal, const PathOptions& options, core::Random& random,
             FreeSpace& space, std::vector<Posture>& path) {
  if (space.line(start, goal)) {
    path = {start, goal};
    return true;
  }
  PathTree trees[2] = {PathTree(start), PathTree(goal)};
  for (int k = 0, side = 0; k < options.max_extensions && !space.stop(); ++k, side = 1 - side) {
    Posture target = start;
    for (const int j : space.joints()) {
      const auto [low, high] = search_range(model, j, start[j], goal[j]);
      target[j] = random.uniform(low, high);
    }
    const int grown = extend(trees[side], target, options.step, space);
    if (grown < 0) continue;
    const Posture reached = trees[side].postures[static_cast<std::size_t>(grown)];
    for (;;) {  // the other tree goes for it greedily
      const int other = extend(trees[1 - side], reached, options.step, space);
      if (other < 0) break;
      if (space.move(trees[1 - side].postures[static_cast<std::size_t>(other)], reached) > kNoMove) continue;
      const int at_start = side == 0 ? grown : other;
      const int at_goal = side == 0 ? other : grown;
      path = trees[0].to_root(at_start);
      std::reverse(path.begin(), path.end());
      const auto rest = trees[1].to_root(at_goal);
      path.insert(path.end(), rest.begin() + 1, rest.end());
      return true;
    }
  }
  return false;
}

void shortcut(const PathOptions& options, core::Random& random, FreeSpace& space, std::vector<Posture>& path) {
  for (int attempt = 0; attempt < options.shortcuts && path.size() > 2; ++attempt) {
    const int n = static_cast<int>(path.size());
    const int a = random.index(n - 2);
    const int b = a + 2 + random.index(n - 2 - a);
    if (space.line(path[static_cast<std::size_t>(a)], path[static_cast<std::size_t>(b)]))
      path.erase(path.begin() + a + 1, path.begin() + b);
  }
}

}  // namespace

PathOutcome find_path(const world::Model& model, const RobotChains& chains, ChainMask moving, std::span<const Eigen::VectorXd> places,
                      const Eigen::VectorXd& q_a_start, const Eigen::VectorXd& q_a_goal, const PathOptions& options, core::Random& random,
                      GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path) {
  path.clear();
  Posture start = q_a_start, goal = q_a_goal;
  if (!retreat(model, chains, moving, options.clearance, places, start, work, path)) return PathOutcome::StartBlocked;
  std::vector<Posture> approach;
  if (!retreat(model, chains, moving, options.clearance, places, goal, work, approach)) return PathOutcome::GoalBlocked;

  FreeSpace space(model, chains, moving, places, options.clearance * (1 - 1e-6), work);
  std::vector<Posture> middle;
  if (!connect(model, start, goal, options, random, space, middle)) return PathOutcome::NotFound;
  shortcut(options, random, space, middle);
  path.insert(path.end(), middle.begin() + 1, middle.end());
  for (auto it = approach.rbegin(); it != approach.rend(); ++it) {
    if (it != approach.rbegin()) path.push_back(*it);
  }
  path.push_back(q_a_goal);
  return PathOutcome::Found;
}

PathOutcome find_path(const world::Model& model, const RobotChains& chains, ChainMask moving, const Eigen::VectorXd& q,
                      const Eigen::VectorXd& q_a_goal, const PathOptions& options, core::Random& random, GeometryWorkspace& work,
                      std::vector<Eigen::VectorXd>& path) {
  return find_path(model, chains, moving, std::span(&q, 1), q.tail(model.n_a()), q_a_goal, options, random, work, path);
}

}  // namespace stiction::planning
