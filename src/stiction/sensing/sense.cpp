#include "stiction/sensing/sense.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "stiction/core/overloaded.hpp"
#include "stiction/sensing/cluster.hpp"
#include "stiction/sensing/contact_rows.hpp"

namespace stiction::sensing {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

struct SenseWorkspace::Impl {
  struct Start {
    double residual;
    int link, sample;
  };
  std::shared_ptr<const Sensor> sensor;
  world::KinematicsWorkspace kinematics_work;
  world::Kinematics kinematics;
  Matrix3Xd J_w, J_v;
  Eigen::MatrixXd scratch;
  std::vector<LinkTorque> torques;  ///< per sensed link
  Eigen::VectorXd residuals;
  std::vector<Start> starts, nearest;
  std::vector<ContactPoint> tried;  ///< starts of the descents so far
  std::vector<int> ends;
  ClusterWorkspace clusters;
  std::optional<FrictionCone> opened;  ///< the cone with the largest possible friction
  WhitenedTorques whitened;
  std::vector<int> bodies;         ///< of the links
  ContactRowsWorkspace rows_work;  ///< for torques and a base wrench
  ContactRows rows;
  std::optional<ConeEvidence> evidence;
  std::vector<TouchedPlace> places;
  std::vector<double> forces;
  PosteriorWorkspace posterior;

  explicit Impl(std::shared_ptr<const Sensor> s) : sensor(std::move(s)), kinematics_work(sensor->model()) {
    torques.resize(sensor->links().size());
    Eigen::Index most = 0, all = 0;
    for (const auto& link : sensor->links()) {
      most = std::max(most, link.batch.rows.cols());
      all += link.batch.size;
      bodies.push_back(link.surface.body);
    }
    residuals.resize(most);
    starts.reserve(static_cast<std::size_t>(all));
    nearest.reserve(sensor->links().size());
  }
};

SenseWorkspace::SenseWorkspace(std::shared_ptr<const Sensor> sensor) : impl_(std::make_unique<Impl>(std::move(sensor))) {}
SenseWorkspace::~SenseWorkspace() = default;
SenseWorkspace::SenseWorkspace(SenseWorkspace&&) noexcept = default;

void SenseOptions::validate() const {
  core::require_positive("noise", noise);
  if (threshold) core::require_positive("threshold", *threshold);
  if (accept) core::require_positive("accept", *accept);
  core::require_positive("accept_share", accept_share);
  core::require_positive("tolerance", tolerance);
  core::require_positive("merge", merge);
  core::require_nonnegative("thin", thin);
  if (plausible_force) core::require_positive("plausible_force", *plausible_force);
  if (!(friction_error >= 0 && friction_error < 1))
    core::throw_invalid("friction_error", fmt::format("{}", friction_error), "a number in [0, 1)");
  if (!(touch_prior > 0 && touch_prior < 1)) core::throw_invalid("touch_prior", fmt::format("{}", touch_prior), "a number in (0, 1)");
  if (max_descents && *max_descents < 1) core::throw_invalid("max_descents", fmt::format("{}", *max_descents), "an integer ≥ 1");
}

std::string_view to_string(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::BelowThreshold:
      return "BelowThreshold";
    case Verdict::Explained:
      return "Explained";
    case Verdict::Unexplained:
      return "Unexplained";
  }
  return "";
}

double calc_noise_bound(double noise, Eigen::Index n) {
  const auto count = static_cast<double>(n);
  return noise * noise * (count + 3 * std::sqrt(2 * count));
}

std::optional<double> calc_plausible_force(const world::Model& model) {
  const double force = (model.effort().array() / model.reach().array()).minCoeff();
  return std::isfinite(force) && force > 0 ? std::optional(force) : std::nullopt;
}

double calc_prior(const Sensor& sensor, double noise, double tau, std::optional<double> force) {
  double size = std::numeric_limits<double>::infinity();
  for (const SensedLink& link : sensor.links()) size = std::min(size, link.surface.size);
  constexpr double kShare = 0.01;
  if (!force) force = calc_plausible_force(sensor.model()).value_or(tau / (kShare * size));
  return noise * noise / (*force * *force);
}

std::vector<ContactPoint> SenseResult::best_points() const {
  std::vector<ContactPoint> out;
  for (const Candidate& candidate : candidates) out.push_back(candidate.best);
  return out;
}

namespace {

/// Accepts samples by their residual, and finds the best sample of each link.
void accept_samples(const Sensor& sensor, const FrictionCone& cone, double accept, SenseWorkspace::Impl& work) {
  work.starts.clear();
  work.nearest.clear();
  for (int i = 0; i < static_cast<int>(sensor.links().size()); ++i) {
    const SensedLink& link = sensor.links()[static_cast<std::size_t>(i)];
    calc_residuals(work.torques[static_cast<std::size_t>(i)], link.batch, cone, work.residuals);
    int best = 0;
    for (int s = 0; s < link.batch.size; ++s) {
      if (work.residuals[s] <= accept) work.starts.push_back({work.residuals[s], i, s});
      if (work.residuals[s] < work.residuals[best]) best = s;
    }
    if (link.batch.size > 0) work.nearest.push_back({work.residuals[best], i, best});
  }
  const auto by_residual = [](const auto& a, const auto& b) {
    return std::tuple(a.residual, a.link, a.sample) < std::tuple(b.residual, b.link, b.sample);
  };
  std::ranges::sort(work.starts, by_residual);
  std::ranges::sort(work.nearest, by_residual);
}

/// Fills the LinkTorque of each link at q from the whitened torques, and from the base wrench if there is one.
void assign_torques(const Sensor& sensor, VectorRef q, const BaseWrench* base, SenseWorkspace::Impl& work) {
  world::calc_kinematics(sensor.model(), q, work.kinematics_work, work.kinematics);
  if (base != nullptr) {
    calc_contact_rows(sensor.model(), work.kinematics, work.bodies, work.whitened.tau(), base, work.whitened.noise(), work.rows_work,
                      work.rows, &work.whitened);
    for (std::size_t i = 0; i < work.torques.size(); ++i)
      work.torques[i].assign(work.rows.J_w[i], work.rows.J_v[i], work.rows.tau, work.scratch);
    return;
  }
  for (std::size_t i = 0; i < sensor.links().size(); ++i) {
    calc_link_jacobian(sensor.model(), work.kinematics, sensor.links()[i].surface.body, work.J_w, work.J_v);
    work.whitened.apply(work.J_w);
    work.whitened.apply(work.J_v);
    work.torques[i].assign(work.J_w, work.J_v, work.whitened.tau(), work.scratch);
  }
}

constexpr double kSettle = 1e-3;  // share of the explained bound; a smaller decrease of l is no progress
constexpr double kNear = 1;       // a descent within this many sample spacings of an earlier end will end there as well

class Search {
 public:
  Search(const Sensor& sensor, const SenseOptions& options, const FrictionCone& cone, SenseWorkspace::Impl& work, SenseResult& out)
      : sensor_(sensor), options_(options), cone_(cone), work_(work), out_(out) {}

  DescentProblem problem(int link) const {
    return {sensor_.links()[static_cast<std::size_t>(link)],
            link,
            work_.torques[static_cast<std::size_t>(link)],
            cone_,
            sensor_.options().normals,
            options_.tolerance,
            kSettle * out_.explained,
            out_.points,
            kNear * sensor_.links()[static_cast<std::size_t>(link)].spacing};
  }

  const SurfacePoint& sample_of(const SenseWorkspace::Impl::Start& start) const {
    return sensor_.links()[static_cast<std::size_t>(start.link)].samples[static_cast<std::size_t>(start.sample)];
  }

  ContactPoint at(const SenseWorkspace::Impl::Start& start) const {
    return evaluate(problem(start.link), sample_of(start).triangle, sample_of(start).p_L);
  }

  void keep(const RejectionSampling&, const ContactPoint& start) { add(start); }

  void keep(const SteepestDescent& descent, ContactPoint point) {
    ++out_.descents;
    if (descend(problem(point.link), descent, point)) add(point);
  }

  void keep(const GaussNewton& descent, ContactPoint point) {
    work_.tried.push_back(point);
    ++out_.descents;
    // With noise, a descent may get stuck at a crease of the surface. Its end is still an answer if it explains the torques.
    if (descend(problem(point.link), descent, point) || point.residual <= out_.explained) add(point);
  }

  /// Whether a sample need not start a descent, because an earlier one started or ended nearby.
  bool is_thinned(const GaussNewton&, const SenseWorkspace::Impl::Start& start) const {
    const double radius = options_.thin * sensor_.links()[static_cast<std::size_t>(start.link)].spacing;
    const Eigen::Vector3d& p_L = sample_of(start).p_L;
    const auto is_near = [&](const ContactPoint& other) {
      return other.link == start.link && (other.p_L - p_L).squaredNorm() < radius * radius;
    };
    return std::any_of(out_.points.begin(), out_.points.end(), is_near) || std::any_of(work_.tried.begin(), work_.tried.end(), is_near);
  }
  bool is_thinned(const auto&, const SenseWorkspace::Impl::Start&) const { return false; }

 private:
  void add(const ContactPoint& point) {
    ++out_.converged;
    out_.points.push_back(point);
  }

  const Sensor& sensor_;
  const SenseOptions& options_;
  const FrictionCone& cone_;
  SenseWorkspace::Impl& work_;
  SenseResult& out_;
};

/// Accepts samples and descends from them: fills out.points.
void find_points(const Sensor& sensor, const SenseInput& input, const SenseOptions& options, const FrictionCone& cone, double accept,
                 SenseWorkspace::Impl& work, SenseResult& out) {
  work.tried.clear();
  out.points.clear();
  out.descents = out.converged = 0;
  out.friction = cone.friction();
  accept_samples(sensor, cone, accept, work);
  out.accepted = static_cast<int>(work.starts.size());
  Search search(sensor, options, cone, work, out);
  std::visit(
      [&](const auto& method) {
        if (input.last != nullptr)
          for (const ContactPoint& point : *input.last)
            search.keep(method, evaluate(search.problem(point.link), point.triangle, point.p_L));
        const int given = out.descents;
        for (const auto& start : work.starts) {
          if (options.max_descents && out.descents - given >= *options.max_descents) break;
          if (!search.is_thinned(method, start)) search.keep(method, search.at(start));
        }
      },
      options.method);
}

/// The cone with the largest possible friction, stored because making it uses the heap.
const FrictionCone& open_cone(const SenseOptions& options, SenseWorkspace::Impl& work) {
  const double friction = options.cone.friction() / (1 - options.friction_error);
  const int rays = options.cone.is_lorentz() ? 0 : std::max(3, options.cone.rays());
  if (!work.opened || work.opened->friction() != friction || work.opened->is_lorentz() != options.cone.is_lorentz() ||
      work.opened->rays() != options.cone.rays())
    work.opened.emplace(friction, rays);
  return *work.opened;
}

Candidate make_candidate(LinkTorque torque, const FrictionCone& cone, double prior, const world::Pose& X_WL,
                         const std::vector<ContactPoint>& points, int first, int end, double explained) {
  Candidate out;
  out.best = points[static_cast<std::size_t>(first)];
  out.p_W = X_WL * out.best.p_L;
  out.n_W = X_WL.R * out.best.n_L;
  out.f_W = X_WL.R * out.best.f_L;
  out.explains = out.best.residual <= explained;
  torque.prior = prior;
  out.objective = calc_residual(torque, out.best.p_L, make_contact_frame(out.best.n_L), cone).value;
  const Eigen::ColPivHouseholderQR<Eigen::Matrix<double, LinkTorque::kSize, 3>> qr(torque.torque_map(out.best.p_L));
  out.rank = static_cast<int>(qr.rank());
  out.first = first;
  out.count = end - first;
  for (int i = first; i < end; ++i) {
    const ContactPoint& p = points[static_cast<std::size_t>(i)];
    if (p.residual > std::max(explained, out.best.residual + explained)) continue;
    out.extent = std::max(out.extent, (p.p_L - out.best.p_L).norm());
    out.force_spread = std::max(out.force_spread, (p.f_L - out.best.f_L).norm());
  }
  return out;
}

/// Adds the probability of each place to the candidate on its link with the nearest point.
void share_posterior(SenseResult& out, const Sensor& sensor) {
  for (const TouchedPlace& place : out.posterior.places) {
    const Vector3d p_L = sensor.links()[static_cast<std::size_t>(place.link)].batch.p_L(place.sample);
    Candidate* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (Candidate& candidate : out.candidates) {
      if (candidate.best.link != place.link) continue;
      for (int i = candidate.first; i < candidate.first + candidate.count; ++i) {
        const double distance = (out.points[static_cast<std::size_t>(i)].p_L - p_L).squaredNorm();
        if (distance >= least) continue;
        least = distance;
        nearest = &candidate;
      }
    }
    if (nearest != nullptr) nearest->probability += place.probability;
  }
}

/// Order of candidates: first those that explain the torques, by the probability of their link and their own, or by (Y.14).
void rank_candidates(const Sensor& sensor, const SenseOptions& options, SenseResult& out) {
  for (Candidate& candidate : out.candidates) candidate.probability = 0;
  if (options.posterior) share_posterior(out, sensor);
  const auto rank_of = [&](const Candidate& c) {
    const double link = options.posterior && c.explains ? out.posterior.links[static_cast<std::size_t>(c.best.link)] : 0;
    return std::tuple(!c.explains, -link, -(c.explains ? c.probability : 0), c.explains ? c.objective : c.best.residual, c.first);
  };
  std::sort(out.candidates.begin(), out.candidates.end(), [&](const Candidate& a, const Candidate& b) { return rank_of(a) < rank_of(b); });
}

/// Clusters the points and orders the clusters: first those that explain the torques, by probability or by (Y.14).
void make_candidates(const Sensor& sensor, const SenseOptions& options, const FrictionCone& cone, double prior, SenseWorkspace::Impl& work,
                     SenseResult& out) {
  cluster_points(sensor, options.merge, out.points, work.clusters, work.ends);
  int first = 0;
  for (const int end : work.ends) {
    const auto link = static_cast<std::size_t>(out.points[static_cast<std::size_t>(first)].link);
    const auto body = static_cast<std::size_t>(sensor.links()[link].surface.body);
    out.candidates.push_back(
        make_candidate(work.torques[link], cone, prior, work.kinematics.X_WB[body], out.points, first, end, out.explained));
    first = end;
  }
  rank_candidates(sensor, options, out);
}

/// Prior standard deviations of forces: the given one, or three values from the touch of a finger to the force that the weakest joint
/// holds.
void choose_forces(const world::Model& model, const std::optional<double>& given, std::vector<double>& out) {
  constexpr double kSmall = 4, kLarge = 30;  // [N]
  const double largest = std::max(kLarge, calc_plausible_force(model).value_or(kLarge));
  if (given)
    out = {*given};
  else
    out = {kSmall, std::sqrt(kSmall * largest), largest};
}

/// Noise of each torque plus the model error; a covariance already contains the model error.
double calc_evidence_noise(const SenseOptions& options, const SenseWorkspace::Impl& work) {
  const double model = work.whitened.is_identity() ? options.tolerance * work.whitened.tau().norm() : 0;
  return std::hypot(work.whitened.noise(), model / std::sqrt(static_cast<double>(work.whitened.tau().size())));
}

/// Squared norm of the rows of a base wrench, scaled as in calc_contact_rows().
double calc_base_size(const BaseWrench& base, double noise) {
  return std::pow(noise / base.force_noise, 2) * base.force_W.squaredNorm() +
         std::pow(noise / base.moment_noise, 2) * base.moment_W.squaredNorm();
}

/// Computes probabilities from the accepted samples: all other samples have so large residuals that they carry no weight. If no sample is accepted, the best one
/// of each link is used.
void find_posterior(const Sensor& sensor, const SenseOptions& options, const FrictionCone& cone, SenseWorkspace::Impl& work,
                    SenseResult& out) {
  const double noise = calc_evidence_noise(options, work);
  choose_forces(sensor.model(), options.plausible_force, work.forces);
  if (!work.evidence || work.evidence->forces() != work.forces || work.evidence->friction() != cone.friction() ||
      work.evidence->is_exact() != cone.is_lorentz() || (!cone.is_lorentz() && work.evidence->cone().rays() != cone.rays()))
    work.evidence.emplace(cone, work.forces);
  work.places.clear();
  for (const auto& start : work.starts.empty() ? work.nearest : work.starts) work.places.push_back({start.link, start.sample});
  calc_posterior(sensor, work.torques, work.places, *work.evidence, noise, options.touch_prior, work.posterior, out.posterior);
}

}  // namespace

void sense(const Sensor& sensor, const SenseInput& input, const SenseOptions& options, SenseWorkspace& workspace, SenseResult& out) {
  const world::Model& model = sensor.model();
  options.validate();
  world::require_configuration(model, "q", input.q);
  core::require_size("tau", input.tau.size(), model.n_a());
  core::require_finite("tau", {input.tau.data(), static_cast<std::size_t>(input.tau.size())});
  if (input.last != nullptr)
    for (const ContactPoint& point : *input.last) require_point(sensor, "last", point);
  if (!options.torques.is_plain()) options.torques.validate(model.n_a());
  if (input.base != nullptr) {
    input.base->validate();
    if (options.posterior)
      core::throw_invalid("posterior", "true with a wrench at the base", "one of them: probabilities are of torques alone");
  }
  SenseWorkspace::Impl& work = workspace.impl();

  out.candidates.clear();
  out.points.clear();
  out.samples = out.accepted = out.descents = out.converged = 0;
  out.friction = options.cone.friction();
  work.whitened.assign(options.torques, input.tau, options.noise, options.tolerance);
  const Eigen::VectorXd& tau = work.whitened.tau();
  out.noise = work.whitened.noise();
  const double tau_tau = tau.squaredNorm() + (input.base != nullptr ? calc_base_size(*input.base, out.noise) : 0);
  const double noise_bound = calc_noise_bound(out.noise, tau.size() + (input.base != nullptr ? 6 : 0));
  out.explained = std::max(options.tolerance * options.tolerance * tau_tau, noise_bound);
  out.verdict = Verdict::BelowThreshold;
  out.posterior.links.clear();
  out.posterior.credible.clear();
  out.posterior.places.clear();
  out.posterior.nothing = 1;
  out.largest = work.whitened.largest();
  out.threshold = options.threshold.value_or(out.largest.deviations * out.largest.noise);
  const bool is_below = out.largest.torque < out.threshold;
  if (is_below && !options.posterior) return;

  assign_torques(sensor, input.q, input.base, work);
  for (const SensedLink& link : sensor.links()) out.samples += static_cast<int>(link.batch.size);
  const double accept = options.accept.value_or(std::max(options.accept_share * tau_tau, noise_bound));
  const FrictionCone* cone = &options.cone;
  if (is_below) {
    accept_samples(sensor, *cone, accept, work);
    out.accepted = static_cast<int>(work.starts.size());
    find_posterior(sensor, options, *cone, work, out);
    return;
  }
  const auto explains = [&](const ContactPoint& point) { return point.residual <= out.explained; };
  find_points(sensor, input, options, *cone, accept, work, out);
  if (options.friction_error > 0 && std::none_of(out.points.begin(), out.points.end(), explains)) {
    cone = &open_cone(options, work);
    find_points(sensor, input, options, *cone, accept, work, out);
  }
  if (options.posterior) find_posterior(sensor, options, *cone, work, out);
  make_candidates(sensor, options, *cone, calc_prior(sensor, out.noise, std::sqrt(tau_tau), options.plausible_force), work, out);
  const bool explained = !out.candidates.empty() && out.candidates.front().explains;
  out.verdict = explained ? Verdict::Explained : Verdict::Unexplained;
}

namespace {

/// The moment whose torques are largest relative to their noise.
Eigen::Index find_strongest(const Eigen::MatrixXd& tau, const SenseOptions& options, SenseWorkspace::Impl& work) {
  Eigen::Index out = 0;
  double most = -1;
  for (Eigen::Index i = 0; i < tau.cols(); ++i) {
    work.whitened.assign(options.torques, tau.col(i), options.noise, options.tolerance);
    const double size = work.whitened.tau().norm() / work.whitened.noise();
    if (!(size > most)) continue;
    most = size;
    out = i;
  }
  return out;
}

/// Adds the evidence of a moment to that of the places of the last call of calc_posterior().
void add_moment(const Sensor& sensor, VectorRef q, VectorRef tau, const SenseOptions& options, SenseWorkspace::Impl& work) {
  world::require_configuration(sensor.model(), "q", q);
  work.whitened.assign(options.torques, tau, options.noise, options.tolerance);
  assign_torques(sensor, q, nullptr, work);
  const double noise = calc_evidence_noise(options, work);
  for (std::size_t i = 0; i < work.posterior.kept.size(); ++i) {
    const TouchedPlace& place = work.posterior.kept[i];
    const SensedLink& link = sensor.links()[static_cast<std::size_t>(place.link)];
    const PatchEvidence patch = calc_patch_evidence(work.torques[static_cast<std::size_t>(place.link)], link.batch.p_L(place.sample),
                                                    link.batch.R_LC(place.sample), *work.evidence, noise, link.spacing);
    work.posterior.evidence[i] += patch.constant + work.evidence->log_evidence(patch.precision, patch.b);
  }
}

}  // namespace

void sense_touch(const Sensor& sensor, const Eigen::MatrixXd& q, const Eigen::MatrixXd& tau, double correlation, const SenseOptions& given,
                 SenseWorkspace& workspace, SenseResult& out) {
  const auto m = static_cast<double>(tau.cols());
  if (tau.cols() < 1 || q.cols() != tau.cols())
    core::throw_invalid("tau", fmt::format("{} moments, and {} of q", tau.cols(), q.cols()), "as many as of q, at least one");
  if (!(correlation >= 0 && correlation <= 1)) core::throw_invalid("correlation", fmt::format("{}", correlation), "a number in [0, 1]");
  core::require_size("tau", tau.rows(), sensor.model().n_a());
  core::require_finite("tau", {tau.data(), static_cast<std::size_t>(tau.size())});
  SenseOptions options = given;
  options.posterior = true;
  options.validate();
  options.torques.validate(sensor.model().n_a());
  SenseWorkspace::Impl& work = workspace.impl();
  const Eigen::Index strongest = find_strongest(tau, options, work);
  sense(sensor, {q.col(strongest), tau.col(strongest)}, options, workspace, out);
  for (Eigen::Index i = 0; i < tau.cols(); ++i)
    if (i != strongest) add_moment(sensor, q.col(i), tau.col(i), options, work);
  for (double& evidence : work.posterior.evidence) evidence /= 1 + (m - 1) * correlation;
  normalize(sensor, work.posterior.kept, work.posterior.shares, work.posterior.evidence, options.touch_prior, work.posterior,
            out.posterior);
  rank_candidates(sensor, options, out);
}

Eigen::VectorXd calc_contact_torque(const world::Model& model, VectorRef q, int body, const Vector3d& p_L, const Vector3d& f_L) {
  world::require_configuration(model, "q", q);
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, q, work, kinematics);
  Matrix3Xd J_w, J_v;
  calc_link_jacobian(model, kinematics, body, J_w, J_v);
  Eigen::VectorXd tau(model.n_a());
  calc_torque(J_w, J_v, p_L, f_L, tau);
  return tau;
}

}  // namespace stiction::sensing
