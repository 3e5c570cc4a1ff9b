#include "stiction/execution/open_loop/spring_load.hpp"

#include <algorithm>
#include <cmath>

namespace stiction::execution {

SpringLoad::SpringLoad(const world::Model& model, const RunSpeeds& speeds)
    : speeds_(speeds), chains_(model), force_(model.stiffness().cwiseQuotient(model.reach())) {}

double SpringLoad::calc_time(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
  double most = 0;
  for (int chain = 0; chain < chains_.size(); ++chain) {
    double before = 0, after = 0;
    for (const int j : chains_.joints(chain)) {
      before = std::max(before, force_[j] * std::abs(from[j]));
      after = std::max(after, force_[j] * std::abs(to[j]));
    }
    const double force = std::min(before, after);
    for (const int j : chains_.joints(chain))
      most = std::max(most, std::abs(to[j] - from[j]) / (speeds_.springs[j] + force / (force_[j] * speeds_.spring_time[j])));
  }
  return most;
}

int SpringLoad::count_parts(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
  constexpr double kMostParts = 100;
  const double parts = (to - from).cwiseAbs().cwiseQuotient(speeds_.springs.cwiseProduct(speeds_.spring_time)).maxCoeff();
  return static_cast<int>(std::clamp(std::ceil(parts), 1.0, kMostParts));
}

}  // namespace stiction::execution
