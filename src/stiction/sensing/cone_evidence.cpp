#include "stiction/sensing/cone_evidence.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "stiction/sensing/residual.hpp"

namespace stiction::sensing {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kDrop = 18;  // e^−18 of the largest value counts as nothing
constexpr double kFar = 4;    // e is far outside if ½(T² − t²) of the nearest direction of the cone exceeds this

struct Node {
  double x, weight;
};

/// Gauss–Legendre on [−1, 1], by Newton's method on the Legendre polynomial.
template <std::size_t n>
std::array<Node, n> make_nodes() {
  std::array<Node, n> out{};
  for (std::size_t i = 0; i < n; ++i) {
    double x = std::cos(kPi * (static_cast<double>(i) + 0.75) / (static_cast<double>(n) + 0.5)), slope = 1;
    for (int step = 0; step < 20; ++step) {
      double previous = 1, value = x;
      for (std::size_t k = 2; k <= n; ++k) {
        const auto order = static_cast<double>(k);
        const double next = ((2 * order - 1) * x * value - (order - 1) * previous) / order;
        previous = value;
        value = next;
      }
      slope = static_cast<double>(n) * (x * value - previous) / (x * x - 1);
      x -= value / slope;
    }
    out[i] = {x, 2 / ((1 - x * x) * slope * slope)};
  }
  return out;
}

const std::array<Node, 10>& nodes() {
  static const auto out = make_nodes<10>();
  return out;
}

template <class Function>
double integrate(double from, double to, const Function& function) {
  if (!(from < to)) return 0;
  double sum = 0;
  for (const Node& node : nodes()) sum += node.weight * function(0.5 * (from + to) + 0.5 * (to - from) * node.x);
  return 0.5 * (to - from) * sum;
}

/// S(t) of t ≤ 0, and S(t) e^{−t²/2} = e^{−t²/2} + t √(2π) Φ(t) of t > 0, on a grid, between which cubics with the exact slopes run.
class Table {
 public:
  static constexpr double kEnd = 8;

  Table() {
    for (std::size_t i = 0; i < kSize; ++i) {
      const double t = -kEnd + static_cast<double>(i) * kStep, below = kRoot * 0.5 * std::erfc(-t / std::numbers::sqrt2);
      const double growth = std::exp(0.5 * t * t);
      nodes_[i] =
          t > 0 ? Value{1 / growth + t * below, kStep * below} : Value{1 + t * below * growth, kStep * ((1 + t * t) * below * growth + t)};
    }
  }
  double operator()(double t) const {
    const double at = (t + kEnd) / kStep;
    const auto i = std::min(static_cast<std::size_t>(at), kSize - 2);
    const double x = at - static_cast<double>(i), y = 1 - x;
    const Value &a = nodes_[i], &b = nodes_[i + 1];
    return y * y * ((1 + 2 * x) * a.value + x * a.slope) + x * x * ((1 + 2 * y) * b.value - y * b.slope);
  }

 private:
  struct Value {
    double value, slope;  ///< slope: of a step
  };
  static constexpr double kStep = 1.0 / 32, kRoot = 2.5066282746310002;  // √(2π)
  static constexpr std::size_t kSize = static_cast<std::size_t>(2 * kEnd / kStep) + 1;
  std::array<Value, kSize> nodes_;
};

/// S(t) e^{−shift} = (1 + t √(2π) Φ(t) e^{t²/2}) e^{−shift}. @param scale  e^{−shift}
double scaled_primitive(double t, double shift, double scale) {
  static const Table table;
  if (t < -Table::kEnd) {
    const double s = 1 / (t * t);  // 1 + t E(t) as a series, of which the rest cancels
    return scale * s * (1 - s * (3 - s * (15 - 105 * s)));
  }
  if (t <= 0) return scale * table(t);
  return (t < Table::kEnd ? table(t) : t * std::sqrt(2 * kPi)) * std::exp(0.5 * t * t - shift);
}

/// One edge of the cone of directions: part of a great circle, from angle `from` to `to` about the point of it nearest to e.
struct Edge {
  double s, c;  ///< sine (> 0 where e is on the inner side) and cosine of the distance of e from the circle
  double from, to;

  Edge(const Vector3d& e, const Vector3d& w_i, const Vector3d& w_j) {
    const Vector3d n = w_i.cross(w_j).normalized();
    s = std::clamp(e.dot(n), -1.0, 1.0);
    const Vector3d foot = e - s * n;
    c = foot.norm();
    const Vector3d p = c > 0 ? Vector3d(foot / c) : w_i, q = n.cross(p);
    from = std::atan2(w_i.dot(q), w_i.dot(p));
    to = std::atan2(w_j.dot(q), w_j.dot(p));
    if (to < from) to += 2 * kPi;
    if (from + to > 2 * kPi) {  // so that its middle is within half a turn of the foot
      from -= 2 * kPi;
      to -= 2 * kPi;
    }
  }

  /// Largest e·w on the edge.
  double nearest() const { return from <= 0 && to >= 0 ? c : c * std::max(std::cos(from), std::cos(to)); }
  /// ψ at an angle, growing with it.
  double azimuth(double angle) const {
    const double turns = std::round(angle / (2 * kPi));
    return std::atan2(std::sin(angle), std::abs(s) * std::cos(angle)) + 2 * kPi * turns;
  }
  double d_azimuth(double angle) const {
    const double sine = std::sin(angle), cosine = std::cos(angle);
    return std::abs(s) / (sine * sine + s * s * cosine * cosine);
  }
};

/// ∫ [S(±T) − S(t)] dψ e^{−shift} over an edge. Within a quarter of the circle about the foot tan angle = |s| sinh v, and the integrand is smooth in v.
/// @param pole  e or −e, which the cone holds or is near to: all = S(±T)
double near_edge(const Edge& edge, double T, int pole, double shift) {
  const double scale = std::exp(-shift), all = scaled_primitive(pole * T, shift, scale);
  const double sign = edge.s < 0 ? -1 : 1, turn = edge.azimuth(edge.to) - edge.azimuth(edge.from);
  const double t_near = T * edge.nearest();
  if (0.5 * (T * T - t_near * t_near) > kDrop && t_near > 0 && pole > 0) return sign * all * turn;
  const double s = std::max(std::abs(edge.s), 1e-12), quarter = 0.5 * kPi * (1 - 1e-9);
  double sum = 0;
  // From here on S(t) is negligible against S(T).
  const double v_gone = pole > 0 && T * T > 2 * kDrop
                            ? std::asinh(std::sqrt(std::max(0.0, T * T * edge.c * edge.c / (T * T - 2 * kDrop) - 1)) / s)
                            : std::numeric_limits<double>::infinity();
  const auto add_inner = [&](double from, double to) {  // 0 ≤ from ≤ to
    if (!(from < to)) return;
    constexpr double kPanel = 4;
    const double first = std::asinh(std::tan(from) / s), last = std::asinh(std::tan(to) / s), middle = std::clamp(v_gone, first, last);
    const auto value = [&](double v) {
      const double growth = std::exp(v), tan = 0.5 * s * (growth - 1 / growth);
      return (all - scaled_primitive(T * edge.c / std::sqrt(1 + tan * tan), shift, scale)) * 2 / (growth + 1 / growth);
    };
    const int panels = static_cast<int>(std::ceil((middle - first) / kPanel));
    for (int i = 0; i < panels; ++i)
      sum += integrate(first + (middle - first) * i / panels, first + (middle - first) * (i + 1) / panels, value);
    if (middle < last) sum += all * (edge.azimuth(to) - std::atan(std::sinh(middle)));
  };
  const auto add_outer = [&](double from, double to) {
    if (!(from < to)) return;
    const double first = edge.azimuth(from), last = edge.azimuth(to);
    sum += integrate(first, last, [&](double psi) {
      const double tangent = std::hypot(s * std::sin(psi), std::cos(psi));
      return all - scaled_primitive(T * edge.c * std::cos(psi) / tangent, shift, scale);
    });
  };
  const double from = edge.from, to = edge.to;
  add_inner(std::clamp(-to, 0.0, quarter), std::clamp(-from, 0.0, quarter));
  add_inner(std::clamp(from, 0.0, quarter), std::clamp(to, 0.0, quarter));
  add_outer(from, std::min(to, -quarter));
  add_outer(std::max(from, quarter), to);
  return sign * sum;
}

/// −∫ S(t) dψ e^{−shift} over an edge, where t²/2 is within kDrop of its largest value.
double far_edge(const Edge& edge, double T, double shift) {
  const double scale = std::exp(-shift);
  const double t_near = T * edge.nearest();
  if (t_near > 0 && shift - 0.5 * t_near * t_near > kDrop) return 0;
  double from = edge.from, to = edge.to;
  const double square = t_near > 0 ? t_near * t_near - 2 * kDrop : 0;
  if (square > 0) {
    const double window = std::acos(std::min(1.0, std::sqrt(square) / (T * edge.c)));
    from = std::max(from, -window);
    to = std::min(to, window);
  }
  const double middle = std::clamp(0.0, from, std::max(from, to));
  const auto value = [&](double angle) { return scaled_primitive(T * edge.c * std::cos(angle), shift, scale) * edge.d_azimuth(angle); };
  return (edge.s < 0 ? 1 : -1) * (integrate(from, middle, value) + integrate(middle, to, value));
}

FrictionCone make_polyhedral(const FrictionCone& cone) {
  if (!cone.is_lorentz()) return cone;
  constexpr int kRays = 16;
  const double corner = 2 * kPi / kRays;
  return FrictionCone(cone.friction() * std::sqrt(corner / std::sin(corner)), kRays);
}

/// ∫₀^∞ exp(g s − ½ h s²) ds.
double log_ray_integral(double h, double g) {
  const double t = g / std::sqrt(h);
  constexpr double kSeries = -8;
  if (t < kSeries) return -std::log(-g) + std::log1p(-1 / (t * t));
  return 0.5 * std::log(2 * kPi / h) + std::log(0.5 * std::erfc(-t / std::numbers::sqrt2)) + 0.5 * t * t;
}

}  // namespace

ConeEvidence::ConeEvidence(const FrictionCone& cone, std::vector<double> forces)
    : cone_(make_polyhedral(cone)), forces_(std::move(forces)), friction_(cone.friction()), is_exact_(cone.is_lorentz()) {
  for (const double force : forces_) log_priors_.push_back(log_integral(Matrix3d::Identity() / (force * force), Vector3d::Zero()));
}

double ConeEvidence::log_evidence(const Matrix3d& precision, const Vector3d& b) const {
  double most = -std::numeric_limits<double>::infinity(), sum = 0;
  for (std::size_t k = 0; k < forces_.size(); ++k) {
    const double value = log_integral(precision + Matrix3d::Identity() / (forces_[k] * forces_[k]), b) - log_priors_[k];
    sum = value > most ? sum * std::exp(most - value) + 1 : sum + std::exp(value - most);
    most = std::max(most, value);
  }
  return most + std::log(sum / static_cast<double>(forces_.size()));
}

double ConeEvidence::log_integral(const Matrix3d& H, const Vector3d& b) const {
  const Eigen::Matrix3Xd& rays = cone_.ray_matrix();
  if (rays.cols() == 1) return log_ray_integral(H(0, 0), b[0]);  // no friction
  const Eigen::LLT<Matrix3d> factor(H);
  const Matrix3d L = factor.matrixL();
  const Vector3d scaled = L.triangularView<Eigen::Lower>().solve(b);
  constexpr double kLeast = 1e-4;  // a smaller T has no effect
  const double T = std::max(scaled.norm(), kLeast);
  const Vector3d e = scaled.norm() > 0 ? Vector3d(scaled.normalized()) : (L.transpose() * Vector3d::UnitX()).normalized();
  const double shift = -0.5 * minimize_polyhedral(H, b, cone_).value;
  std::array<std::optional<Edge>, FrictionCone::kMostRays> edges;
  const auto n = static_cast<std::size_t>(rays.cols());
  Vector3d w = (L.transpose() * rays.rightCols<1>()).normalized();
  bool holds_opposite = true;  // −e is in the cone
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d next = (L.transpose() * rays.col(static_cast<Eigen::Index>(i))).normalized();
    edges[i].emplace(e, w, next);
    holds_opposite = holds_opposite && edges[i]->s < 0;
    w = next;
  }
  const bool is_far = !holds_opposite && 0.5 * T * T - shift > kFar;
  const int pole = holds_opposite ? -1 : 1;
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += is_far ? far_edge(*edges[i], T, shift) : near_edge(*edges[i], T, pole, shift);
  const double tiny = std::numeric_limits<double>::min();
  return shift - L.diagonal().array().log().sum() + std::log(std::max(sum / T, tiny));
}

}  // namespace stiction::sensing
