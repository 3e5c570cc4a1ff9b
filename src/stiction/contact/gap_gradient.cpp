#include "stiction/contact/gap_gradient.hpp"

#include "stiction/contact/relative_motion.hpp"

namespace stiction::contact {

using world::Kinematics;
using world::Model;

std::vector<char> joint_flags(const Model& model, std::span<const int> joints) {
  std::vector<char> flags(static_cast<std::size_t>(model.n_a()), 0);
  for (const int j : joints) flags[static_cast<std::size_t>(j)] = 1;
  return flags;
}

void calc_gap_gradient(const Model& model, const Contact& contact, const std::vector<char>& moving, const Kinematics& kinematics,
                       Eigen::Ref<Eigen::VectorXd> gradient) {
  gradient.setZero();
  visit_relative_motion(model, kinematics, contact, [&](const world::Axis& axis, const Eigen::Vector3d& v, const Eigen::Vector3d&) {
    const int joint = axis.dof - model.n_vu();
    if (joint >= 0 && moving[static_cast<std::size_t>(joint)]) gradient[joint] += axis.ratio * contact.nhat_BA_W.dot(v);
  });
}

}  // namespace stiction::contact
