#include "stiction/world/joint_values.hpp"

#include <algorithm>

namespace stiction::world {

int number_of_joints(std::span<const Link> links) {
  return static_cast<int>(std::ranges::count_if(links, [](const Link& link) { return link.dof >= 0; }));
}

std::optional<Eigen::VectorXd> own_joint_values(std::span<const Link> links, int n_vu, int n_a,
                                                const Eigen::Ref<const Eigen::VectorXd>& values) {
  if (values.size() == n_a) return values;
  if (values.size() != number_of_joints(links)) return std::nullopt;
  Eigen::VectorXd own(n_a);
  Eigen::Index i = 0;
  for (const Link& link : links) {
    if (link.dof < 0) continue;
    if (link.follower < 0) own[link.dof - n_vu] = values[i];
    ++i;
  }
  return own;
}

}  // namespace stiction::world
