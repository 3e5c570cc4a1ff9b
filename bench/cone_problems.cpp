#include "cone_problems.hpp"

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>

#include "stiction/core/random.hpp"

namespace stiction::bench {
namespace {

using core::Random;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kStep = 0.1;  // [s]
constexpr double kGravity = 9.81;

Vector3d unit(Random& random) {
  Vector3d v;
  do v = Vector3d(random.normal(), random.normal(), random.normal());
  while (v.norm() < 1e-3);
  return v.normalized();
}

/// Columns (n, t1, t2).
Matrix3d frame(const Vector3d& n) {
  const Vector3d other = std::abs(n.x()) < 0.7 ? Vector3d::UnitX() : Vector3d::UnitY();
  Matrix3d R;
  R.col(0) = n;
  R.col(1) = n.cross(other).normalized();
  R.col(2) = n.cross(R.col(1));
  return R;
}

Matrix3d skew(const Vector3d& r) {
  Matrix3d S;
  S << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return S;
}

/// Rows (n, μt1, μt2) of R applied to a point Jacobian, appended column-wise to a dense 3×k matrix.
struct Rows {
  Matrix3d R;
  double mu;
  Eigen::Matrix3Xd G{3, 0};
  void append(const Eigen::Matrix3Xd& J) {
    Eigen::Matrix3Xd add = R.transpose() * J;
    add.bottomRows<2>() *= mu;
    Eigen::Matrix3Xd all(3, G.cols() + add.cols());
    all << G, add;
    G = all;
  }
  void append_body(const Vector3d& arm, double sign) {
    append(sign * Matrix3d::Identity());
    append(-sign * skew(arm));
  }
  std::vector<double> row_major() const {
    std::vector<double> out;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < G.cols(); ++c) out.push_back(G(r, c));
    }
    return out;
  }
};

std::vector<int> range(int first, int n) {
  std::vector<int> v;
  for (int i = 0; i < n; ++i) v.push_back(first + i);
  return v;
}

std::vector<int> joined(std::vector<int> a, const std::vector<int>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Point Jacobian of a chain whose joint i has an axis through origin i; joints beyond `moving` do not move the point.
Eigen::Matrix3Xd chain_jacobian(const std::vector<Vector3d>& axes, const std::vector<Vector3d>& origins, const Vector3d& p, int moving) {
  Eigen::Matrix3Xd J = Eigen::Matrix3Xd::Zero(3, static_cast<int>(axes.size()));
  for (int i = 0; i < moving; ++i) J.col(i) = axes[static_cast<std::size_t>(i)].cross(p - origins[static_cast<std::size_t>(i)]);
  return J;
}

std::shared_ptr<cone::Layout> make_layout(ConeFamily family) {
  std::vector<std::vector<int>> groups;
  if (family == ConeFamily::Hand22) {
    for (int f = 0; f < 4; ++f) groups.push_back(range(4 * f, 4));
    groups.push_back(range(16, 6));
    auto layout = std::make_shared<cone::Layout>(22, groups);
    for (int f = 0; f < 4; ++f) layout->add_support(joined(groups[static_cast<std::size_t>(f)], range(16, 6)));
    layout->add_support(range(16, 6));
    return layout;
  }
  for (int b = 0; b < 10; ++b) groups.push_back(range(6 * b, 6));
  groups.push_back(range(60, 9));
  auto layout = std::make_shared<cone::Layout>(69, groups);
  for (int b = 0; b < 10; ++b) layout->add_support(b % 2 == 0 ? range(6 * b, 6) : joined(range(6 * (b - 1), 6), range(6 * b, 6)));
  for (int s = 0; s < 4; ++s) layout->add_support(joined(range(12 * s, 6), range(12 * s + 12, 6)));
  for (int b = 0; b < 10; ++b) layout->add_support(joined(range(6 * b, 6), range(60, 9)));
  return layout;
}

/// One layout for all instances of a family, with every support that one of them may use.
const std::shared_ptr<cone::Layout>& family_layout(ConeFamily family) {
  static const std::shared_ptr<cone::Layout> hand = make_layout(ConeFamily::Hand22), boxes = make_layout(ConeFamily::Boxes69);
  return family == ConeFamily::Hand22 ? hand : boxes;
}

}  // namespace

ConeInstance::ConeInstance(ConeFamily family, std::uint64_t seed) : family_(family), seed_(seed) {
  if (family == ConeFamily::Hand22)
    make_hand();
  else
    make_boxes();
  problem_ = std::make_unique<cone::Problem>(layout_, static_cast<int>(contacts_.size()), 0);
  fill();
}

void ConeInstance::make_hand() {
  Random random(seed_, 1);
  constexpr double kRadius = 0.06;
  const double mass = random.uniform(0.1, 1.0);
  const auto layout = family_layout(family_);
  first_actuated_ = 0;
  first_object_ = 16;
  for (int i = 0; i < 16; ++i) {
    stiffness_.push_back(kStep * 100);
    stretch_.push_back(random.uniform(-0.1, 0.1));
    lower_.push_back(random.uniform(0.0, 1.0));
    upper_.push_back(random.uniform(0.0, 1.0));
  }
  const double translation = random.uniform(0.2, 1.0);  // regularisation of the ball
  for (int i = 0; i < 3; ++i) object_Q_.push_back(translation), object_b_.push_back(i == 2 ? kStep * mass * kGravity : 0.0);
  for (int i = 0; i < 3; ++i) object_Q_.push_back(translation * 0.4 * kRadius * kRadius), object_b_.push_back(0.0);
  for (int f = 0; f < 4; ++f) {
    const double turn = f * 1.6 + random.uniform(-0.2, 0.2);
    const Vector3d out(std::cos(turn), std::sin(turn), 0), side(-std::sin(turn), std::cos(turn), 0);
    std::vector<Vector3d> axes{Vector3d::UnitZ(), side, side, side}, origins;
    Vector3d at = 0.09 * out - Vector3d(0, 0, 0.06);
    for (int i = 0; i < 4; ++i) origins.push_back(at), at += Vector3d(0, 0, 0.035) + 0.01 * random.normal() * out;
    for (int c = 0; c < 4; ++c) {
      // A point of the ball's side that faces the finger, touched by link 4 (twice), 3 or 2.
      const Vector3d r = kRadius * (out + 0.6 * unit(random)).normalized();
      Rows rows{frame(r.normalized()), random.uniform(0.5, 1.0)};
      rows.append(chain_jacobian(axes, origins, r, c < 2 ? 4 : 5 - c));
      rows.append_body(r, -1);
      contacts_.push_back({layout->add_support(joined(range(4 * f, 4), range(16, 6))), rows.row_major(),
                           random.chance(0.3) ? random.uniform(-1e-3, 1e-3) : random.uniform(0, 0.02)});
    }
  }
  for (int c = 0; c < 4; ++c) {
    const Vector3d r = kRadius * (-Vector3d::UnitZ() + 0.3 * unit(random)).normalized();
    Rows rows{frame(r.normalized()), random.uniform(0.5, 1.0)};
    rows.append_body(r, -1);
    contacts_.push_back({layout->add_support(range(16, 6)), rows.row_major(), random.uniform(-1e-4, 2e-3)});
  }
  layout_ = layout;
}

void ConeInstance::make_boxes() {
  Random random(seed_, 2);
  constexpr double kHalf = 0.05;
  const auto layout = family_layout(family_);
  first_object_ = 0;
  first_actuated_ = 60;
  for (int i = 0; i < 9; ++i) {
    stiffness_.push_back(kStep * (i < 3 ? 1000 : 300));
    stretch_.push_back(random.uniform(-0.1, 0.1));
    lower_.push_back(random.uniform(0.0, 1.0));
    upper_.push_back(random.uniform(0.0, 1.0));
  }
  std::vector<Vector3d> centre;  // boxes 2s (below) and 2s + 1 (on top of it), stacks in a row along x
  for (int b = 0; b < 10; ++b) {
    const double mass = random.uniform(0.1, 2.0), translation = random.uniform(0.2, 1.0);
    centre.emplace_back((b / 2) * 2 * kHalf, 0.004 * random.normal(), b % 2 == 0 ? kHalf : 3 * kHalf);
    for (int i = 0; i < 3; ++i) object_Q_.push_back(translation), object_b_.push_back(i == 2 ? kStep * mass * kGravity : 0.0);
    for (int i = 0; i < 3; ++i) object_Q_.push_back(translation * 2.0 / 3.0 * kHalf * kHalf), object_b_.push_back(0.0);
  }
  const auto near_gap = [&random] { return random.chance(0.5) ? random.uniform(-5e-4, 5e-4) : random.uniform(0, 5e-3); };
  const auto face = [&](int b, int on, const Vector3d& p, const Vector3d& n) {  // n points from `on` (−1: the world) to b
    Rows rows{frame(n), random.uniform(0.3, 0.9)};
    std::vector<int> variables;
    if (on >= 0) {
      rows.append_body(p - centre[static_cast<std::size_t>(on)], -1);
      variables = range(6 * on, 6);
    }
    rows.append_body(p - centre[static_cast<std::size_t>(b)], 1);
    variables = joined(variables, range(6 * b, 6));
    contacts_.push_back({layout->add_support(variables), rows.row_major(), near_gap()});
  };
  for (int b = 0; b < 10; ++b) {
    const Vector3d& c = centre[static_cast<std::size_t>(b)];
    for (int k = 0; k < 4; ++k) {
      const Vector3d corner((k % 2 == 0 ? -1 : 1) * kHalf, (k / 2 == 0 ? -1 : 1) * kHalf, -kHalf);
      face(b, b % 2 == 0 ? -1 : b - 1, c + corner, Vector3d::UnitZ());
    }
  }
  for (int s = 0; s < 4; ++s) {
    for (int k = 0; k < 2; ++k) {
      const Vector3d p = centre[static_cast<std::size_t>(2 * s)] + Vector3d(kHalf, k == 0 ? -kHalf : kHalf, random.uniform(-kHalf, kHalf));
      face(2 * s + 2, 2 * s, p, Vector3d::UnitX());
    }
  }
  std::vector<Vector3d> axes, origins;
  Vector3d at(0.2, -0.6, 0.1);
  for (int i = 0; i < 9; ++i) axes.push_back(unit(random)), origins.push_back(at), at += Vector3d(0, 0.05, 0.0) + 0.03 * unit(random);
  for (int c = 0; c < 8; ++c) {
    const int b = random.index(10);
    const Vector3d p = centre[static_cast<std::size_t>(b)] + Vector3d(random.uniform(-kHalf, kHalf), -kHalf, random.uniform(-kHalf, kHalf));
    Rows rows{frame(-Vector3d::UnitY()), random.uniform(0.3, 0.9)};
    rows.append_body(p - centre[static_cast<std::size_t>(b)], -1);
    rows.append(chain_jacobian(axes, origins, p, 9 - c % 4));
    contacts_.push_back({layout->add_support(joined(range(6 * b, 6), range(60, 9))), rows.row_major(), near_gap()});
  }
  layout_ = layout;
}

void ConeInstance::fill() {
  problem_->clear();
  for (std::size_t i = 0; i < object_Q_.size(); ++i) {
    const int v = first_object_ + static_cast<int>(i);
    problem_->set_Q(v, v, object_Q_[i]);
    problem_->set_b(v, object_b_[i]);
  }
  for (std::size_t i = 0; i < stiffness_.size(); ++i) {
    const int v = first_actuated_ + static_cast<int>(i);
    problem_->set_Q(v, v, stiffness_[i]);
    problem_->set_b(v, -stiffness_[i] * stretch_[i]);
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const double g[3] = {contacts_[i].gap, 0, 0};
    problem_->add_cone(i, contacts_[i].support, contacts_[i].G.data(), g, sigma_);
  }
  std::uint64_t id = 1000;
  for (std::size_t i = 0; i < stiffness_.size(); ++i) {
    const int v = first_actuated_ + static_cast<int>(i);
    problem_->add_bound(id++, v, 1, lower_[i], sigma_ / 2);
    problem_->add_bound(id++, v, -1, upper_[i], sigma_ / 2);
  }
  if (family_ != ConeFamily::Hand22) return;
  for (int i = 0; i < 6; ++i) problem_->add_bound(id++, 16 + i, i % 2 == 0 ? 1 : -1, 0.5, sigma_ / 2);  // a workspace of the ball
}

void ConeInstance::follow(const cone::Result& solution) {
  Random random(seed_, 1000 + ++step_);
  for (std::size_t i = 0; i < contacts_.size(); ++i) contacts_[i].gap = solution.w_cone(0, static_cast<int>(i));
  for (std::size_t i = 0; i < stiffness_.size(); ++i) {
    const double moved = solution.x[first_actuated_ + static_cast<int>(i)];
    stretch_[i] += random.uniform(-0.005, 0.005) - moved;
    lower_[i] += moved;
    upper_[i] -= moved;
  }
  fill();
}

namespace {

struct Clock {
  using C = std::chrono::steady_clock;
  C::time_point start = C::now();
  double seconds() const { return std::chrono::duration<double>(C::now() - start).count(); }
};

void time_one(const cone::Problem& problem, const cone::Options& options, cone::Workspace& work, cone::Result& result, ConeTiming& timing,
              const std::function<long()>& allocations, bool keep) {
  const long before = allocations ? allocations() : 0;
  const Clock clock;
  const auto status = cone::solve(problem, options, work, result);
  const double seconds = clock.seconds();
  const long after = allocations ? allocations() : 0;
  if (!keep) return;
  if (status != core::Status::Solved) ++timing.failures;
  timing.allocations += after - before;
  timing.seconds.push_back(seconds);
  timing.iterations.push_back(result.iterations);
}

}  // namespace

ConeTiming time_cone_cold(ConeFamily family, int n, std::uint64_t seed, cone::Options options, const std::function<long()>& allocations) {
  options.warm_start = false;
  ConeTiming timing;
  timing.seconds.reserve(static_cast<std::size_t>(n));
  timing.iterations.reserve(static_cast<std::size_t>(n));
  std::vector<ConeInstance> instances;
  instances.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) instances.emplace_back(family, seed + static_cast<std::uint64_t>(i));
  cone::Workspace work(family_layout(family));
  cone::Result result;
  cone::Problem problem(family_layout(family), 0, 0);  // refilled before each solve, as a planner does
  // One pass over all problems sizes the workspace and brings in its pages; the next is timed.
  for (const bool keep : {false, true}) {
    for (const auto& instance : instances) {
      problem = instance.problem();
      work.forget();
      time_one(problem, options, work, result, timing, allocations, keep);
    }
  }
  if (!allocations) timing.allocations = -1;
  return timing;
}

ConeTiming time_cone_warm(ConeFamily family, int n, std::uint64_t seed, cone::Options options, const std::function<long()>& allocations) {
  options.warm_start = true;
  ConeTiming timing;
  timing.seconds.reserve(static_cast<std::size_t>(n));
  timing.iterations.reserve(static_cast<std::size_t>(n));
  cone::Workspace work(family_layout(family));
  cone::Result result;
  const auto roll_out = [&](std::uint64_t rollout, bool keep) {
    ConeInstance instance(family, seed + rollout);
    work.forget();
    for (int step = 0; step <= 10 && static_cast<int>(timing.seconds.size()) < n; ++step) {
      time_one(instance.problem(), options, work, result, timing, allocations, keep && step > 0);
      instance.follow(result);
    }
  };
  constexpr std::uint64_t kWarmUp = 20;  // rollouts
  for (std::uint64_t rollout = 0; rollout < kWarmUp; ++rollout) roll_out(rollout, false);
  for (std::uint64_t rollout = 0; static_cast<int>(timing.seconds.size()) < n; ++rollout) roll_out(rollout, true);
  if (!allocations) timing.allocations = -1;
  return timing;
}

}  // namespace stiction::bench
