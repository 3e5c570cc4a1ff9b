#include "stiction/sensing/visibility.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "stiction/core/random.hpp"
#include "stiction/core/sha256.hpp"
#include "stiction/sensing/friction_cone.hpp"

namespace stiction::sensing {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Random angles of all joints of robots inside their limits; a full turn without limits.
Eigen::VectorXd random_posture(const world::Model& model, core::Random& random) {
  Eigen::VectorXd q = model.neutral();
  for (int j = 0; j < model.n_a(); ++j) {
    const double lower = model.lower()[j], upper = model.upper()[j];
    const bool limited = std::isfinite(lower) && std::isfinite(upper);
    q[model.n_qu() + j] = limited ? random.uniform(lower, upper) : random.uniform(-std::numbers::pi, std::numbers::pi);
  }
  return q;
}

void append(std::string& bytes, const Eigen::Ref<const Eigen::MatrixXd>& numbers) {
  const Eigen::MatrixXd packed = numbers;
  bytes.append(reinterpret_cast<const char*>(packed.data()), static_cast<std::size_t>(packed.size()) * sizeof(double));
}

}  // namespace

Visibility::Visibility(const world::Model& model, int robot, const std::vector<TriangleTree>& trees, int rays, int postures,
                       std::uint64_t seed) {
  for (int body = 0; body < static_cast<int>(model.bodies().size()); ++body) {
    const auto& info = model.bodies()[static_cast<std::size_t>(body)];
    const TriangleTree& tree = trees[static_cast<std::size_t>(body)];
    if (info.kind != world::BodyKind::Robot || info.owner != robot || tree.size() == 0) continue;
    const Vector3d center = 0.5 * (tree.corners().rowwise().minCoeff() + tree.corners().rowwise().maxCoeff());
    occluders_.push_back({&tree, body, center, (tree.corners().colwise() - center).colwise().norm().maxCoeff()});
  }
  core::Random random(seed, 0);
  world::KinematicsWorkspace work(model);
  for (int i = 0; i < postures; ++i) {
    postures_.emplace_back();
    world::calc_kinematics(model, i == 0 ? model.neutral() : random_posture(model, random), work, postures_.back());
  }
  rays_.resize(3, rays);
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));  // Fibonacci's spiral covers the half sphere evenly
  for (int i = 0; i < rays; ++i) {
    const double z = 1 - (i + 0.5) / rays, r = std::sqrt(1 - z * z);
    rays_.col(i) << r * std::cos(golden * i), r * std::sin(golden * i), z;
  }
  std::string bytes;
  append(bytes, rays_);
  for (const Occluder& occluder : occluders_) {
    append(bytes, occluder.tree->corners());
    for (const auto& posture : postures_) {
      append(bytes, posture.X_WB[static_cast<std::size_t>(occluder.body)].R);
      append(bytes, posture.X_WB[static_cast<std::size_t>(occluder.body)].p);
    }
  }
  key_ = core::sha256(bytes);
}

bool Visibility::is_seen(int body, const Vector3d& p_L, const Vector3d& direction_L, double lift) const {
  const Matrix3d frame = make_contact_frame(-direction_L);  // first column: the direction
  Matrix3d R_LD;
  R_LD << frame.col(1), frame.col(2), frame.col(0);
  const Vector3d start_L = p_L + lift * direction_L;
  std::size_t likely = 0;  // index of the occluder that stopped the last ray
  for (const auto& posture : postures_) {
    const auto& X_WL = posture.X_WB[static_cast<std::size_t>(body)];
    const Vector3d start_W = X_WL * start_L;
    for (const auto& ray : rays_.colwise()) {
      const Vector3d d_W = X_WL.R * (R_LD * ray);
      bool hit = false;
      for (std::size_t i = 0; i < occluders_.size(); ++i) {
        const Occluder& occluder = occluders_[(likely + i) % occluders_.size()];
        const auto& X_WO = posture.X_WB[static_cast<std::size_t>(occluder.body)];
        const Vector3d start_O = X_WO.R.transpose() * (start_W - X_WO.p), d_O = X_WO.R.transpose() * d_W;
        const Vector3d to_center = occluder.p_LCenter - start_O;
        const double along = to_center.dot(d_O), off = to_center.squaredNorm() - occluder.radius * occluder.radius;
        if (off > 0 && (along <= 0 || off > along * along)) continue;  // passes its bounding sphere
        if (occluder.tree->is_hit(start_O, d_O)) {
          likely = (likely + i) % occluders_.size();
          hit = true;
          break;
        }
      }
      if (!hit) return true;
    }
  }
  return false;
}

}  // namespace stiction::sensing
