#include "stiction/planning/nearest.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace stiction::planning {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kFresh = 64;  // points that wait for a part
constexpr double kMixed = 0.25;     // 1/λ_max of a ball differ by more: it is split by them
constexpr int kLeaf = 8;            // points of a ball that is not split
/// Rotation vectors are right to 4e-8 of their length (world::ObjectSpace::error): bounds give that much away and more.
constexpr double kTrust = 1 - 1e-6;
constexpr int kStackDofs = 64;

/// Storage for an error vector, on the stack for all but the largest scenes.
class ErrorVector {
 public:
  explicit ErrorVector(int n) {
    if (n <= kStackDofs) return;
    heap_.resize(static_cast<std::size_t>(n));
    data_ = heap_.data();
  }
  ErrorVector(const ErrorVector&) = delete;
  double* data() { return data_; }

 private:
  double fixed_[kStackDofs];
  std::vector<double> heap_;
  double* data_ = fixed_;
};

/// λ_max of a symmetric matrix from above: ‖M²‖_F^½, at most n^¼ too large.
double largest_eigenvalue_bound(const Eigen::MatrixXd& M) { return std::sqrt((M * M).norm()); }

}  // namespace

struct NearestPoints::Search {
  const double* q;
  double* e;
  int best = -1;
  double distance = kInfinity;
  long evaluated = 0;
};

NearestPoints::NearestPoints(const world::ObjectSpace& space) : space_(&space), n_form_(space.n_v() * (space.n_v() + 1) / 2) {}

void NearestPoints::add(const Eigen::VectorXd& c, const Eigen::MatrixXd& S, const Eigen::MatrixXd& L_inv) {
  const int n_v = space_->n_v();
  centres_.insert(centres_.end(), c.data(), c.data() + space_->n_q());
  for (int r = 0; r < n_v; ++r) {
    for (int k = 0; k <= r; ++k) {
      covariances_.push_back(S(r, k));
      factors_.push_back(L_inv(r, k));
    }
  }
  fresh_.push_back(size());
  removed_.push_back(0);
  if (fresh_.size() < kFresh) return;
  std::vector<int> points = std::move(fresh_);
  fresh_.clear();
  while (!parts_.empty() && parts_.back().points.size() <= points.size()) {
    points.insert(points.end(), parts_.back().points.begin(), parts_.back().points.end());
    parts_.pop_back();
  }
  std::erase_if(points, [&](int i) { return removed(i); });
  if (!points.empty()) parts_.push_back(make_part(std::move(points)));
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

double NearestPoints::distance(int i, const double* q) const {
  ErrorVector e(space_->n_v());
  space_->error(centre(i), q, e.data());
  return form(i, e.data(), kInfinity);
}

double NearestPoints::distance(int i, const double* q, const std::vector<int>& v) const {
  ErrorVector all(space_->n_v());
  space_->error(centre(i), q, all.data());
  const double* S = covariances_.data() + static_cast<std::ptrdiff_t>(i) * n_form_;
  const auto n = static_cast<Eigen::Index>(v.size());
  Eigen::VectorXd e(n);
  Eigen::MatrixXd S_v(n, n);
  for (Eigen::Index r = 0; r < n; ++r) {
    const int row = v[static_cast<std::size_t>(r)];
    e[r] = all.data()[row];
    for (Eigen::Index c = 0; c <= r; ++c) S_v(r, c) = S[row * (row + 1) / 2 + v[static_cast<std::size_t>(c)]];  // v ascends
  }
  return S_v.selfadjointView<Eigen::Lower>().llt().matrixL().solve(e).squaredNorm();
}

NearestPoints::Part NearestPoints::make_part(std::vector<int> points) const {
  const int n_v = space_->n_v();
  Part part;
  part.points = std::move(points);
  std::ranges::sort(part.points);
  // D makes the mean of D S D one on the diagonal: with a metric that is round on the whole, λ_max bounds most.
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(n_v);
  const auto S = [&](int i, int r, int c) { return covariances_[static_cast<std::size_t>(i * n_form_ + r * (r + 1) / 2 + c)]; };
  for (const int i : part.points) {
    for (int r = 0; r < n_v; ++r) mean[r] += S(i, r, r) / static_cast<double>(part.points.size());
  }
  space_->make_isotropic(mean);
  part.weights = mean.cwiseInverse();
  const Eigen::VectorXd D = part.weights.cwiseSqrt();
  part.least.resize(static_cast<std::size_t>(size()));  // by point while balls are made, then beside them
  Eigen::MatrixXd M(n_v, n_v);
  for (const int i : part.points) {
    for (int r = 0; r < n_v; ++r) {
      for (int c = 0; c <= r; ++c) M(r, c) = M(c, r) = D[r] * S(i, r, c) * D[c];
    }
    part.least[static_cast<std::size_t>(i)] = 1 / largest_eigenvalue_bound(M);
  }
  add_ball(part, 0, static_cast<int>(part.points.size()));
  std::vector<double> least;
  for (const int i : part.points) least.push_back(part.least[static_cast<std::size_t>(i)]);
  part.least = std::move(least);
  return part;
}

/// Splits between two points far from each other; the centre is the point nearest to both.
int NearestPoints::add_ball(Part& part, int begin, int end) const {
  const auto n = static_cast<std::size_t>(end - begin);
  const auto first = part.points.begin() + begin;
  std::vector<double> to_b(n), to_c(n);
  const auto measure = [&](int from, std::vector<double>& out) {
    for (std::size_t k = 0; k < n; ++k) out[k] = chord(part, first[static_cast<std::ptrdiff_t>(k)], centre(from));
    return first[std::ranges::max_element(out) - out.begin()];
  };
  const int b = measure(*first, to_b);
  const int c = measure(b, to_b);
  measure(c, to_c);

  Ball ball{.centre = *first, .begin = begin, .end = end};
  double nearest = kInfinity;
  ball.least = kInfinity;
  std::vector<std::pair<double, int>> side(n);
  double most = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const int i = first[static_cast<std::ptrdiff_t>(k)];
    side[k] = {to_b[k] - to_c[k], i};
    const double bound = part.least[static_cast<std::size_t>(i)];
    ball.least = std::min(ball.least, bound);
    most = std::max(most, bound);
    if (std::max(to_b[k], to_c[k]) < nearest) nearest = std::max(to_b[k], to_c[k]), ball.centre = i;
  }
  for (std::size_t k = 0; k < n; ++k) {
    ball.radius = std::max(ball.radius, chord(part, first[static_cast<std::ptrdiff_t>(k)], centre(ball.centre)));
  }
  const auto index = static_cast<int>(part.balls.size());
  part.balls.push_back(ball);
  if (end - begin <= kLeaf) return index;
  // One long metric would weaken the bound of all: first part those from the short ones.
  if (ball.least < kMixed * most) {
    for (std::size_t k = 0; k < n; ++k) side[k].first = part.least[static_cast<std::size_t>(side[k].second)];
  }
  const int middle = begin + (end - begin) / 2;
  std::ranges::nth_element(side, side.begin() + (middle - begin));
  for (std::size_t k = 0; k < n; ++k) first[static_cast<std::ptrdiff_t>(k)] = side[k].second;
  const int left = add_ball(part, begin, middle);
  const int right = add_ball(part, middle, end);
  part.balls[static_cast<std::size_t>(index)].left = left;
  part.balls[static_cast<std::size_t>(index)].right = right;
  return index;
}

void NearestPoints::consider(int i, Search& search) const {
  if (removed(i)) return;
  ++search.evaluated;
  space_->error(centre(i), search.q, search.e);
  const double d = form(i, search.e, search.distance);
  if (d < search.distance || (d == search.distance && i < search.best)) search.distance = d, search.best = i;
}

void NearestPoints::descend(const Part& part, int index, Search& search) const {
  const Ball& ball = part.balls[static_cast<std::size_t>(index)];
  if (ball.left < 0) {
    for (int k = ball.begin; k < ball.end; ++k) {
      const int i = part.points[static_cast<std::size_t>(k)];
      const double length = kTrust * chord(part, i, search.q);
      if (length * length * part.least[static_cast<std::size_t>(k)] <= search.distance) consider(i, search);
    }
    return;
  }
  std::pair<double, int> child[2] = {{0, ball.left}, {0, ball.right}};
  for (auto& [bound, at] : child) {
    const Ball& b = part.balls[static_cast<std::size_t>(at)];
    const double gap = kTrust * chord(part, b.centre, search.q) - b.radius / kTrust;
    bound = gap > 0 ? gap * gap * b.least : 0;
  }
  if (child[1] < child[0]) std::swap(child[0], child[1]);
  for (const auto& [bound, at] : child) {
    if (bound <= search.distance) descend(part, at, search);
  }
}

int NearestPoints::nearest(const double* q, long* evaluated) const {
  ErrorVector e(space_->n_v());
  Search search{.q = q, .e = e.data()};
  for (const int i : fresh_) consider(i, search);
  for (const Part& part : parts_) descend(part, 0, search);
  if (evaluated != nullptr) *evaluated = search.evaluated;
  return search.best;
}

}  // namespace stiction::planning
