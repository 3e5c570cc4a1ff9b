#include "stiction/contact/free_path.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "stiction/contact/clearance.hpp"
#include "stiction/contact/gap_gradient.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::contact {

using world::ChainMask;
using world::RobotChains;

namespace {

using Posture = Eigen::VectorXd;

/// Postures that differ by less are one [joint units].
constexpr double kNoMove = 1e-12;
/// Of a path that keeps no clearance, or nearly none: gaps are looked at after every move that may shrink them by this [L of the robots].
constexpr double kLeastClearance = 1e-3;

/// A joint (index in u), and a bound on how far it moves one side of a pair against the other [m per joint unit].
using Lever = std::pair<int, double>;

/// The joints that move the two sides of a pair against each other: those that move one side alone. A joint that moves both moves them as one.
std::vector<Lever> calc_levers(const world::Model& model, const world::Pair& pair) {
  const auto axes_of = [&](int geometry) {
    const int body = model.geometries()[static_cast<std::size_t>(geometry)].body;
    std::vector<int> axes = model.bodies()[static_cast<std::size_t>(body)].axes;
    std::ranges::sort(axes);
    return axes;
  };
  const std::vector<int> a = axes_of(pair.geometry_a), b = axes_of(pair.geometry_b);
  std::vector<int> axes;
  std::ranges::set_symmetric_difference(a, b, std::back_inserter(axes));
  std::vector<Lever> out;
  for (const int axis : axes) {
    const bool follows = axis >= model.n_v();
    const world::Follower* follower = follows ? &model.followers()[static_cast<std::size_t>(axis - model.n_v())] : nullptr;
    const int joint = (follows ? follower->dof : axis) - model.n_vu();
    if (joint < 0) continue;  // of an object, which stays where it is
    const bool slides = follows && follower->kind == world::DofKind::Prismatic;
    out.emplace_back(joint, std::max(model.reach()[joint], slides ? std::abs(follower->ratio) : 0.0));
  }
  return out;
}

/// Collision queries of the moving branches among objects at rest.
class FreeSpace {
 public:
  FreeSpace(const world::Model& model, const RobotChains& chains, ChainMask moving, const Eigen::VectorXd& q, double clearance,
            GeometryWorkspace& work)
      : model_(model),
        work_(work),
        q_(q),
        least_(std::max(clearance, kLeastClearance * model.scales().robots().length)),
        joints_(chains.joints_of(moving)) {
    std::vector<int> pairs;
    chains.pairs_of(moving, pairs);
    const PairClearances clearances = split_by_clearance(model, pairs, clearance, work.contact_work);
    for (const int pair : clearances.pairs) add(pair, clearance);
    for (const auto& [pair, own] : clearances.close) add(pair, own);
    travel_.resize(levers_.size());
  }

  const std::vector<int>& joints() const { return joints_; }
  bool stop() const { return work_.stop(); }

  /// The longest move of a joint on the way, in joint units.
  double move(const Posture& from, const Posture& to) const {
    double longest = 0;
    for (const int j : joints_) longest = std::max(longest, std::abs(to[j] - from[j]) / model_.scales().joint(j));
    return longest;
  }

  /// The straight line is free. Each pair is looked at again where its last gap may have been used up by what moves it, and not before it shrank
  /// by the least clearance: between two postures that keep the clearance a gap is never less than half of it.
  bool line(const Posture& from, const Posture& to) {
    if (move(from, to) < kNoMove) return true;
    const double longest = calc_travel(from, to);
    place(to);  // where most of the lines that are blocked are
    under_way_.clear();
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const double free = calc_free(pairs_[i], 1);
      if (free < 0) return block(i);
      if (free < 1) under_way_.push_back({i, 0, 1 - free});
    }
    std::ranges::make_heap(under_way_, std::greater(), &UnderWay::from);
    while (!under_way_.empty()) {
      const double t = under_way_.front().from;
      place((1 - t) * from + t * to);
      while (!under_way_.empty() && under_way_.front().from < t + least_ / longest) {
        std::ranges::pop_heap(under_way_, std::greater(), &UnderWay::from);
        UnderWay& pair = under_way_.back();
        const double free = calc_free(pairs_[pair.index], pair.to - t);
        if (free < 0) return block(pair.index);
        pair.from = t + std::max(free, least_ / travel_[pairs_[pair.index].levers]);
        if (pair.from < pair.to)
          std::ranges::push_heap(under_way_, std::greater(), &UnderWay::from);
        else
          under_way_.pop_back();
      }
    }
    return true;
  }

 private:
  struct WatchedPair {
    int pair;
    double clearance;    ///< [m]
    std::size_t levers;  ///< what moves it
  };
  /// A pair that may come too near between two shares of a line.
  struct UnderWay {
    std::size_t index;
    double from, to;
  };

  void add(int pair, double clearance) {
    const std::vector<Lever> levers = calc_levers(model_, model_.pairs()[static_cast<std::size_t>(pair)]);
    const auto found = std::ranges::find(levers_, levers);
    pairs_.push_back({pair, clearance, static_cast<std::size_t>(found - levers_.begin())});
    if (found == levers_.end()) levers_.push_back(levers);
  }

  void place(const Posture& q_a) {
    q_.tail(model_.n_a()) = q_a;
    world::calc_kinematics(model_, q_, work_.kinematics_work, work_.kinematics);
  }

  /// By how much levers may shrink a gap on the straight line. @returns the most, at least the least clearance [m]
  double calc_travel(const Posture& from, const Posture& to) {
    double most = least_;
    for (std::size_t k = 0; k < levers_.size(); ++k) {
      travel_[k] = 0;
      for (const auto& [joint, lever] : levers_[k]) travel_[k] += lever * std::abs(to[joint] - from[joint]);
      most = std::max(most, travel_[k]);
    }
    return most;
  }

  /// The share of the line on which a pair keeps its clearance for certain, as it is placed now; < 0: it does not keep it. A bound is enough where it
  /// takes the pair a good part of what is left.
  double calc_free(const WatchedPair& pair, double left) {
    constexpr double kGoodPart = 0.25;
    const double travel = travel_[pair.levers], enough = pair.clearance + kGoodPart * left * travel, limit = pair.clearance + left * travel;
    const double gap = calc_gap(model_, work_.kinematics, pair.pair, enough, limit, work_.contact_work);
    return gap < limit ? (gap - pair.clearance) / travel : left;
  }

  /// What blocks one line is likely to block the next one. @returns false
  bool block(std::size_t i) {
    std::rotate(pairs_.begin(), pairs_.begin() + static_cast<std::ptrdiff_t>(i), pairs_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    return false;
  }

  const world::Model& model_;
  GeometryWorkspace& work_;
  Eigen::VectorXd q_;
  double least_;  ///< a gap is looked at after every move that may shrink it by this [m]
  std::vector<int> joints_;
  std::vector<WatchedPair> pairs_;
  std::vector<std::vector<Lever>> levers_;  ///< of the pairs, each once
  std::vector<double> travel_;              ///< of the levers, on the line in hand [m]
  std::vector<UnderWay> under_way_;
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

PathOutcome find_path(const world::Model& model, const RobotChains& chains, ChainMask moving, const Eigen::VectorXd& q,
                      const Eigen::VectorXd& q_a_goal, const PathOptions& options, core::Random& random, GeometryWorkspace& work,
                      std::vector<Eigen::VectorXd>& path) {
  path.clear();
  const int n_a = model.n_a();
  Eigen::VectorXd start = q, goal = q;
  goal.tail(n_a) = q_a_goal;
  if (!retreat(model, chains, moving, options.clearance, start, work, path)) return PathOutcome::StartBlocked;
  std::vector<Posture> approach;
  if (!retreat(model, chains, moving, options.clearance, goal, work, approach)) return PathOutcome::GoalBlocked;

  FreeSpace space(model, chains, moving, q, options.clearance * (1 - 1e-6), work);
  std::vector<Posture> middle;
  if (!connect(model, start.tail(n_a), goal.tail(n_a), options, random, space, middle)) return PathOutcome::NotFound;
  shortcut(options, random, space, middle);
  path.insert(path.end(), middle.begin() + 1, middle.end());
  for (auto it = approach.rbegin(); it != approach.rend(); ++it) {
    if (it != approach.rbegin()) path.push_back(*it);
  }
  path.push_back(q_a_goal);
  return PathOutcome::Found;
}

bool retreat(const world::Model& model, const RobotChains& chains, ChainMask moving, double clearance, Eigen::VectorXd& q,
             GeometryWorkspace& work, std::vector<Eigen::VectorXd>& path) {
  constexpr int kRounds = 30;
  constexpr double kStep = 0.04;     // per round and joint, so that the straight line between rounds stays clear [rad, L]
  constexpr double kDamping = 1e-4;  // ρ [L²]
  const int n_a = model.n_a();
  const auto joints = joint_flags(model, chains.joints_of(moving));
  chains.pairs_of(moving, work.pairs);
  const PairClearances own = split_by_clearance(model, work.pairs, clearance, work.contact_work);
  const auto clearance_of = [&](const Contact& c) {
    const auto found = std::ranges::find(own.close, c.pair, &std::pair<int, double>::first);
    return found != own.close.end() ? found->second : clearance;
  };
  const double length = model.scales().robots().length;
  const Eigen::VectorXd unit = model.scales().joints();
  for (int round = 0; round < kRounds && !work.stop(); ++round) {
    // δ = argmin ‖δ‖², in joint units, with every short gap brought to 1.5 × clearance: δ = Gᵀ(GGᵀ + ρI)⁻¹r
    world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
    query_pairs(model, work.kinematics, work.pairs, clearance, work.contact_work, work.contacts);
    std::erase_if(work.contacts, [&](const auto& c) { return c.phi >= clearance_of(c); });
    const auto m = static_cast<Eigen::Index>(work.contacts.size());
    if (m == 0) return true;
    Eigen::MatrixXd G(n_a, m);
    Eigen::VectorXd r(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      const Contact& contact = work.contacts[static_cast<std::size_t>(i)];
      calc_gap_gradient(model, contact, joints, work.kinematics, G.col(i));
      r[i] = 1.5 * clearance_of(contact) - contact.phi;
    }
    G = unit.asDiagonal() * G;
    Eigen::MatrixXd S = G.transpose() * G;
    S.diagonal().array() += kDamping * length * length;
    Eigen::VectorXd delta = G * S.ldlt().solve(r);
    const double largest = delta.cwiseAbs().maxCoeff();
    if (!(largest > 1e-9)) return false;
    delta *= std::min(1.0, kStep / largest);
    q.tail(n_a) = (q.tail(n_a) + delta.cwiseProduct(unit)).cwiseMax(model.lower()).cwiseMin(model.upper());
    path.push_back(q.tail(n_a));
  }
  return false;
}

}  // namespace stiction::contact
