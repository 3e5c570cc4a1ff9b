#include "stiction/execution/closed_loop/simulated_plant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "stiction/core/invalid_input.hpp"
#include "stiction/execution/open_loop/speed_limits.hpp"

namespace stiction::execution {
void WorldOptions::validate(const world::Model& model) const {
  core::require_nonnegative("world.friction", friction);
  core::require_positive("world.mass", mass);
  core::require_nonnegative("world.pose_noise", pose_noise);
  core::require_nonnegative("world.angle_noise", angle_noise);
  core::require_nonnegative("world.pose_delay", pose_delay);
  for (const OutsidePush& push : pushes) {
    if (push.object < 0 || push.object >= static_cast<int>(model.objects().size()))
      core::throw_invalid("world.push.object", std::to_string(push.object), "the index of an object");
    core::require_nonnegative("world.push.begin", push.begin);
    core::require_positive("world.push.duration", push.duration);
    core::require_finite("world.push.force", std::span(push.force_W.data(), 3));
  }
}

std::shared_ptr<const simulation::Plant> make_world(const std::shared_ptr<const world::Model>& model, const WorldOptions& options) {
  if (!model) core::throw_invalid("model", "nothing", "a model");
  options.validate(*model);
  simulation::PlantOptions plant;
  plant.rest_time = kRestTime;
  plant.velocity_reference = true;
  plant.effort_limits = true;
  plant.contact.friction_scale = options.friction;
  plant.mass_scale = options.mass;
  return simulation::Plant::make(model, plant);
}

SimulatedPlant::SimulatedPlant(const std::shared_ptr<const world::Model>& model, VectorRef q, const WorldOptions& options)
    : model_(model), options_(options), plant_(make_world(model, options)), random_(options.seed, 0) {
  const Eigen::VectorXd u = q.tail(model->n_a()).cwiseMax(model->lower()).cwiseMin(model->upper());
  plant_.reset(q, u);
  past_.push_back({0, plant_.q()});
  weight_.setConstant(static_cast<Eigen::Index>(model->geometries().size()), std::numeric_limits<double>::infinity());
  for (Eigen::Index g = 0; g < weight_.size(); ++g) {
    const world::Body& body = model->bodies()[static_cast<std::size_t>(model->geometries()[static_cast<std::size_t>(g)].body)];
    if (body.kind != world::BodyKind::Object) continue;
    const auto object = static_cast<std::size_t>(body.owner);
    const double weight = options.mass * model->objects()[object].mass * model->scene().gravity.norm();
    if (model->scene().objects[object].joint == world::ObjectJoint::Free && weight > 0) weight_[g] = weight, press_ = 0;
  }
}

bool SimulatedPlant::read(Measurement& out) {
  out.time = plant_.time();
  out.u = plant_.u();
  out.q = past_.front().q;
  out.object_time = past_.front().time;
  out.q.tail(model_->n_a()) = plant_.q().tail(model_->n_a());
  if (options_.pose_noise > 0 || options_.angle_noise > 0) {
    Eigen::VectorXd noise = Eigen::VectorXd::Zero(model_->n_v());
    for (int i = 0; i < model_->n_vu(); ++i) {
      const bool turns = model_->dofs()[static_cast<std::size_t>(i)].kind == world::DofKind::Revolute;
      noise[i] = (turns ? options_.angle_noise : options_.pose_noise) * random_.normal();
    }
    const Eigen::VectorXd q = out.q;
    world::retract(*model_, q, noise, out.q);
  }
  return plant_.message().empty();
}

bool SimulatedPlant::command(VectorRef u, double period) {
  apply_pushes(period);
  if (plant_.advance(u, period) != core::Status::Solved) return false;
  raise_press();
  past_.push_back({plant_.time(), plant_.q()});
  while (past_.size() > 1 && past_[1].time <= plant_.time() - options_.pose_delay) past_.pop_front();
  return true;
}

void SimulatedPlant::raise_press() {
  if (!press_) return;
  for (const simulation::PairForce& force : plant_.forces()) {
    const world::Pair& pair = model_->pairs()[static_cast<std::size_t>(force.pair)];
    for (const int geometry : {pair.geometry_a, pair.geometry_b}) press_ = std::max(*press_, force.normal / weight_[geometry]);
  }
}

/// Scales each force by the share of the period in which its push lasts, so that its impulse is exact.
void SimulatedPlant::apply_pushes(double period) {
  acting_.clear();
  const double now = plant_.time();
  for (const OutsidePush& push : options_.pushes) {
    const double lasts = std::min(now + period, push.begin + push.duration) - std::max(now, push.begin);
    if (!(lasts > 0)) continue;
    const auto object = static_cast<std::size_t>(push.object);
    acting_.push_back({.body = model_->objects()[object].body,
                       .p_BP = model_->scene().objects[object].p_BCom,
                       .force_W = std::min(1.0, lasts / period) * push.force_W});
  }
  if (held_.body >= 0 && !held_.force_W.isZero()) acting_.push_back(held_);
  plant_.set_pushes(acting_);
}

void SimulatedPlant::hold_push(const simulation::Push& push) {
  plant_.set_pushes({&push, 1});  // throws if the push is invalid
  held_ = push;
}

}  // namespace stiction::execution
