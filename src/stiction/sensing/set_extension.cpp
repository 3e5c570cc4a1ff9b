#include "stiction/sensing/set_extension.hpp"

#include <algorithm>
#include <tuple>

namespace stiction::sensing {

using Eigen::Index;
using Eigen::Matrix3Xd;

namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

ExtensionWorkspace::ExtensionWorkspace(const Sensor& sensor) {
  Index most = 0;
  for (const auto& link : sensor.links()) most = std::max(most, link.batch.rows.cols());
  residuals.resize(most);
}

ContactPoint SetExtension::sample_point(int link, int sample) const {
  const SensedLink& sensed = problem_.sensor.links()[at(link)];
  const SurfacePoint& point = sensed.samples[at(sample)];
  return {.link = link,
          .triangle = point.triangle,
          .p_L = point.p_L,
          .n_L = sensed.surface.normal(point.triangle, point.p_L, problem_.sensor.options().normals)};
}

/// Orthonormal columns that span the torques of any forces at the points of a set.
void SetExtension::fill_span(const ContactSet& set) {
  const ContactRows& rows = problem_.rows;
  work_.span.resize(rows.tau.size(), 3 * kMostContacts);
  rank_ = 0;
  for (int i = 0; i < set.count; ++i) {
    const ContactPoint& point = set.contacts[at(i)];
    work_.map.resize(rows.tau.size(), 3);
    work_.map = rows.J_v[at(point.link)].transpose();
    work_.map.noalias() += rows.J_w[at(point.link)].transpose().lazyProduct(LinkTorque::skew(point.p_L));
    for (Index k = 0; k < 3; ++k) {
      auto column = work_.map.col(k);
      const double length = column.norm();
      for (int pass = 0; pass < 2; ++pass)
        for (Index j = 0; j < rank_; ++j) column -= work_.span.col(j).dot(column) * work_.span.col(j);
      constexpr double kRounding = 1e-9;
      const double left = column.norm();
      if (left > kRounding * length) work_.span.col(rank_++) = column / left;
    }
  }
}

/// M (I − Q Qᵀ).
void SetExtension::project(const Matrix3Xd& M, Matrix3Xd& out) const {
  out = M;
  for (Index j = 0; j < rank_; ++j) out.noalias() -= (M * work_.span.col(j)).lazyProduct(work_.span.col(j).transpose());
}

void SetExtension::hold(const ContactSet& set) {
  fill_span(set);
  work_.tau = problem_.rows.tau;
  for (Index j = 0; j < rank_; ++j) work_.tau -= work_.span.col(j).dot(work_.tau) * work_.span.col(j);
}

std::span<const int> SetExtension::find_samples(int link, int most) {
  const SampleBatch& batch = problem_.sensor.links()[at(link)].batch;
  project(problem_.rows.J_w[at(link)], work_.J_w);
  project(problem_.rows.J_v[at(link)], work_.J_v);
  work_.torque.assign(work_.J_w, work_.J_v, work_.tau, work_.scratch);
  work_.torque.prior = problem_.prior;
  calc_residuals(work_.torque, batch, problem_.cone, work_.residuals);
  work_.order.clear();
  for (int i = 0; i < static_cast<int>(batch.size); ++i) work_.order.push_back(i);
  const auto n = std::min(work_.order.size(), static_cast<std::size_t>(most));
  std::partial_sort(work_.order.begin(), work_.order.begin() + static_cast<std::ptrdiff_t>(n), work_.order.end(),
                    [&](int a, int b) { return std::pair(work_.residuals[a], a) < std::pair(work_.residuals[b], b); });
  return {work_.order.data(), n};
}

std::array<int, kMostContacts> links_of(const ContactSet& set) {
  std::array<int, kMostContacts> out{-1, -1, -1};
  for (int i = 0; i < set.count; ++i) out[at(i)] = set.contacts[at(i)].link;
  return out;
}

bool is_better(const ContactSet& a, const ContactSet& b) {
  const auto rank = [](const ContactSet& set) {
    return std::tuple(set.objective, links_of(set), set.contacts[0].triangle, set.contacts[1].triangle, set.contacts[2].triangle);
  };
  return rank(a) < rank(b);
}

void arrange(ContactSet& set) {
  const auto key = [](const ContactPoint& p) { return std::tuple(p.link, p.p_L.z(), p.p_L.y(), p.p_L.x()); };
  std::sort(set.contacts.begin(), set.contacts.begin() + set.count,
            [&](const ContactPoint& a, const ContactPoint& b) { return key(a) < key(b); });
}

bool is_near(const Sensor& sensor, const ContactSet& a, const ContactSet& b, double radius) {
  for (int i = 0; i < a.count; ++i) {
    const ContactPoint &p = a.contacts[at(i)], &q = b.contacts[at(i)];
    if (p.link != q.link || (p.p_L - q.p_L).norm() > radius * sensor.links()[at(p.link)].spacing) return false;
  }
  return true;
}

}  // namespace stiction::sensing
