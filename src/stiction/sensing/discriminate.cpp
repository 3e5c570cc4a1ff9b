#include "stiction/sensing/discriminate.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {

using core::Status;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

void DiscriminationOptions::validate() const {
  core::require_positive("joint_step", joint_step);
  if (travel) core::require_positive("travel", *travel);
  core::require_positive("least", least);
  if (least >= 1) core::throw_invalid("least", std::to_string(least), "a number in (0, 1)");
  core::require_positive("sideways", sideways);
}

namespace {

constexpr int kOpen = -1;

void set_bounds(std::span<const int> signs, double least, LinearRows& rows) {
  for (std::size_t i = 0; i < signs.size(); ++i) {
    rows.lower[static_cast<Index>(i)] = signs[i] == 0 ? least : -1;
    rows.upper[static_cast<Index>(i)] = signs[i] == 1 ? -least : 1;
  }
}

class Tree {
 public:
  Tree(LinearRows rows, int contacts, double least, Discrimination& out)
      : least_(least), out_(out), rows_(std::move(rows)), signs_(static_cast<std::size_t>(contacts), kOpen) {}

  /// Whether signs with this sum have a motion; if so, `out_` has it. The contacts from `next` on are open.
  bool search(int next, int pulls_left) {
    const int open = static_cast<int>(signs_.size()) - next;
    if (pulls_left < 0 || pulls_left > open || is_refuted()) return false;
    ++out_.nodes;
    set_bounds(signs_, least_, rows_);
    Feasibility found = find_feasible(rows_);
    if (!found.feasible) {
      out_.certificate.push_back({signs_, std::move(found.weights)});
      return false;
    }
    if (open == 0) {
      out_.dq = std::move(found.x);
      out_.pull = signs_;
      return true;
    }
    // First the sign that the relaxed motion has.
    const double d = rows_.C.row(next).dot(found.x);
    for (const int sign : {d < 0 ? 1 : 0, d < 0 ? 0 : 1}) {
      signs_[static_cast<std::size_t>(next)] = sign;
      if (search(next + 1, pulls_left - sign)) return true;
    }
    signs_[static_cast<std::size_t>(next)] = kOpen;
    return false;
  }

 private:
  /// By a tree of another sum.
  bool is_refuted() const {
    return std::any_of(out_.certificate.begin(), out_.certificate.end(), [&](const RefutedSigns& refuted) {
      return std::equal(signs_.begin(), signs_.end(), refuted.signs.begin(),
                        [](int mine, int theirs) { return theirs == kOpen || mine == theirs; });
    });
  }

  double least_;
  Discrimination& out_;
  LinearRows rows_;
  std::vector<int> signs_;
};

}  // namespace

LinearRows make_rows(const Matrix3Xd& normals, std::span<const Matrix3Xd> jacobians, double travel, const DiscriminationOptions& options,
                     std::span<const int> signs) {
  const Index joints = jacobians[0].cols(), N = normals.cols();
  const double scale = options.joint_step / travel;
  LinearRows rows;
  rows.C.resize(4 * N + joints, joints);
  rows.upper = VectorXd::Ones(4 * N + joints);
  for (Index i = 0; i < N; ++i) {
    const Vector3d n = normals.col(i);
    const Matrix3Xd& J = jacobians[static_cast<std::size_t>(i)];
    rows.C.row(i) = scale * (n.transpose() * J);
    rows.C.middleRows(N + 3 * i, 3) = scale * (J - n * (n.transpose() * J));
    rows.upper.segment(N + 3 * i, 3).setConstant(options.sideways);
  }
  rows.C.bottomRows(joints).setIdentity();
  rows.lower = -rows.upper;
  set_bounds(signs, options.least, rows);
  return rows;
}

Status discriminate(const Matrix3Xd& normals, std::span<const Matrix3Xd> jacobians, double travel, const DiscriminationOptions& options,
                    Discrimination& out) {
  options.validate();
  core::require_positive("travel", travel);
  core::require_size("jacobians", static_cast<long>(jacobians.size()), normals.cols());
  if (normals.cols() == 0) core::throw_invalid("candidates", "none", "at least one");
  const int n = static_cast<int>(normals.cols());
  out = {};
  const std::vector<int> open(static_cast<std::size_t>(n), kOpen);
  Tree tree(make_rows(normals, jacobians, travel, options, open), n, options.least, out);
  const int half = n / 2, fewest = n > 1 ? 1 : 0, most = n > 1 ? n - 1 : 1;
  for (int off = 0; off <= n; ++off) {
    for (const int pulls : {half + off, half - off}) {
      if (pulls < fewest || pulls > most || (off == 0 && pulls != half)) continue;
      if (tree.search(0, pulls)) {
        out.dq *= options.joint_step;
        out.objective = off;
        return out.status = Status::Solved;
      }
      if (off == 0) break;  // one sum, not two
    }
  }
  return out.status = Status::Infeasible;
}

Status discriminate(const Sensor& sensor, VectorRef q, std::span<const Candidate> candidates, const DiscriminationOptions& options,
                    Discrimination& out) {
  options.validate();
  const world::Model& model = sensor.model();
  world::require_configuration(model, "q", q);
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  Matrix3Xd normals(3, static_cast<Index>(candidates.size())), J_w, J_v;
  std::vector<Matrix3Xd> jacobians;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const ContactPoint& point = candidates[i].best;
    const int body = sensor.links()[static_cast<std::size_t>(point.link)].surface.body;
    const Matrix3d& R_WL = kinematics.X_WB[static_cast<std::size_t>(body)].R;
    calc_link_jacobian(model, kinematics, body, J_w, J_v);
    normals.col(static_cast<Index>(i)) = R_WL * point.n_L;
    jacobians.push_back(R_WL * (J_v - LinkTorque::skew(point.p_L) * J_w));
  }
  constexpr double kTravel = 0.1;  // of what the longest lever makes of the joint step
  const double travel = options.travel.value_or(kTravel * options.joint_step * model.reach().maxCoeff());
  return discriminate(normals, jacobians, travel, options, out);
}

}  // namespace stiction::sensing
