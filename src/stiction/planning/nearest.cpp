#include "stiction/planning/nearest.hpp"

#include <Eigen/Cholesky>
#include <limits>

namespace stiction::planning {

NearestPoints::NearestPoints(const world::ObjectSpace& space) : space_(&space), n_form_(space.n_v() * (space.n_v() + 1) / 2) {}

void NearestPoints::add(const Eigen::VectorXd& c, const Eigen::MatrixXd& S, const Eigen::MatrixXd& L_inv) {
  centres_.insert(centres_.end(), c.data(), c.data() + space_->n_q());
  for (int r = 0; r < space_->n_v(); ++r) {
    for (int k = 0; k <= r; ++k) {
      covariances_.push_back(S(r, k));
      factors_.push_back(L_inv(r, k));
    }
  }
  removed_.push_back(0);
}

/// eᵀS⁻¹e = ‖L⁻¹e‖²; stops where the sum exceeds `enough`.
double NearestPoints::form(int i, const double* e, double enough) const {
  const double* L = factors_.data() + static_cast<std::ptrdiff_t>(i) * n_form_;
  double d = 0;
  for (int r = 0; r < space_->n_v() && d <= enough; ++r) {
    double y = 0;
    for (int c = 0; c <= r; ++c) y += *L++ * e[c];
    d += y * y;
  }
  return d;
}

double NearestPoints::form_of_some(int i, const double* e, const std::vector<int>& v) const {
  const double* S = covariances_.data() + static_cast<std::ptrdiff_t>(i) * n_form_;
  const auto n = static_cast<Eigen::Index>(v.size());
  Eigen::VectorXd e_v(n);
  Eigen::MatrixXd S_v(n, n);
  for (Eigen::Index r = 0; r < n; ++r) {
    const int row = v[static_cast<std::size_t>(r)];
    e_v[r] = e[row];
    for (Eigen::Index c = 0; c <= r; ++c) S_v(r, c) = S[row * (row + 1) / 2 + v[static_cast<std::size_t>(c)]];
  }
  return S_v.selfadjointView<Eigen::Lower>().llt().matrixL().solve(e_v).squaredNorm();
}

double NearestPoints::distance(int i, const double* q, const std::vector<int>& v) const {
  Eigen::VectorXd e(space_->n_v());
  space_->error(centre(i), q, e.data());
  return v.empty() ? form(i, e.data(), std::numeric_limits<double>::infinity()) : form_of_some(i, e.data(), v);
}

int NearestPoints::nearest(const double* q, const std::vector<int>& v) const {
  Eigen::VectorXd e(space_->n_v());
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < size(); ++i) {
    if (removed(i)) continue;
    space_->error(centre(i), q, e.data());
    const double d = v.empty() ? form(i, e.data(), least) : form_of_some(i, e.data(), v);
    if (d < least) least = d, best = i;
  }
  return best;
}

}  // namespace stiction::planning
