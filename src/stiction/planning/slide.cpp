#include "stiction/planning/slide.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace stiction::planning {
namespace {

/// Contacts of a branch that are nearer than kSlideReach.
std::vector<contact::Contact> touching(const world::Model& model, const RobotChains& chains, int branch, GeometryWorkspace& work) {
  contact::query_pairs(model, work.kinematics, chains.pairs_against(branch), kSlideReach, work.contact_work, work.contacts);
  std::vector<contact::Contact> contacts(work.contacts.begin(), work.contacts.end());
  std::erase_if(contacts, [](const auto& c) { return c.phi > kSlideReach; });
  return contacts;
}

}  // namespace

std::optional<Slide> draw_slide(const world::Model& model, const RobotChains& chains, const Eigen::VectorXd& q, core::Random& random,
                                GeometryWorkspace& work) {
  world::calc_kinematics(model, q, work.kinematics_work, work.kinematics);
  std::vector<std::pair<int, contact::Contact>> places;
  for (int branch = 0; branch < chains.size(); ++branch) {
    for (const auto& contact : touching(model, chains, branch, work)) {
      if (chains.touches_object(contact.pair)) places.emplace_back(branch, contact);
    }
  }
  if (places.empty()) return std::nullopt;
  auto [branch, along] = places[static_cast<std::size_t>(random.index(static_cast<int>(places.size())))];
  const Eigen::Vector3d n = along.nhat_BA_W, t = n.unitOrthogonal();
  const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
  along.nhat_BA_W = std::cos(angle) * t + std::sin(angle) * n.cross(t);  // the rate of a gap along t instead of n

  const auto contacts = touching(model, chains, branch, work);
  const auto m = static_cast<Eigen::Index>(contacts.size());
  Eigen::MatrixXd A(model.n_a(), m + 1);
  for (Eigen::Index i = 0; i < m; ++i) A.col(i) = gap_gradient(model, contacts[static_cast<std::size_t>(i)], chains.joints(branch), work);
  A.col(m) = gap_gradient(model, along, chains.joints(branch), work);
  Eigen::MatrixXd S = A.transpose() * A;
  S.diagonal().array() += 1e-8;  // gaps may depend on each other
  Eigen::VectorXd delta = A * S.ldlt().solve(Eigen::VectorXd::Unit(m + 1, m));
  // not where t is barred: then the regularisation takes it all
  if (std::abs(A.col(m).dot(delta) - 1) > 0.01) return std::nullopt;
  return Slide{branch, delta.normalized()};
}

}  // namespace stiction::planning
