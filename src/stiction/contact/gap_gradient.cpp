#include "stiction/contact/gap_gradient.hpp"

#include <algorithm>

namespace stiction::contact {

using world::DofKind;
using world::Follower;
using world::Kinematics;
using world::Model;

std::vector<char> joint_flags(const Model& model, std::span<const int> joints) {
  std::vector<char> flags(static_cast<std::size_t>(model.n_a()), 0);
  for (const int j : joints) flags[static_cast<std::size_t>(j)] = 1;
  return flags;
}

void calc_gap_gradient(const Model& model, const Contact& contact, const std::vector<char>& moving, const Kinematics& kinematics,
                       Eigen::Ref<Eigen::VectorXd> gradient) {
  const auto& pair = model.pairs()[static_cast<std::size_t>(contact.pair)];
  const auto axes_of = [&](int geometry) -> const std::vector<int>& {
    return model.bodies()[static_cast<std::size_t>(model.geometries()[static_cast<std::size_t>(geometry)].body)].axes;
  };
  const auto &axes_a = axes_of(pair.geometry_a), &axes_b = axes_of(pair.geometry_b);
  const auto has = [](const std::vector<int>& axes, int axis) { return std::find(axes.begin(), axes.end(), axis) != axes.end(); };
  const auto is_moving = [&](int dof) { return dof >= model.n_vu() && moving[static_cast<std::size_t>(dof - model.n_vu())]; };
  gradient.setZero();
  const auto add = [&](int index, bool moves_a, bool moves_b) {
    const Follower* follower = index < model.n_v() ? nullptr : &model.followers()[static_cast<std::size_t>(index - model.n_v())];
    const int dof = follower ? follower->dof : index;
    if (!is_moving(dof)) return;
    const Eigen::Vector3d axis = kinematics.axis_W.col(index);
    const bool slides = (follower ? follower->kind : model.dofs()[static_cast<std::size_t>(dof)].kind) == DofKind::Prismatic;
    const auto rate = [&](const Eigen::Vector3d& p_W, const Eigen::Vector3d& origin_W) {
      return contact.nhat_BA_W.dot(slides ? axis : Eigen::Vector3d(axis.cross(p_W - origin_W)));
    };
    const Eigen::Vector3d origin = kinematics.origin_W.col(index);
    double phi_rate = 0;
    if (!moves_b)
      phi_rate = rate(contact.p_WA, origin);
    else if (!moves_a)
      phi_rate = -rate(contact.p_WB, origin);
    else if (!slides)
      phi_rate = rate(contact.p_WA, contact.p_WB);  // moved together: only the gap between the two points counts
    gradient[dof - model.n_vu()] += follower ? follower->ratio * phi_rate : phi_rate;
  };
  for (const int axis : axes_a) add(axis, true, has(axes_b, axis));
  for (const int axis : axes_b) {
    if (!has(axes_a, axis)) add(axis, false, true);
  }
}

}  // namespace stiction::contact
