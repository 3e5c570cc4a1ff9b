#include "stiction/execution/contact_control/contact_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "stiction/core/invalid_input.hpp"

namespace stiction::execution {

using control::VectorRef;

namespace {
constexpr double kMost = 2;  ///< largest variance of an offset, in b²: that of the difference of two offsets

std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

void ContactEstimatorOptions::validate() const {
  sensor.validate();
  sense.validate();
  core::require_positive("estimator.noise", noise);
  core::require_positive("estimator.lag", lag);
  core::require_positive("estimator.least_force", least_force);
  core::require_nonnegative("estimator.bias", bias);
  for (const double f : friction) core::require_nonnegative("estimator.friction", f);
  core::require_positive("estimator.plausible_force", plausible_force);
  if (base) base->validate();
  core::require_nonnegative("estimator.score_margin", score_margin);
  if (max_candidates < 1) core::throw_invalid("estimator.max_candidates", std::to_string(max_candidates), "an integer ≥ 1");
  if (max_contacts < 1 || max_contacts > sensing::kMostContacts)
    core::throw_invalid("estimator.max_contacts", std::to_string(max_contacts),
                        "an integer from 1 to " + std::to_string(sensing::kMostContacts));
  if (pool < max_candidates)
    core::throw_invalid("estimator.pool", std::to_string(pool), "at least max_candidates, " + std::to_string(max_candidates));
}

namespace {

/// Validates the options before anything is made of them.
std::shared_ptr<const sensing::Sensor> make_sensor(const std::shared_ptr<const world::Model>& model,
                                                   const ContactEstimatorOptions& options) {
  options.validate();
  if (!model) core::throw_invalid("model", "nothing", "a model");
  options.sense.torques.validate(model->n_a());
  return sensing::Sensor::make(model, options.sensor);
}

}  // namespace

ContactEstimator::ContactEstimator(std::shared_ptr<const world::Model> model, const ContactEstimatorOptions& options)
    : sensor_(make_sensor(model, options)),
      options_(options),
      sense_(options.sense),
      work_(sensor_),
      kinematics_work_(*model),
      q_full_(model->neutral()),
      external_(Eigen::VectorXd::Zero(model->n_a())),
      measured_(Eigen::VectorXd::Zero(model->n_a() + (options.base ? 6 : 0))) {
  double spacing = 0;
  for (const sensing::SensedLink& link : sensor_->links()) spacing = std::max(spacing, link.spacing);
  constexpr double kDeviations = 3;  // noise moves a point by less than a spacing within this many deviations
  const double allowed = options.least_force * spacing / kDeviations;
  time_constant_ = options.lag * std::max(0.0, options.noise * options.noise / (allowed * allowed) - 1);  // (C.13)
  const double share = options.lag / (options.lag + time_constant_);
  white_noise_ = share * options.sense.torques.covariance;
  const int n = model->n_a();
  white_.setConstant(measured_.size(), share * options.noise * options.noise);
  if (white_noise_.size() > 0) white_.head(n) = white_noise_.diagonal();
  offset_variance_.setConstant(measured_.size(), options.bias * options.bias);
  hidden_.setZero(measured_.size());
  if (options.friction.size() > 0) {
    core::require_size("estimator.friction", options.friction.size(), n);
    hidden_.head(n) = options.friction.cwiseAbs2();
  }
  if (options.base) {
    const BaseSensorOptions& b = *options.base;
    white_.segment<3>(n).setConstant(share * b.force_noise * b.force_noise);
    white_.segment<3>(n + 3).setConstant(share * b.moment_noise * b.moment_noise);
    offset_variance_.segment<3>(n).setConstant(b.force_offset * b.force_offset);
    offset_variance_.segment<3>(n + 3).setConstant(b.moment_offset * b.moment_offset);
  }
  sense_.torques.rest.resize(0), sense_.torques.sign = 1;  // take_sample() already applies rest and sign
  for (const sensing::SensedLink& link : sensor_->links()) bodies_.push_back(link.surface.body);
  options_.tracker.cone = options.sense.cone;
  for (int count = 2; count <= options.max_contacts; ++count) trackers_.emplace_back(sensor_, count, options_.tracker);
  reset();
}

void ContactEstimator::reset() {
  measured_.setZero();
  tare_ = {.offset = measured_, .q = Eigen::VectorXd::Zero(external_.size()), .variance = kMost * offset_variance_};
  last_.clear();
  tracked_.clear();
  hypotheses_.clear();
  contacts_.clear();
  for (sensing::ContactTracker& tracker : trackers_) tracker.reset();
  next_id_ = 0;
  since_sample_ = 0, missed_ = 0;
}

/// Nearest contact of the last tick on the same link, within the merging distance, that no other contact continues; null: none.
ContactEstimator::Tracked* ContactEstimator::find_tracked(const sensing::ContactPoint& point) {
  const double reach = options_.sense.merge * sensor_->links()[at(point.link)].spacing;
  Tracked* nearest = nullptr;
  double least = reach * reach;
  for (Tracked& t : tracked_before_) {
    const double squared = (t.point.p_L - point.p_L).squaredNorm();
    if (t.point.link == point.link && !t.taken && squared < least) least = squared, nearest = &t;
  }
  return nearest;
}

/// ρ of (C.12).
double ContactEstimator::calc_rho() const { return std::pow(sensed_.noise / options_.plausible_force, 2); }

/// Makes sets of one contact from the candidates, sorted by (C.12).
void ContactEstimator::rank_singles() {
  const double rho = calc_rho();
  hypotheses_.clear(), last_.clear();
  for (const sensing::Candidate& c : sensed_.candidates) {
    sensing::ContactSet& one = hypotheses_.emplace_back();
    one.count = 1, one.contacts[0] = c.best, one.residual = c.best.residual;
    one.objective = c.best.residual + rho * c.f_W.squaredNorm();
  }
  std::sort(hypotheses_.begin(), hypotheses_.end(), sensing::is_better);
  for (std::size_t k = 0; k < std::min(hypotheses_.size(), at(options_.pool)); ++k) last_.push_back(hypotheses_[k].contacts[0]);
}

/// True if no hypothesis so far explains the torques to within noise and tolerance.
bool ContactEstimator::needs_more() const {
  return std::none_of(hypotheses_.begin(), hypotheses_.end(), [&](const auto& set) { return set.residual <= sensed_.explained; });
}

/// Sets to which a further contact is added. The contacts reported a tick ago come first: of two contacts, the older one is better known.
std::span<const sensing::ContactSet> ContactEstimator::make_parents(std::size_t tracker) {
  if (tracker > 0) return trackers_[tracker - 1].sets();
  parents_.clear();
  const auto add = [&](const sensing::ContactPoint& point) {
    sensing::ContactSet& one = parents_.emplace_back();
    one.count = 1, one.contacts[0] = point;
  };
  for (const Tracked& t : tracked_before_) add(t.point);
  for (const sensing::ContactPoint& point : last_) add(point);
  return parents_;
}

/// Replaces the hypotheses by sets of two contacts, then of three, if these explain the torques better.
void ContactEstimator::find_sets() {
  if (sensed_.verdict == sensing::Verdict::BelowThreshold)
    for (sensing::ContactTracker& tracker : trackers_) tracker.reset();
  if (trackers_.empty() || hypotheses_.empty() || !needs_more()) return;
  const double sigma = sensed_.noise, rho = calc_rho();
  const world::Model& model = sensor_->model();
  world::calc_kinematics(model, q_full_, kinematics_work_, kinematics_);
  whitened_.assign(sense_.torques, external_, sense_.noise, sense_.tolerance);
  sensing::calc_contact_rows(model, kinematics_, bodies_, whitened_.tau(), base(), sigma, rows_work_, rows_, &whitened_);
  for (std::size_t k = 0; k < trackers_.size() && needs_more(); ++k) {
    sensing::ContactTracker& tracker = trackers_[k];
    tracker.update({rows_, rho, sigma, sensed_.explained, make_parents(k)});
    const bool likelier =
        !tracker.sets().empty() && tracker.sets().front().objective + options_.score_margin * sigma * sigma < hypotheses_.front().objective;
    if (likelier) hypotheses_ = tracker.sets();
  }
}

/// Keeps the most likely hypothesis and those that are nearly as likely. Contacts do not jump, so only contacts that were reported before are kept, as long
/// as any is left: their number falls until the torques refute all of them.
void ContactEstimator::choose_reported() {
  std::size_t kept = 0;
  const double margin = options_.score_margin * sensed_.noise * sensed_.noise;
  while (kept < std::min(hypotheses_.size(), at(options_.max_candidates)) &&
         hypotheses_[kept].objective <= hypotheses_[0].objective + margin)
    ++kept;
  hypotheses_.resize(kept);
  const auto is_new = [&](const sensing::ContactSet& set) {
    return std::any_of(set.contacts.begin(), set.contacts.begin() + set.count, [&](const auto& p) { return find_tracked(p) == nullptr; });
  };
  if (!std::all_of(hypotheses_.begin(), hypotheses_.end(), is_new)) std::erase_if(hypotheses_, is_new);
}

/// Updates a Kalman filter (C.16) for each offset. The offset is a random walk over the way that the arm moves. It is measured while nothing touches the arm,
/// by torques whose noise is correlated in time. At rest the filter soon learns nothing more, so a lasting force does not become an offset.
void ContactEstimator::learn_offset(VectorRef q, double dt) {
  Tare& t = tare_;
  const double memory = options_.lag + time_constant_;
  if (t.time > 0) t.variance = (t.variance + (q - t.q).norm() * offset_variance_).cwiseMin(kMost * offset_variance_);
  t.q = q;
  t.time += dt;
  const auto most = [&](Eigen::Index j) {
    const double deviations = 4 * std::sqrt(white_[j] + t.variance[j] + hidden_[j]);
    return j < external_.size() ? sense_.threshold.value_or(deviations) : deviations;
  };
  bool free = true;
  for (Eigen::Index j = 0; j < measured_.size(); ++j) free = free && std::abs(measured_[j] - t.offset[j]) < most(j);
  const bool learns = free || !t.ready;
  t.ready = t.ready || t.time >= 5 * memory;
  if (!learns) return;
  for (Eigen::Index j = 0; j < measured_.size(); ++j) {
    const double gain = t.variance[j] / (t.variance[j] + white_[j] * (1 + 2 * memory / dt) + hidden_[j]);
    t.offset[j] += gain * (measured_[j] - t.offset[j]);
    t.variance[j] *= 1 - gain;
  }
}

/// Sets σ² or its matrix: white noise after the low-pass plus the uncertainty of the offsets.                                       (C.13)
void ContactEstimator::set_noise() {
  const Eigen::Index n = external_.size();
  const Eigen::VectorXd& P = tare_.variance;
  if (options_.base) {
    base_.force_noise = std::sqrt((white_ + P).segment<3>(n).maxCoeff());
    base_.moment_noise = std::sqrt((white_ + P).segment<3>(n + 3).maxCoeff());
  }
  if (white_noise_.size() == 0) {
    sense_.noise = std::sqrt(white_[0] + P[0] + hidden_.head(n).maxCoeff());
    return;
  }
  sense_.torques.covariance = white_noise_;
  sense_.torques.covariance.diagonal() += P.head(n) + hidden_.head(n);
}

/// Computes the candidates for the torques without their offsets, with the remaining noise.
void ContactEstimator::sense(VectorRef q, double dt) {
  const Eigen::Index n = external_.size();
  if (has_offsets()) learn_offset(q, dt);
  const double known = is_ready() ? 1 : 0;
  external_ = known * (measured_ - tare_.offset).head(n);
  if (options_.base) {
    base_.force_W = known * (measured_ - tare_.offset).segment<3>(n);
    base_.moment_W = known * (measured_ - tare_.offset).segment<3>(n + 3);
  }
  set_noise();
  sensing::sense(*sensor_, {.q = q_full_, .tau = external_, .last = &last_, .base = base()}, sense_, work_, sensed_);
}

std::span<const control::ContactForce> ContactEstimator::update(VectorRef q, VectorRef tau, VectorRef q_now, double dt,
                                                                const sensing::BaseWrench* base) {
  const world::Model& model = sensor_->model();
  const Eigen::Index n = model.n_a();
  core::require_size("q", q.size(), n);
  core::require_size("q_now", q_now.size(), n);
  core::require_size("tau", tau.size(), n);
  core::require_finite("q_now", std::span(q_now.data(), at(static_cast<int>(n))));
  core::require_positive("dt", dt);
  if ((base != nullptr) != options_.base.has_value())
    core::throw_invalid("base", base != nullptr ? "a wrench" : "none",
                        options_.base ? "that of the sensor of the options" : "none: the options have no sensor");
  since_sample_ += dt;
  if (!q.allFinite() || !tau.allFinite() || (base != nullptr && !(base->force_W.allFinite() && base->moment_W.allFinite()))) {
    ++missed_;
    place(q_now);
    return contacts_;
  }
  missed_ = 0;
  take_sample(q, tau, base, std::exchange(since_sample_, 0));
  report();
  place(q_now);
  return contacts_;
}

/// Updates the hypotheses with a sample. @param dt  time since the sample before [s]
void ContactEstimator::take_sample(VectorRef q, VectorRef tau, const sensing::BaseWrench* base, double dt) {
  const sensing::TorqueModel& given = options_.sense.torques;
  external_ = tau;
  if (given.rest.size() > 0) external_ -= given.rest;
  const Eigen::Index n = external_.size();
  const double gain = dt / (time_constant_ + dt);
  measured_.head(n) += gain * (given.sign * external_ - measured_.head(n));
  if (base != nullptr) {
    measured_.segment<3>(n) += gain * (base->force_W - measured_.segment<3>(n));
    measured_.segment<3>(n + 3) += gain * (base->moment_W - measured_.segment<3>(n + 3));
  }
  q_full_.tail(q.size()) = q;
  sense(q, dt);

  tracked_before_.swap(tracked_);
  rank_singles();
  find_sets();
  choose_reported();
}

/// Makes the reported contacts of all hypotheses; contacts of the last tick keep their numbers.
void ContactEstimator::report() {
  tracked_.clear(), contacts_.clear();
  for (int s = 0; s < static_cast<int>(hypotheses_.size()); ++s)
    for (int i = 0; i < hypotheses_[at(s)].count; ++i) {
      const sensing::ContactPoint& point = hypotheses_[at(s)].contacts[at(i)];
      Tracked* before = find_tracked(point);
      const int id = before != nullptr ? before->id : next_id_++;
      if (before != nullptr) before->taken = true;
      tracked_.push_back({id, point});
      contacts_.push_back({.id = id, .body = bodies_[at(point.link)], .alternative = hypotheses_.size() > 1, .set = s});
    }
}

/// Moves the contacts along with their links.
void ContactEstimator::place(VectorRef q_now) {
  const world::Model& model = sensor_->model();
  q_full_.tail(model.n_a()) = q_now;
  world::calc_kinematics(model, q_full_, kinematics_work_, kinematics_);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const world::Pose& X_WB = kinematics_.X_WB[at(contacts_[i].body)];
    contacts_[i].p_WC = X_WB * tracked_[i].point.p_L;
    contacts_[i].force_W = X_WB.R * tracked_[i].point.f_L;
  }
}

}  // namespace stiction::execution
