#include "stiction/execution/touch/feeler.hpp"

#include <algorithm>
#include <cmath>

#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/series_columns.hpp"

namespace stiction::execution {

using Eigen::VectorXd;

namespace {

VectorXd calc_joint_noise(const ControlScenario& arm) {
  if (arm.observer.joint_noise.size() > 0) return arm.observer.joint_noise;
  return VectorXd::Constant(arm.model->n_a(), arm.observer.noise);
}

/// Names of the links that one of the joints moves, for SensorOptions.
std::vector<std::string> find_moved(const world::Model& model, const std::vector<int>& joints) {
  std::vector<std::string> out;
  for (const world::Body& body : model.bodies()) {
    if (body.kind != world::BodyKind::Robot) continue;
    if (std::ranges::any_of(joints, [&](int j) { return moves_body(model, j, body); })) out.push_back(body.name);
  }
  return out;
}

sensing::SensorOptions make_sensor_options(const ControlScenario& arm, const std::vector<int>& joints) {
  sensing::SensorOptions out = arm.estimator.sensor;
  if (joints.empty()) return out;
  out.links = find_moved(*arm.model, joints);
  if (out.links.empty()) core::throw_invalid("joints", "joints that move no link", "joints of a robot");
  return out;
}

}  // namespace

Feeler::Feeler(const ControlScenario& arm, std::vector<int> joints, const sensing::JointFriction* friction)
    : arm_(arm),
      joints_(std::move(joints)),
      sensor_(sensing::Sensor::make(arm.model, make_sensor_options(arm, joints_))),
      work_(sensor_),
      memory_(std::exp(-arm.period / arm.observer.time_constant)) {
  if (joints_.empty()) joints_ = sensing::joints_but(arm.model->n_a(), {});
  const double whiter = (1 + memory_) / (1 - memory_);
  noise_ = (whiter * select(calc_joint_noise(arm)).array().square()).matrix().asDiagonal();
  if (arm.observer.drift.size() > 0) drift_ = select(arm.observer.drift);
  if (friction) allow_for(*friction);
  sign_ = VectorXd::Zero(noise_.rows());
  listen();
}

/// Adds errors of the friction model. Dry friction disturbs the torques of joints that stick. Torques that the friction fit left beside noise drift with the
/// motion, within about a second.
void Feeler::allow_for(const sensing::JointFriction& friction) {
  constexpr double kWander = 1;  // [s]
  friction_ = select(friction.coulomb.cwiseAbs());
  stiction_speed_ = friction.stiction_speed;
  const VectorXd beside = (friction.left.array().square() - calc_joint_noise(arm_).array().square()).max(0.0);
  if (drift_.size() == 0) drift_ = VectorXd::Zero(noise_.rows());
  drift_ = (drift_.array().square() + select(beside).array() / kWander).sqrt();
}

VectorXd Feeler::select(const VectorXd& of_all) const {
  VectorXd out(static_cast<Eigen::Index>(joints_.size()));
  for (std::size_t i = 0; i < joints_.size(); ++i) out[static_cast<Eigen::Index>(i)] = of_all[joints_[i]];
  return out;
}

void Feeler::listen() {
  onset_.reset();
  last_.resize(0);
  settle();
}

void Feeler::start() {
  if (rows_ == 0) core::throw_invalid("rest", "no row", "at least one row while nothing touches");
  onset_.emplace(sum_ / rows_, sensing::OnsetOptions{
                                   .noise = noise_.diagonal().asDiagonal(), .drift = drift_, .friction = friction_, .rest_rows = rows_});
  settle();
}

void Feeler::watch_friction(const VectorXd& q) {
  if (friction_.size() == 0) return;
  const VectorXd v = last_q_.size() == 0 ? VectorXd::Zero(q.size()) : VectorXd((q - last_q_) / arm_.period);
  sign_ = (select(v) / stiction_speed_).array().tanh();
  last_q_ = q;
}

bool Feeler::update(const VectorXd& external, const VectorXd& q) {
  watch_friction(q);
  const VectorXd now = select(external);
  if (last_.size() == 0) {
    last_ = now;
    return false;
  }
  row_ = (now - memory_ * last_) / (1 - memory_);
  last_ = now;
  sum_ += row_;
  ++rows_;
  return onset_ && onset_->update(row_, arm_.period, sign_);
}

double Feeler::age() const { return touches() ? onset_->rows() * arm_.period : 0; }

void Feeler::settle() {
  sum_.setZero(static_cast<Eigen::Index>(joints_.size()));
  rows_ = 0;
}

const sensing::SenseResult& Feeler::identify(const VectorXd& q) {
  if (!touches() || rows_ == 0) core::throw_invalid("touch", "nothing", "a touch, and a row since settle()");
  sensing::SenseOptions& options = options_ = arm_.estimator.sense;
  options.threshold.reset(), options.max_descents.reset();
  options.posterior = true;
  const int n = arm_.model->n_a();
  const Eigen::MatrixXd noise = onset_->noise() + noise_ / rows_;
  tau_.setZero(n);
  options.torques.unmeasured = sensing::joints_but(n, joints_);
  options.torques.covariance.setIdentity(n, n);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    tau_[joints_[i]] = sum_[k] / rows_ - onset_->rest()[k];
    for (std::size_t j = 0; j < joints_.size(); ++j)
      options.torques.covariance(joints_[i], joints_[j]) = noise(k, static_cast<Eigen::Index>(j));
  }
  q_full_ = arm_.model->neutral();
  q_full_.tail(q.size()) = q;
  sensing::sense(*sensor_, {q_full_, tau_}, options, work_, sensed_);
  return sensed_;
}

double Feeler::calc_force(int body, const Eigen::Vector3d& p_L, const Eigen::Vector3d& f_L) const {
  const VectorXd one = select(sensing::calc_contact_torque(*arm_.model, q_full_, body, p_L, f_L)), tau = select(tau_);
  const VectorXd weights = select(options_.torques.covariance.diagonal()).cwiseInverse();
  const double size = one.dot(weights.cwiseProduct(one));
  return size > 0 ? one.dot(weights.cwiseProduct(tau)) / size : 0;
}

double Feeler::calc_force(const VectorXd& torque) const {
  if (!touches() || rows_ == 0) return 0;
  const VectorXd one = select(torque), weights = (onset_->noise() + noise_ / rows_).diagonal().cwiseInverse();
  const double size = one.dot(weights.cwiseProduct(one));
  return size > 0 ? one.dot(weights.cwiseProduct(sum_ / rows_ - onset_->rest())) / size : 0;
}

}  // namespace stiction::execution
