#include "stiction/execution/contact_estimator.hpp"

#include <algorithm>
#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::execution {

using control::VectorRef;

namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

void ContactEstimatorOptions::validate() const {
  sensor.validate();
  sense.validate();
  core::require_nonnegative("estimator.filter", time_constant);
  core::require_positive("estimator.plausible_force", plausible_force);
  core::require_nonnegative("estimator.score_margin", score_margin);
  if (max_candidates < 1) core::throw_invalid("estimator.max_candidates", std::to_string(max_candidates), "an integer ≥ 1");
}

ContactEstimator::ContactEstimator(std::shared_ptr<const world::Model> model, const ContactEstimatorOptions& options)
    : sensor_(sensing::Sensor::make(model, options.sensor)),
      options_(options),
      work_(sensor_),
      kinematics_work_(*model),
      q_full_(model->neutral()),
      tau_(Eigen::VectorXd::Zero(model->n_a())) {
  options.validate();
}

void ContactEstimator::reset() {
  tau_.setZero();
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
  const double sigma = options_.sense.noise, F = options_.plausible_force;
  scores_.clear();
  for (int i = 0; i < static_cast<int>(sensed_.candidates.size()); ++i) {
    const sensing::Candidate& c = sensed_.candidates[at(i)];
    scores_.emplace_back(c.best.residual / (sigma * sigma) + c.f_W.squaredNorm() / (F * F), i);
  }
  std::sort(scores_.begin(), scores_.end());
  std::size_t kept = 0;
  while (kept < std::min(scores_.size(), at(options_.max_candidates)) && scores_[kept].first <= scores_[0].first + options_.score_margin)
    ++kept;
  scores_.resize(kept);
  const auto is_new = [&](const auto& score) { return find_tracked(sensed_.candidates[at(score.second)].best) == nullptr; };
  if (!std::all_of(scores_.begin(), scores_.end(), is_new)) std::erase_if(scores_, is_new);
}

std::span<const control::ContactForce> ContactEstimator::update(VectorRef q, VectorRef tau, VectorRef q_now, double dt) {
  const world::Model& model = sensor_->model();
  const Eigen::Index n = model.n_a();
  core::require_size("q", q.size(), n);
  core::require_size("q_now", q_now.size(), n);
  core::require_size("tau", tau.size(), n);
  core::require_positive("dt", dt);
  tau_ += dt / (options_.time_constant + dt) * (tau - tau_);
  q_full_.tail(n) = q;
  sensing::sense(*sensor_, {.q = q_full_, .tau = tau_, .last = &last_}, options_.sense, work_, sensed_);

  tracked_before_.swap(tracked_);
  rank_candidates();
  q_full_.tail(n) = q_now;
  world::calc_kinematics(model, q_full_, kinematics_work_, kinematics_);
  tracked_.clear(), last_.clear(), contacts_.clear();
  for (const auto& [score, i] : scores_) {
    const sensing::Candidate& candidate = sensed_.candidates[at(i)];
    const int body = sensor_->links()[at(candidate.best.link)].surface.body;
    Tracked* before = find_tracked(candidate.best);
    const int id = before != nullptr ? before->id : next_id_++;
    if (before != nullptr) before->taken = true;
    tracked_.push_back({id, candidate.best});
    last_.push_back(candidate.best);
    contacts_.push_back({.id = id,
                         .body = body,
                         .p_WC = kinematics_.X_WB[at(body)] * candidate.best.p_L,
                         .force_W = candidate.f_W,
                         .alternative = scores_.size() > 1});
  }
  return contacts_;
}

}  // namespace stiction::execution
