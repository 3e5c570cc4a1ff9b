#include "stiction/execution/touch/joint_path.hpp"

#include <algorithm>

#include "stiction/core/invalid_input.hpp"

namespace stiction::execution {

double calc_travel(const world::Model& model, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  return model.reach().dot((to - from).cwiseAbs());
}

JointPath::JointPath(const world::Model& model, std::vector<Eigen::VectorXd> postures, double speed) : postures_(std::move(postures)) {
  core::require_positive("speed", speed);
  if (postures_.empty()) core::throw_invalid("postures", "none", "at least one");
  for (const Eigen::VectorXd& q : postures_) core::require_size("postures", q.size(), model.n_a());
  travelled_.push_back(0);
  for (std::size_t k = 1; k < postures_.size(); ++k)
    travelled_.push_back(travelled_.back() + calc_travel(model, postures_[k - 1], postures_[k]));
  duration_ = 1.5 * travelled_.back() / speed;  // s²(3 − 2s) has slope 3/2 in the middle
}

Eigen::VectorXd JointPath::at(double time) const {
  if (time >= duration_) return postures_.back();
  const double s = std::max(time, 0.0) / duration_, along = s * s * (3 - 2 * s) * travelled_.back();
  const auto next = std::upper_bound(travelled_.begin(), travelled_.end(), along);
  if (next == travelled_.end()) return postures_.back();
  const auto k = static_cast<std::size_t>(next - travelled_.begin());
  const double share = (along - travelled_[k - 1]) / (travelled_[k] - travelled_[k - 1]);
  return postures_[k - 1] + share * (postures_[k] - postures_[k - 1]);
}

}  // namespace stiction::execution
