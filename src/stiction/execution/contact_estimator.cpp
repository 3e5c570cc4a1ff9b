#include "stiction/execution/contact_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::execution {

using control::VectorRef;

namespace {
constexpr double kMost = 2;  ///< of b²: what the difference of two offsets has at most

std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

void ContactEstimatorOptions::validate() const {
  sensor.validate();
  sense.validate();
  core::require_positive("estimator.noise", noise);
  core::require_positive("estimator.lag", lag);
  core::require_positive("estimator.least_force", least_force);
  core::require_nonnegative("estimator.bias", bias);
  core::require_positive("estimator.plausible_force", plausible_force);
  core::require_nonnegative("estimator.score_margin", score_margin);
  if (max_candidates < 1) core::throw_invalid("estimator.max_candidates", std::to_string(max_candidates), "an integer ≥ 1");
  if (pool < max_candidates)
    core::throw_invalid("estimator.pool", std::to_string(pool), "at least max_candidates, " + std::to_string(max_candidates));
}

ContactEstimator::ContactEstimator(std::shared_ptr<const world::Model> model, const ContactEstimatorOptions& options)
    : sensor_(sensing::Sensor::make(model, options.sensor)),
      options_(options),
      sense_(options.sense),
      work_(sensor_),
      kinematics_work_(*model),
      q_full_(model->neutral()),
      tau_(Eigen::VectorXd::Zero(model->n_a())),
      external_(tau_) {
  options.validate();
  double spacing = 0;
  for (const sensing::SensedLink& link : sensor_->links()) spacing = std::max(spacing, link.spacing);
  constexpr double kDeviations = 3;  // within which candidates are told
  const double allowed = options.least_force * spacing / kDeviations;
  time_constant_ = options.lag * std::max(0.0, options.noise * options.noise / (allowed * allowed) - 1);  // (C.13)
  white_ = options.noise * std::sqrt(options.lag / (options.lag + time_constant_));
  reset();
}

void ContactEstimator::reset() {
  tau_.setZero();
  tare_ = {.offset = Eigen::VectorXd::Zero(tau_.size()), .q = tau_, .variance = kMost * options_.bias * options_.bias};
  last_.clear();
  tracked_.clear();
  contacts_.clear();
  next_id_ = 0;
}

/// The nearest contact of the last tick on the same link, within reach of merging; null: none.
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

/// Of the candidates the most likely, and those not much less likely, (C.12). Contacts do not jump: of these only what was told before, where any of it is
/// left, so that the set shrinks until all of it is refuted.
void ContactEstimator::rank_candidates() {
  const double sigma = sense_.noise, F = options_.plausible_force;
  scores_.clear();
  for (int i = 0; i < static_cast<int>(sensed_.candidates.size()); ++i) {
    const sensing::Candidate& c = sensed_.candidates[at(i)];
    scores_.emplace_back(c.best.residual / (sigma * sigma) + c.f_W.squaredNorm() / (F * F), i);
  }
  std::sort(scores_.begin(), scores_.end());
  last_.clear();
  for (std::size_t k = 0; k < std::min(scores_.size(), at(options_.pool)); ++k)
    last_.push_back(sensed_.candidates[at(scores_[k].second)].best);
  std::size_t kept = 0;
  while (kept < std::min(scores_.size(), at(options_.max_candidates)) && scores_[kept].first <= scores_[0].first + options_.score_margin)
    ++kept;
  scores_.resize(kept);
  const auto is_new = [&](const auto& score) { return find_tracked(sensed_.candidates[at(score.second)].best) == nullptr; };
  if (!std::all_of(scores_.begin(), scores_.end(), is_new)) std::erase_if(scores_, is_new);
}

/// A Kalman filter of each offset: a random walk over the way that the arm moves, measured where nothing touches it, by torques whose noise has a memory. At rest
/// it soon learns nothing, so that a force that holds on is not forgotten.                                                                    (C.13)
void ContactEstimator::learn_offset(VectorRef q, double dt) {
  Tare& t = tare_;
  const double b2 = options_.bias * options_.bias, memory = options_.lag + time_constant_;
  if (t.time > 0) t.variance = std::min(kMost * b2, t.variance + b2 * (q - t.q).norm());
  t.q = q;
  t.time += dt;
  const bool free = !t.ready || (tau_ - t.offset).cwiseAbs().maxCoeff() < sense_.threshold.value_or(4 * sense_.noise);
  t.ready = t.ready || t.time >= 5 * memory;
  if (!free) return;
  const double gain = t.variance / (t.variance + white_ * white_ * (1 + 2 * memory / dt));
  t.offset += gain * (tau_ - t.offset);
  t.variance *= 1 - gain;
}

/// Candidates for the torques less their offsets, and the noise that is left.
void ContactEstimator::sense(VectorRef q, double dt) {
  external_ = tau_;
  sense_.noise = white_;
  if (options_.bias > 0) {
    sense_.noise = std::hypot(white_, std::sqrt(tare_.variance));
    learn_offset(q, dt);
    sense_.noise = std::hypot(white_, std::sqrt(tare_.variance));
    if (tare_.ready) {
      external_ -= tare_.offset;
    } else {
      external_.setZero();
    }
  }
  sensing::sense(*sensor_, {.q = q_full_, .tau = external_, .last = &last_}, sense_, work_, sensed_);
}

std::span<const control::ContactForce> ContactEstimator::update(VectorRef q, VectorRef tau, VectorRef q_now, double dt) {
  const world::Model& model = sensor_->model();
  const Eigen::Index n = model.n_a();
  core::require_size("q", q.size(), n);
  core::require_size("q_now", q_now.size(), n);
  core::require_size("tau", tau.size(), n);
  core::require_positive("dt", dt);
  tau_ += dt / (time_constant_ + dt) * (tau - tau_);
  q_full_.tail(n) = q;
  sense(q, dt);

  tracked_before_.swap(tracked_);
  rank_candidates();
  q_full_.tail(n) = q_now;
  world::calc_kinematics(model, q_full_, kinematics_work_, kinematics_);
  tracked_.clear(), contacts_.clear();
  for (const auto& [score, i] : scores_) {
    const sensing::Candidate& candidate = sensed_.candidates[at(i)];
    const int body = sensor_->links()[at(candidate.best.link)].surface.body;
    Tracked* before = find_tracked(candidate.best);
    const int id = before != nullptr ? before->id : next_id_++;
    if (before != nullptr) before->taken = true;
    tracked_.push_back({id, candidate.best});
    contacts_.push_back({.id = id,
                         .body = body,
                         .p_WC = kinematics_.X_WB[at(body)] * candidate.best.p_L,
                         .force_W = candidate.f_W,
                         .alternative = scores_.size() > 1});
  }
  return contacts_;
}

}  // namespace stiction::execution
