#include "stiction/tasks/place_links.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/contact/contact.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/random.hpp"
#include "stiction/world/point_jacobian.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::tasks {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using world::Model;

constexpr int kEnough = 8;       // postures without overlap, of which the nearest is taken
constexpr int kSteps = 200;      // of each
constexpr double kDone = 1e-7;   // [m, rad]
constexpr double kRange = 3.14;  // of a joint without limits, to either side [rad, m]

class LinkPlacer {
 public:
  LinkPlacer(const Model& model, const VectorXd& q, std::span<const LinkTarget> targets, const PlaceLinksOptions& options)
      : model_(model), q0_(q), targets_(targets), options_(options), work_(model), contact_work_(model) {
    for (const LinkTarget& target : targets_) rows_ += target.R_WB ? 6 : 3;
    J_.resize(rows_, model.n_a());
    e_.resize(rows_);
  }

  PlacedLinks solve() {
    core::Random random(1, 0);
    PlacedLinks best;
    best.q = q0_;
    best.position = best.angle = std::numeric_limits<double>::infinity();
    double nearest = std::numeric_limits<double>::infinity();
    for (int i = 0, found = 0; i < options_.postures && found < kEnough; ++i) {
      PlacedLinks next = descend(i == 0 ? q0_ : draw(random, static_cast<double>(i) / options_.postures));
      if (next.status != core::Status::MaxIterations && !options_.overlap) judge(next);
      const double far = (next.q - q0_).squaredNorm();
      if (next.status == core::Status::Solved) ++found;
      if (!is_better(next, far, best, nearest)) continue;
      best = std::move(next);
      nearest = far;
    }
    return best;
  }

 private:
  /// Solved before overlapping before elsewhere; of the same kind the nearest, the least deep, the least far off.
  static bool is_better(const PlacedLinks& a, double far_a, const PlacedLinks& b, double far_b) {
    const auto rank = [](core::Status s) { return s == core::Status::Solved ? 0 : s == core::Status::MaxIterations ? 2 : 1; };
    if (rank(a.status) != rank(b.status)) return rank(a.status) < rank(b.status);
    if (a.status == core::Status::Solved) return far_a < far_b;
    if (a.status == core::Status::MaxIterations) return a.position + a.angle < b.position + b.angle;
    return a.depth < b.depth;
  }

  VectorXd draw(core::Random& random, double share) const {
    VectorXd q = q0_;
    for (int j = 0; j < model_.n_a(); ++j) {
      double& value = q[model_.n_qu() + j];
      const double lower = std::max(model_.lower()[j], value - kRange), upper = std::min(model_.upper()[j], value + kRange);
      value += share * (random.uniform(lower, upper) - value);
    }
    return q;
  }

  /// How the link moves with each joint: points of it by the first three rows, its orientation by the others.
  void calc_columns(const LinkTarget& target, int row) {
    world::calc_point_jacobian(model_, kinematics_, target.body, kinematics_.X_WB[static_cast<std::size_t>(target.body)].p, J_link_);
    const int rows = target.R_WB ? 6 : 3;
    J_.middleRows(row, rows) = J_link_.topRows(rows);
  }

  void linearise(PlacedLinks& at) {
    world::calc_kinematics(model_, at.q, work_, kinematics_);
    J_.setZero();
    at.position = at.angle = 0;
    int row = 0;
    for (const LinkTarget& target : targets_) {
      const world::Pose& X_WB = kinematics_.X_WB[static_cast<std::size_t>(target.body)];
      e_.segment<3>(row) = target.p_WB - X_WB.p;
      at.position = std::max(at.position, e_.segment<3>(row).norm());
      if (target.R_WB) {
        const Eigen::AngleAxisd turn(*target.R_WB * X_WB.R.transpose());
        e_.segment<3>(row + 3) = turn.angle() * turn.axis();
        at.angle = std::max(at.angle, std::abs(turn.angle()));
      }
      calc_columns(target, row);
      row += target.R_WB ? 6 : 3;
    }
  }

  /// Computes a step. Joints that would leave their limits stay, and the other joints do the rest.
  /// @param near  share of the distance to the given joints that the step covers in the null space of the poses
  VectorXd calc_step(const VectorXd& q, double damping, double near) const {
    const int n = model_.n_a();
    std::vector<bool> held(static_cast<std::size_t>(n), false);
    const VectorXd wish = near * (q0_ - q).tail(n);
    for (;;) {
      MatrixXd J = J_;
      for (int j = 0; j < n; ++j) {
        if (held[static_cast<std::size_t>(j)]) J.col(j).setZero();
      }
      const MatrixXd G = J * J.transpose() + damping * damping * MatrixXd::Identity(rows_, rows_);
      const Eigen::LLT<MatrixXd> factor(G);
      VectorXd step = J.transpose() * factor.solve(e_ - J * wish) + wish;
      bool more = false;
      for (int j = 0; j < n; ++j) {
        const double value = q[model_.n_qu() + j], lower = model_.lower()[j], upper = model_.upper()[j];
        const auto i = static_cast<std::size_t>(j);
        if (held[i])
          step[j] = 0;
        else if ((step[j] < 0 && value <= lower) || (step[j] > 0 && value >= upper))
          held[i] = more = true;
      }
      if (!more) return step;
    }
  }

  PlacedLinks descend(VectorXd from) {
    constexpr double kLongest = 0.3;  // step of a joint [rad, m]
    constexpr double kLeastDamping = 1e-6;
    PlacedLinks at;
    at.q = std::move(from);
    double moved = 1;
    for (int k = 0; k < kSteps; ++k) {
      linearise(at);
      const double error = std::max(at.position, at.angle);
      if (error < kDone && moved < 1e-4) break;
      // If the arm is almost stretched, long steps towards the given joints prevent convergence. In the end they are switched off.
      const double near = k < kSteps / 10 ? 1.0 : k < 3 * kSteps / 4 ? 0.1 * kSteps / k : 0.0;
      VectorXd step = calc_step(at.q, std::max(kLeastDamping, 0.1 * std::min(error, 1.0)), near);
      // If the pose is out of reach, long steps would swing the stretched arm around. Steps become shorter towards the end.
      const double longest = kLongest * std::min(1.0, 4.0 * (kSteps - k) / kSteps);
      if (const double most = step.cwiseAbs().maxCoeff(); most > longest) step *= longest / most;
      moved = step.cwiseAbs().maxCoeff();
      auto joints = at.q.tail(model_.n_a());
      joints = (joints + step).cwiseMax(model_.lower()).cwiseMin(model_.upper());
    }
    linearise(at);
    if (std::max(at.position, at.angle) < 10 * kDone) at.status = core::Status::Solved;
    return at;
  }

  /// Finds overlaps of the bodies that the joints move.
  void judge(PlacedLinks& at) {
    world::calc_kinematics(model_, at.q, work_, kinematics_);
    for (int i = 0; i < static_cast<int>(model_.pairs().size()); ++i) {
      const world::Pair& pair = model_.pairs()[static_cast<std::size_t>(i)];
      const auto& support = model_.supports()[static_cast<std::size_t>(pair.support)];
      if (support.empty() || support.back() < model_.n_vu()) continue;  // no joint of a robot
      const double near = world::share::kContact * model_.scales().pair(i).length;
      if (contact::calc_pair_lower_bound(model_, kinematics_, i, contact_work_) > near) continue;
      const double phi = contact::pair_distance(model_, kinematics_, i, contact_work_).phi;
      if (phi >= near || near - phi <= at.depth) continue;
      at.status = core::Status::NumericalFailure;
      at.pair = i;
      at.depth = near - phi;
    }
    if (at.pair >= 0) at.depth = std::max(0.0, -contact::pair_distance(model_, kinematics_, at.pair, contact_work_).phi);
  }

  const Model& model_;
  const VectorXd& q0_;
  std::span<const LinkTarget> targets_;
  const PlaceLinksOptions& options_;
  world::KinematicsWorkspace work_;
  contact::Workspace contact_work_;
  world::Kinematics kinematics_{};
  int rows_ = 0;
  MatrixXd J_{};
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> J_link_{6, model_.n_a()};
  VectorXd e_{};
};

}  // namespace

std::vector<int> find_links(const Model& model, std::string_view name) {
  std::vector<int> found;
  const std::string ending = fmt::format("/{}", name);
  for (const world::Link& link : model.links()) {
    const world::Body& body = model.bodies()[static_cast<std::size_t>(link.body)];
    if (!body.dofs.empty() && (body.name == name || body.name.ends_with(ending))) found.push_back(link.body);
  }
  return found;
}

PlacedLinks place_links(const Model& model, const VectorXd& q, std::span<const LinkTarget> targets, const PlaceLinksOptions& options) {
  world::require_configuration(model, "q", q);
  if (options.postures < 1) core::throw_invalid("postures", fmt::format("{}", options.postures), "an integer ≥ 1");
  for (const LinkTarget& target : targets) {
    const auto bodies = model.bodies();
    const bool known = target.body >= 0 && target.body < static_cast<int>(bodies.size());
    const world::Body* body = known ? &bodies[static_cast<std::size_t>(target.body)] : nullptr;
    if (body == nullptr || body->kind != world::BodyKind::Robot || body->dofs.empty())
      core::throw_invalid("link", body != nullptr ? fmt::format("'{}'", body->name) : fmt::format("body {}", target.body),
                          "a link that joints of a robot move");
    if (!target.p_WB.allFinite() || (target.R_WB && !target.R_WB->allFinite()))
      core::throw_invalid(fmt::format("pose of '{}'", body->name), "numbers that are not finite", "finite ones");
  }
  return LinkPlacer(model, q, targets, options).solve();
}

}  // namespace stiction::tasks
