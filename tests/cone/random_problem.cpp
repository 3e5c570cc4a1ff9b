#include "cone/random_problem.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "stiction/core/random.hpp"

namespace stiction::cone::test {
namespace {

using core::Random;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d unit(Random& random) {
  Vector3d v(random.normal(), random.normal(), random.normal());
  return v.norm() < 1e-6 ? Vector3d::UnitX() : Vector3d(v.normalized());
}

double leaves_cone(const Eigen::Ref<const VectorXd>& v) {
  return v.size() == 1 ? std::max(0.0, -v[0]) : std::max(0.0, std::hypot(v[1], v[2]) - v[0]);
}

template <class F>
void for_each_block(const RawProblem& raw, F&& f) {  // f(first row, components, sigma, g)
  int at = 0;
  for (const auto& r : raw.cones) f(at, 3, r.sigma), at += 3;
  for (const auto& r : raw.lines) f(at, 1, r.sigma), at += 1;
  for (const auto& r : raw.bounds) f(at, 1, r.sigma), at += 1;
}

}  // namespace

Problem RawProblem::make() const {
  auto layout = std::make_shared<Layout>(n, groups);
  for (const auto& r : cones) layout->add_support(r.variables);
  for (const auto& r : lines) layout->add_support(r.variables);
  Problem problem(layout, static_cast<int>(cones.size()), static_cast<int>(lines.size()));
  fill(problem);
  return problem;
}

void RawProblem::fill(Problem& problem) const {
  problem.clear();
  Layout layout = problem.layout();  // a copy, only to look supports up
  for (const auto& group : groups) {
    for (const int i : group) {
      for (const int j : group) {
        if (i >= j) problem.set_Q(i, j, Q(i, j));
      }
    }
  }
  for (int i = 0; i < n; ++i) problem.set_b(i, b[i]);
  for (std::size_t i = 0; i < units.size(); ++i) problem.set_unit(static_cast<int>(i), units[i]);
  for (const auto& r : cones) problem.add_cone(r.id, layout.add_support(r.variables), r.G.data(), r.g.data(), r.sigma, r.unit);
  for (const auto& r : lines) problem.add_half_line(r.id, layout.add_support(r.variables), r.G.data(), r.g[0], r.sigma, r.unit);
  for (const auto& r : bounds) problem.add_bound(r.id, r.variable, r.sign, r.offset, r.sigma, r.unit, r.give);
}

RawProblem RawProblem::rescaled(const VectorXd& of_x, const VectorXd& of_w, double work) const {
  RawProblem out = *this;
  out.Q = work * (of_x.asDiagonal() * Q * of_x.asDiagonal());
  out.b = work * of_x.cwiseProduct(b);
  for (const double d : of_x) out.units.push_back({1 / d, work});
  Eigen::Index row = 0;
  for (auto* rows : {&out.cones, &out.lines}) {
    for (auto& r : *rows) {
      const double length = of_w[row++];
      for (std::size_t c = 0; c < r.variables.size(); ++c) r.G.col(static_cast<Eigen::Index>(c)) *= length * of_x[r.variables[c]];
      r.g *= length;
      r.sigma *= work;
      r.unit = {length, work};
    }
  }
  for (auto& r : out.bounds) {  // w = ±x + g: in the unit of x
    const double length = 1 / of_x[r.variable];
    r.offset *= length;
    r.sigma *= work;
    r.give *= length * length / work;
    r.unit = {length, work};
  }
  return out;
}

MatrixXd RawProblem::stacked_G() const {
  MatrixXd G = MatrixXd::Zero(static_cast<Eigen::Index>(3 * cones.size() + lines.size() + bounds.size()), n);
  Eigen::Index at = 0;
  for (const auto* rows : {&cones, &lines}) {
    for (const auto& r : *rows) {
      for (std::size_t c = 0; c < r.variables.size(); ++c) {
        G.block(at, r.variables[c], r.G.rows(), 1) += r.G.col(static_cast<Eigen::Index>(c));
      }
      at += r.G.rows();
    }
  }
  for (const auto& r : bounds) G(at++, r.variable) = r.sign;
  return G;
}

VectorXd RawProblem::stacked_g() const {
  VectorXd g(static_cast<Eigen::Index>(3 * cones.size() + lines.size() + bounds.size()));
  Eigen::Index at = 0;
  for (const auto* rows : {&cones, &lines}) {
    for (const auto& r : *rows) g.segment(at, r.g.size()) = r.g, at += r.g.size();
  }
  for (const auto& r : bounds) g[at++] = r.offset;
  return g;
}

VectorXd RawProblem::stacked_give() const {
  VectorXd give = VectorXd::Zero(stacked_g().size());
  Eigen::Index at = give.size() - static_cast<Eigen::Index>(bounds.size());
  for (const auto& r : bounds) give[at++] = r.give;
  return give;
}

VectorXd stacked_w(const Result& r) {
  VectorXd w(3 * r.w_cone.cols() + r.w_half_line.size() + r.w_bound.size());
  w << r.w_cone.reshaped(), r.w_half_line, r.w_bound;
  return w;
}

VectorXd stacked_z(const Result& r) {
  VectorXd z(3 * r.z_cone.cols() + r.z_half_line.size() + r.z_bound.size());
  z << r.z_cone.reshaped(), r.z_half_line, r.z_bound;
  return z;
}

Kkt recompute(const RawProblem& raw, const Result& result, Mode mode) {
  const MatrixXd G = raw.stacked_G();
  const VectorXd g = raw.stacked_g(), w = stacked_w(result), z = stacked_z(result);
  const VectorXd Qx = raw.Q * result.x;
  const VectorXd Gtz = G.transpose() * z, size = G.cwiseAbs().transpose() * z.cwiseAbs();
  const VectorXd raw_w = G * result.x + g + raw.stacked_give().cwiseProduct(z);
  Kkt k;
  for (int i = 0; i < raw.n; ++i) {
    const double scale = std::max({1.0, std::abs(raw.b[i]), std::abs(Qx[i]), size[i]});
    k.stationarity = std::max(k.stationarity, std::abs(Qx[i] + raw.b[i] - Gtz[i]) / scale);
  }
  for_each_block(raw, [&](int at, int r, double sigma) {
    const double scale = std::max(1.0, g.segment(at, r).cwiseAbs().maxCoeff());
    k.cone = std::max({k.cone, leaves_cone(raw_w.segment(at, r)) / scale, leaves_cone(z.segment(at, r))});
    k.consistency = std::max(k.consistency, (w - raw_w).segment(at, r).cwiseAbs().maxCoeff() / scale);
    const double wz = w.segment(at, r).dot(z.segment(at, r));
    if (mode == Mode::Exact) {
      k.complementarity = std::max(k.complementarity, std::abs(wz) / std::max(1.0, raw.b.lpNorm<Eigen::Infinity>()));
      return;
    }
    double off = std::abs(wz - sigma);
    for (int j = 1; j < r; ++j) off = std::max(off, std::abs(w[at] * z[at + j] + z[at] * w[at + j]));
    // w and z are rounded: w∘z is not known better than to a few ulp of w₀z₀.
    k.complementarity = std::max(k.complementarity, std::max(0.0, off - 2e-14 * w[at] * z[at]) / sigma);
  });
  return k;
}

Certificate check_certificate(const RawProblem& raw, const Result& result, Mode mode) {
  const VectorXd z = (raw.stacked_give().array() > 0).select(0, stacked_z(result)), g = raw.stacked_g();
  Certificate c;
  c.margin = (-g.dot(z) - 10 * (raw.stacked_G().transpose() * z).lpNorm<1>()) / g.cwiseAbs().dot(z.cwiseAbs());
  double size = 0;
  for_each_block(raw, [&](int at, int, double) { size += z[at]; });
  if (mode == Mode::Smoothed) c.margin += 1e-6 * size / g.cwiseAbs().dot(z.cwiseAbs());
  for_each_block(raw, [&](int at, int r, double) { c.cone = std::max(c.cone, leaves_cone(z.segment(at, r))); });
  return c;
}

/// A variable becomes a spring of its own, coupled to no other, whose energy ½k(x − x̂)² goes on linearly where its pull to `side` exceeds `share` · k.
void saturate(RawProblem& raw, int i, double side, double share, std::uint64_t id) {
  const double k = raw.Q(i, i), at_rest = -raw.b[i] / k;
  raw.Q.row(i).setZero();
  raw.Q.col(i).setZero();
  raw.b[i] = -side * share * k;
  raw.bounds.push_back({.id = id, .variable = i, .sign = -side, .offset = side * at_rest - share, .sigma = 1e-6 * k, .give = 1 / k});
}

RawProblem make_random(std::uint64_t seed, const RandomOptions& o) {
  Random random(seed, 77);
  RawProblem raw;
  constexpr double kStep = 0.1;
  const int n_bodies = 1 + random.index(6), n_chains = 1 + random.index(4);
  struct Part {
    bool chain;
    int first, n;
    Vector3d centre;
  };
  std::vector<Part> parts;
  std::vector<double> diagonal, b;
  const auto add_part = [&](bool chain, int n) {
    std::vector<int> members;
    for (int i = 0; i < n; ++i) members.push_back(raw.n + i);
    parts.push_back({chain, raw.n, n, Vector3d(random.normal(), random.normal(), random.normal()) * 0.1});
    raw.groups.push_back(members);
    raw.n += n;
  };
  for (int c = 0; c < n_chains; ++c) {
    const int n = 1 + random.index(7);
    add_part(true, n);
    const double k = kStep * std::pow(10.0, random.uniform(1, 3.5));
    for (int i = 0; i < n; ++i) diagonal.push_back(k * random.uniform(0.5, 2)), b.push_back(diagonal.back() * random.normal() * 0.05);
  }
  for (int c = 0; c < n_bodies; ++c) {
    add_part(false, 6);
    const double mass = std::pow(10.0, random.uniform(-0.5, 0.5) * o.mass_decades);
    for (int i = 0; i < 3; ++i) diagonal.push_back(mass / kStep), b.push_back(i == 2 ? kStep * mass * 9.81 : 0.0);
    for (int i = 0; i < 3; ++i) diagonal.push_back(mass / kStep * 0.4 * 0.0036), b.push_back(0);
  }
  raw.Q = Eigen::Map<VectorXd>(diagonal.data(), raw.n).asDiagonal();
  raw.b = Eigen::Map<VectorXd>(b.data(), raw.n);
  if (random.chance(0.5)) {  // coupled Q inside the groups
    for (const auto& part : parts) {
      const VectorXd d = raw.Q.diagonal().segment(part.first, part.n).cwiseSqrt();
      MatrixXd A = MatrixXd::Identity(part.n, part.n);
      for (int i = 0; i < part.n; ++i) {
        for (int j = 0; j < i; ++j) A(i, j) = 0.3 * random.normal();
      }
      raw.Q.block(part.first, part.first, part.n, part.n) = d.asDiagonal() * (A * A.transpose()) * d.asDiagonal();
    }
  }
  const int n_contacts = o.max_contacts > 0 ? random.index(o.max_contacts + 1) : 0;
  const bool planar = !o.cones || (o.planar && random.chance(0.25));
  const double deep = random.chance(0.3) ? o.deep : 0.0;
  // The barrier weight goes with the forces: σ/‖b‖∞ is a length.
  const double kappa = std::pow(10.0, random.uniform(1, 4)) / std::max(1.0, raw.b.lpNorm<Eigen::Infinity>());
  std::uint64_t id = 1;
  for (int c = 0; c < n_contacts; ++c) {
    auto& rows = planar ? raw.lines : raw.cones;
    if (!rows.empty() && random.chance(o.duplicate)) {
      auto copy = rows[static_cast<std::size_t>(random.index(static_cast<int>(rows.size())))];
      copy.id = id++;
      rows.push_back(copy);
      continue;
    }
    const auto& body = parts[static_cast<std::size_t>(n_chains + random.index(n_bodies))];
    const int other = random.index(static_cast<int>(parts.size()) + 1);  // the last: the world
    const Vector3d r = 0.06 * unit(random), p = body.centre + r;
    Matrix3d R;
    const bool world = other >= static_cast<int>(parts.size());
    R.col(0) = random.chance(world ? 0.95 : 0.2) ? Vector3d(0, 0, -1) : Vector3d(r.normalized());  // the world is mostly a floor
    R.col(1) = R.col(0).unitOrthogonal();
    R.col(2) = R.col(0).cross(R.col(1));
    const double mu = random.chance(o.frictionless) ? 0.0 : random.uniform(0.05, 1.5);
    RawProblem::Row row;
    MatrixXd J(3, 0);
    const auto add_body = [&](const Part& part, double sign) {
      MatrixXd wide(3, J.cols() + part.n);
      MatrixXd Jp(3, part.n);
      if (part.chain) {
        const int moving = 1 + random.index(part.n);
        for (int i = 0; i < part.n; ++i) Jp.col(i) = i < moving ? Vector3d(unit(random).cross(0.1 * unit(random))) : Vector3d(0, 0, 0);
      } else {
        const Vector3d arm = p - part.centre;
        Jp.leftCols<3>().setIdentity();
        for (int i = 0; i < 3; ++i) {
          const Vector3d axis = Vector3d::Unit(i);
          Jp.col(3 + i) = axis.cross(arm);
        }
      }
      wide << J, sign * Jp;
      J = wide;
      for (int i = 0; i < part.n; ++i) row.variables.push_back(part.first + i);
    };
    add_body(body, -1);
    if (other < static_cast<int>(parts.size()) && parts[static_cast<std::size_t>(other)].first != body.first) {
      add_body(parts[static_cast<std::size_t>(other)], 1);
    }
    MatrixXd G = R.transpose() * J;
    G.bottomRows<2>() *= mu;
    double gap = random.uniform(0, 0.03);
    if (random.chance(0.4)) gap = random.uniform(-2e-4, 2e-3);
    if (random.chance(0.05)) gap = 0;
    if (random.chance(deep)) gap = -random.uniform(0, 0.2);
    row.id = id++;
    if (planar) {  // w₀ ≥ |w₁| as two half-lines
      row.sigma = kStep / kappa;
      for (const double side : {1.0, -1.0}) {
        row.G = G.row(0) + side * G.row(1);
        row.g = VectorXd::Constant(1, gap);
        raw.lines.push_back(row);
        row.id = id++;
      }
    } else {
      row.sigma = 2 * kStep / kappa;
      row.G = G;
      row.g = Vector3d(gap, 0, 0);
      raw.cones.push_back(row);
    }
  }
  for (const auto& part : parts) {
    if (!part.chain || random.chance(0.3)) continue;
    for (int i = 0; i < part.n; ++i) {
      const double sigma = kStep / kappa * (random.chance(0.3) ? 0.05 : 1.0);
      const double low = random.chance(0.05) ? -random.uniform(0, 0.05) : random.uniform(0, 1);
      raw.bounds.push_back({id++, part.first + i, 1, low, sigma});
      raw.bounds.push_back({id++, part.first + i, -1, std::max(random.uniform(0, 1), 1e-3 - low), sigma});
    }
  }
  if (o.saturating > 0) {
    Random other(seed, 78);  // the rest of the problem stays what it is without
    for (const auto& part : parts) {
      for (int i = part.first; part.chain && i < part.first + part.n; ++i) {
        if (other.chance(o.saturating)) saturate(raw, i, other.chance(0.5) ? 1 : -1, std::exp(other.uniform(-8, -1)), id++);
      }
    }
  }
  return raw;
}

}  // namespace stiction::cone::test
