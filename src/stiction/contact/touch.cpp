#include "stiction/contact/touch.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "stiction/contact/gap_gradient.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::contact {
namespace {

constexpr double kFlat = 1e-3;  // a gap whose gradient is smaller cannot be closed [L per joint unit]
constexpr int kNewtonSteps = 15;
constexpr int kPatience = 4;      // Newton steps in which the gaps must halve; a pair that is out of reach fails this test
constexpr double kMaxStep = 0.3;  // largest motion of a joint per Newton step [rad, L]

}  // namespace

bool touch(const world::Model& model, std::span<const int> pairs, const std::vector<char>& moving, Eigen::VectorXd& q,
           GeometryWorkspace& work, std::span<const double> wanted) {
  const auto k = static_cast<Eigen::Index>(pairs.size());
  std::vector<int> bodies;
  for (const int i : pairs) {
    const world::Pair& pair = model.pairs()[static_cast<std::size_t>(i)];
    for (const int g : {pair.geometry_a, pair.geometry_b}) bodies.push_back(model.geometries()[static_cast<std::size_t>(g)].body);
  }
  work.links.select(model, moving, bodies);
  const double length = model.scales().robots().length, close_enough = 0.5 * kTouch * world::share::kContact * length;
  const Eigen::VectorXd& unit = model.scales().joints();  // joint units, in which the length of a step is measured
  std::vector<Contact> contacts(pairs.size());
  Eigen::VectorXd gaps(k), forward(k), step(model.n_a());
  Eigen::MatrixXd slopes(model.n_a(), k);  // dφ/d(q/unit), one column per gap
  double widest = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < kNewtonSteps; ++iteration) {
    work.links.update(model, q, work.kinematics);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Distance d = pair_distance(model, work.kinematics, pairs[i], work.contact_work);
      Contact& c = contacts[i];
      c.pair = pairs[i];
      c.phi = d.phi;
      gaps[static_cast<Eigen::Index>(i)] = d.phi - (wanted.empty() ? 0.0 : wanted[i]);
      c.p_WA = d.p_WA;
      c.p_WB = d.p_WB;
      c.nhat_BA_W = d.nhat_BA_W;
    }
    const double now = gaps.cwiseAbs().maxCoeff();
    if (now < close_enough) return true;
    if (iteration % kPatience == 0 && now > 0.5 * std::exchange(widest, now)) return false;
    for (Eigen::Index i = 0; i < k; ++i) {
      calc_gap_gradient(model, contacts[static_cast<std::size_t>(i)], moving, work.kinematics, slopes.col(i));
      slopes.col(i).array() *= unit.array();
    }
    if (k == 1) {
      const double slope2 = slopes.squaredNorm();
      if (!(slope2 > std::pow(kFlat * length, 2))) return false;
      forward[0] = -gaps[0] / slope2;
    } else {
      const Eigen::MatrixXd gram = slopes.transpose() * slopes;
      if (!(gram.determinant() > std::pow(kFlat * length, 2 * static_cast<double>(k)))) return false;
      forward = gram.inverse() * -gaps;
    }
    step.noalias() = slopes * forward;
    step *= std::min(1.0, kMaxStep / step.cwiseAbs().maxCoeff());
    q.tail(model.n_a()) = (q.tail(model.n_a()) + step.cwiseProduct(unit)).cwiseMax(model.lower()).cwiseMin(model.upper());
  }
  return false;
}

}  // namespace stiction::contact
