#include "stiction/sensing/known_contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "stiction/core/invalid_input.hpp"

namespace stiction::sensing {

Eigen::VectorXd place_robots(const world::Model& model, VectorRef joints) {
  Eigen::VectorXd q = model.neutral();
  q.tail(model.n_a()) = joints;
  return q;
}

void calc_known_rows(const Sensor& sensor, VectorRef q, std::span<const ContactPoint> contacts, Eigen::VectorXd& tau, BaseWrench& base) {
  const world::Model& model = sensor.model();
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  tau.setZero(model.n_a());
  base.force_W.setZero();
  base.moment_W.setZero();
  for (const ContactPoint& contact : contacts) {
    const int body = sensor.links()[static_cast<std::size_t>(contact.link)].surface.body;
    const auto& X_WL = kinematics.X_WB[static_cast<std::size_t>(body)];
    tau += calc_contact_torque(model, q, body, contact.p_L, contact.f_L);
    const BaseWrench one = calc_base_wrench(X_WL * contact.p_L, X_WL.R * contact.f_L);
    base.force_W += one.force_W;
    base.moment_W += one.moment_W;
  }
}

namespace {

Eigen::VectorXd make_random_posture(const world::Model& model, core::Random& random) {
  Eigen::VectorXd joints(model.n_a());
  for (Eigen::Index j = 0; j < model.n_a(); ++j) {
    const double lower = std::max(model.lower()[j], -std::numbers::pi), upper = std::min(model.upper()[j], std::numbers::pi);
    constexpr double kShare = 0.9;
    joints[j] = 0.5 * ((lower + upper) + kShare * (upper - lower) * random.uniform(-1, 1));
  }
  return place_robots(model, joints);
}

ContactPoint make_random_contact(const Sensor& sensor, int index, const FrictionCone& cone, double force, core::Random& random) {
  ContactPoint out;
  out.link = index;
  const SensedLink& link = sensor.links()[static_cast<std::size_t>(index)];
  const SurfacePoint point = sample_surface(link.surface, 1, Sampling::Uniform, random.bits())[0];
  Eigen::Vector3d f_C;
  do {
    f_C = Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
  } while (!cone.contains(f_C));
  out.p_L = point.p_L;
  out.f_L = force * (make_contact_frame(link.surface.normal(point.triangle, point.p_L, sensor.options().normals)) * f_C);
  return out;
}

}  // namespace

KnownCases make_random_cases(const Sensor& sensor, std::span<const int> links, const FrictionCone& cone, double force, int count,
                             core::Random& random) {
  if (static_cast<int>(links.size()) < count)
    core::throw_invalid("links", fmt::format("{}", links.size()), fmt::format("at least {}", count));
  KnownCases out;
  out.q = make_random_posture(sensor.model(), random);
  std::vector<int> left(links.begin(), links.end());
  for (int i = 0; i < count; ++i) {
    const int chosen = random.index(static_cast<int>(left.size()));
    out.contacts.push_back(make_random_contact(sensor, left[static_cast<std::size_t>(chosen)], cone, force, random));
    left.erase(left.begin() + chosen);
  }
  std::sort(out.contacts.begin(), out.contacts.end(), [](const ContactPoint& a, const ContactPoint& b) { return a.link < b.link; });
  calc_known_rows(sensor, out.q, out.contacts, out.tau, out.base);
  return out;
}

KnownCase make_random_case(const Sensor& sensor, std::span<const int> links, const FrictionCone& cone, double force, core::Random& random) {
  KnownCases one = make_random_cases(sensor, links, cone, force, 1, random);
  return {std::move(one.q), std::move(one.tau), one.contacts[0]};
}

ContactSet make_set(const Sensor& sensor, std::span<const ContactPoint> contacts) {
  ContactSet out;
  for (const ContactPoint& contact : contacts) {
    const Surface& surface = sensor.links()[static_cast<std::size_t>(contact.link)].surface;
    const int triangle = surface.tree.closest(contact.p_L).triangle;
    out.contacts[static_cast<std::size_t>(out.count++)] = {.link = contact.link,
                                                           .triangle = triangle,
                                                           .p_L = contact.p_L,
                                                           .n_L = surface.normal(triangle, contact.p_L, sensor.options().normals),
                                                           .f_L = contact.f_L};
  }
  return out;
}

int calc_freedom(const Sensor& sensor, const KnownCases& known, bool base, double noise) {
  const world::Model& model = sensor.model();
  world::KinematicsWorkspace kinematics_work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, known.q, kinematics_work, kinematics);
  std::vector<int> bodies;
  for (const SensedLink& link : sensor.links()) bodies.push_back(link.surface.body);
  ContactRowsWorkspace rows_work;
  ContactRows rows;
  calc_contact_rows(model, kinematics, bodies, known.tau, base ? &known.base : nullptr, noise, rows_work, rows);
  const FrictionCone cone;
  const JointProblem problem{sensor, rows, cone, calc_prior(sensor, noise, rows.tau.norm()), noise};
  JointWorkspace work;
  ContactSet set = make_set(sensor, known.contacts);
  calc_identifiability(problem, work, set);
  return set.freedom;
}

double calc_distance(const SenseResult& result, const Candidate& candidate, const ContactPoint& contact) {
  double squared = std::numeric_limits<double>::infinity();
  if (candidate.best.link != contact.link) return squared;
  for (int i = candidate.first; i < candidate.first + candidate.count; ++i) {
    const ContactPoint& point = result.points[static_cast<std::size_t>(i)];
    if (point.residual <= std::max(result.explained, candidate.best.residual))
      squared = std::min(squared, (point.p_L - contact.p_L).squaredNorm());
  }
  return std::sqrt(squared);
}

double calc_distance(const ContactSet& set, std::span<const ContactPoint> contacts) {
  double least = std::numeric_limits<double>::infinity();
  if (set.count != static_cast<int>(contacts.size())) return least;
  std::array<std::size_t, kMostContacts> order{};
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto end = order.begin() + set.count;
  do {
    double largest = 0;
    for (int i = 0; i < set.count; ++i) {
      const ContactPoint& point = set.contacts[static_cast<std::size_t>(i)];
      const ContactPoint& known = contacts[order[static_cast<std::size_t>(i)]];
      largest = std::max(largest, point.link == known.link ? (point.p_L - known.p_L).norm() : std::numeric_limits<double>::infinity());
    }
    least = std::min(least, largest);
  } while (std::next_permutation(order.begin(), end));
  return least;
}

}  // namespace stiction::sensing
