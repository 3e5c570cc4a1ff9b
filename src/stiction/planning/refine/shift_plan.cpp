#include "stiction/planning/refine/shift_plan.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <optional>
#include <set>

#include "stiction/contact/geometry_workspace.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/world/point_jacobian.hpp"
#include "stiction/world/robot_chains.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::planning::refinement {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kNear = 0.1;      ///< points of links count that are nearer to an object than this [L of the robots]
constexpr double kTouches = 0.01;  ///< and count for half at this distance [L of the robots]
constexpr double kTurn = 0.1;      ///< w [L of the robots]
constexpr double kStay = 1e-4;     ///< ε [L of the robots]

/// What a link should do, and how much that counts.
struct Aim {
  double weight;
  int body;
  Vector3d p_B, p_W;  ///< a point of it, and where that should be
  Eigen::Matrix3d R_WB;
};

class Shifter {
 public:
  Shifter(const world::Model& model, const std::vector<Vector3d>& shifts)
      : model_(model), shifts_(shifts), work_(model), length_(model.scales().robots().length), J_(6, model.n_a()) {
    const world::RobotChains chains(model);
    std::set<int> pairs;  // a branch that carries others has theirs as well
    for (int c = 0; c < chains.size(); ++c) pairs.insert(chains.object_pairs(c).begin(), chains.object_pairs(c).end());
    pairs_.assign(pairs.begin(), pairs.end());
  }

  /// The objects of a configuration, moved.
  void move_objects(VectorXd& q) const {
    for (std::size_t i = 0; i < shifts_.size(); ++i)
      if (!shifts_[i].isZero()) q.segment<3>(model_.objects()[i].q_begin) += shifts_[i];
  }

  /// δ (G.7) at a state of the plan. nullopt: no link is near an object. @param delta  from where to begin
  std::optional<VectorXd> solve(const VectorXd& q, VectorXd delta) {
    constexpr int kIterations = 20;
    constexpr double kSmall = 1e-10;
    find_aims(q);
    if (aims_.empty()) return std::nullopt;
    for (int i = 0; i < kIterations; ++i) {
      const VectorXd step = calc_step(q, delta);
      delta += step;
      if (step.cwiseAbs().maxCoeff() < kSmall) break;
    }
    return delta;
  }

 private:
  void locate(const VectorXd& q) { world::calc_kinematics(model_, q, work_.kinematics_work, work_.kinematics); }
  const world::Pose& pose(int body) const { return work_.kinematics.X_WB[static_cast<std::size_t>(body)]; }

  void find_aims(const VectorXd& q) {
    aims_.clear();
    locate(q);
    contact::query_pairs(model_, work_.kinematics, pairs_, kNear * length_, work_.contact_work, work_.contacts);
    for (const contact::Contact& c : work_.contacts) {
      const world::Pair& pair = model_.pairs()[static_cast<std::size_t>(c.pair)];
      const int object = body_of(pair.geometry_a), link = body_of(pair.geometry_b);  // an object is A
      const world::Pose& X_WB = pose(link);
      const Vector3d& shift = shifts_[static_cast<std::size_t>(model_.bodies()[static_cast<std::size_t>(object)].owner)];
      const double far = std::max(0.0, c.phi) / (kTouches * length_);
      aims_.push_back({1 / (1 + far * far), link, X_WB.R.transpose() * (c.p_WB - X_WB.p), c.p_WB + shift, X_WB.R});
    }
  }

  int body_of(int geometry) const { return model_.geometries()[static_cast<std::size_t>(geometry)].body; }

  /// A step of Gauss and Newton.
  VectorXd calc_step(const VectorXd& q, const VectorXd& delta) {
    VectorXd moved = q;
    moved.tail(model_.n_a()) += delta;
    locate(moved);
    const double turn = kTurn * length_, stay = kStay * length_;
    MatrixXd H = stay * stay * MatrixXd::Identity(model_.n_a(), model_.n_a());
    VectorXd g = stay * stay * delta;
    for (const Aim& aim : aims_) {
      const world::Pose& X_WB = pose(aim.body);
      const Vector3d p_W = X_WB * aim.p_B;
      world::calc_point_jacobian(model_, work_.kinematics, aim.body, p_W, J_);
      const Eigen::AngleAxisd turned(Eigen::Matrix3d(X_WB.R * aim.R_WB.transpose()));
      Eigen::Matrix<double, 6, 1> residual;
      residual.head<3>() = p_W - aim.p_W;
      residual.tail<3>() = turn * turned.angle() * turned.axis();
      J_.bottomRows(3) *= turn;
      H.noalias() += aim.weight * J_.transpose() * J_;
      g.noalias() += aim.weight * J_.transpose() * residual;
    }
    return -H.ldlt().solve(g);
  }

  const world::Model& model_;
  const std::vector<Vector3d>& shifts_;
  contact::GeometryWorkspace work_;
  double length_;
  RowMatrix J_;
  std::vector<int> pairs_;
  std::vector<Aim> aims_;
};

/// Where a column has no δ, from those before and after it.
void fill_gaps(const std::vector<char>& known, MatrixXd& delta) {
  Eigen::Index before = -1;
  for (Eigen::Index k = 0; k < delta.cols(); ++k) {
    if (!known[static_cast<std::size_t>(k)]) continue;
    for (Eigen::Index i = before + 1; i < k; ++i) {
      const double share = before < 0 ? 1 : static_cast<double>(i - before) / static_cast<double>(k - before);
      delta.col(i) = before < 0 ? delta.col(k) : VectorXd((1 - share) * delta.col(before) + share * delta.col(k));
    }
    before = k;
  }
  for (Eigen::Index i = before + 1; i < delta.cols() && before >= 0; ++i) delta.col(i) = delta.col(before);
}

void require_shifts(const world::Model& model, const std::vector<Vector3d>& shifts) {
  constexpr int kFree = 6;  // coordinates of an object that moves freely
  core::require_size("shifts", static_cast<Eigen::Index>(shifts.size()), static_cast<Eigen::Index>(model.objects().size()));
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    core::require_finite("shifts", {shifts[i].data(), 3});
    if (shifts[i].isZero() || model.objects()[i].n_v == kFree) continue;
    core::throw_invalid("shifts", fmt::format("a shift of '{}'", model.objects()[i].name), "shifts of objects that move freely");
  }
}

}  // namespace

Plan shift_plan(const world::Model& model, const Plan& plan, const std::vector<Vector3d>& shifts) {
  require_shifts(model, shifts);
  Plan out = plan;
  struct State {
    VectorXd *q, *u;
    bool pushes;  ///< a push comes to it, or begins there
  };
  std::vector<State> states{{&out.q_start, &out.u_start, false}};
  for (Segment& segment : out.segments) {
    const bool push = segment.kind == SegmentKind::Contact;
    if (push && !segment.knots.empty()) states.back().pushes = true;
    for (dynamics::Knot& knot : segment.knots) states.push_back({&knot.q, &knot.u, push});
  }
  Shifter shifter(model, shifts);
  MatrixXd delta = MatrixXd::Zero(model.n_a(), static_cast<Eigen::Index>(states.size()));
  std::vector<char> known(states.size(), 0);
  VectorXd last = VectorXd::Zero(model.n_a());
  for (std::size_t k = 0; k < states.size(); ++k) {
    if (!states[k].pushes) continue;
    const auto solved = shifter.solve(*states[k].q, last);
    known[k] = solved.has_value();
    if (solved) delta.col(static_cast<Eigen::Index>(k)) = last = *solved;
  }
  fill_gaps(known, delta);
  for (std::size_t k = 0; k < states.size(); ++k) {
    shifter.move_objects(*states[k].q);
    states[k].q->tail(model.n_a()) += delta.col(static_cast<Eigen::Index>(k));
    *states[k].u += delta.col(static_cast<Eigen::Index>(k));
  }
  for (Segment& segment : out.segments)
    for (dynamics::Knot& knot : segment.knots) knot.contacts.clear();  // they are elsewhere
  return out;
}

}  // namespace stiction::planning::refinement
