#include "stiction/world/mjcf_motors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/core/number.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

std::size_t slot(int i) { return static_cast<std::size_t>(i); }

/// Values outside of ±kLargestNumber mean that there is no limit.
ForceRange range_from(double one, double other) {
  const auto limit = [](double x) { return std::abs(x) > core::kLargestNumber ? std::copysign(kUnlimited, x) : x; };
  return {limit(std::min(one, other)), limit(std::max(one, other))};
}

}  // namespace

ForceRange ForceRange::scaled(double factor) const {
  if (factor == 0) return {};
  return {factor * (factor > 0 ? lower : upper), factor * (factor > 0 ? upper : lower)};
}

ForceRange ForceRange::clamped(const mjtNum* range) const {
  const auto [low, high] = range_from(range[0], range[1]);
  return {std::clamp(lower, low, high), std::clamp(upper, low, high)};
}

MjcfMotors::MjcfMotors(const MjcfView& view)
    : MjcfView(view), motors_(slot(m_->nv)), forces_(slot(m_->nv)), sums_(slot(m_->nv)), couplings_(view) {
  for (int i = 0; i < m_->nactuator; ++i) add_actuator(i);
  for (int t = 0; t < m_->ntendon; ++t) add_tendon(t);
  set_efforts();
  for (int j = 0; j < m_->njnt; ++j) add_spring(j);
}

/// Name of a coordinate: that of its joint, or of a hinge that stands for a ball joint.
std::string MjcfMotors::name_of(int dof) const {
  const int joint = m_->dof_jntid[dof];
  return is_ball(joint) ? fmt::format("{}_{}", joint_name(joint), "xyz"[dof - m_->jnt_dofadr[joint]]) : joint_name(joint);
}

/// Forces of an actuator at rest, before its gear. If neither gain nor bias depends on the position, the commands limit the force.
ForceRange MjcfMotors::range_of(int i) const {
  const mjtNum *gain = m_->actuator_gainprm + i * mjNGAIN, *bias = m_->actuator_biasprm + i * mjNBIAS;
  const int gain_type = m_->actuator_gaintype[i], bias_type = m_->actuator_biastype[i], command = m_->actuator_ctrladr[i];
  const bool constant_gain = gain_type == mjGAIN_FIXED || (gain_type == mjGAIN_AFFINE && gain[1] == 0);
  const bool constant_bias = bias_type == mjBIAS_NONE || (bias_type == mjBIAS_AFFINE && bias[1] == 0);
  ForceRange out{-kUnlimited, kUnlimited};
  if (constant_gain && constant_bias) {
    const double offset = bias_type == mjBIAS_NONE ? 0 : bias[0];
    const bool integrates = m_->actuator_dyntype[i] == mjDYN_INTEGRATOR;
    ForceRange input = out;
    if (integrates && m_->actuator_actlimited[i]) input = range_from(m_->actuator_actrange[2 * i], m_->actuator_actrange[2 * i + 1]);
    if (!integrates && m_->actuator_ctrlnum[i] > 0 && m_->actuator_ctrllimited[command])
      input = range_from(m_->actuator_ctrlrange[2 * command], m_->actuator_ctrlrange[2 * command + 1]);
    out = input.scaled(gain[0]) + ForceRange{offset, offset};
  }
  return m_->actuator_forcelimited[i] ? out.clamped(m_->actuator_forcerange + 2 * i) : out;
}

/// Takes an actuator on a joint. On a ball joint it acts on the hinges by the parts of its gear.
void MjcfMotors::add_actuator(int i) {
  const int joint = m_->actuator_trnid[2 * i];
  if (!is_on_joint(i) || roles_.of_joint(joint) != MjcfRole::Robot) return;
  const mjtNum* gear = m_->actuator_gear + 6 * m_->actuator_outadr[i];
  const ForceRange range = range_of(i);
  if (is_ball(joint)) {
    if (std::count(gear, gear + 3, 0.0) < 2) mixed_.push_back(describe("actuator", mjOBJ_ACTUATOR, i));
    for (int k = 0; k < 3; ++k) {
      const std::size_t dof = slot(m_->jnt_dofadr[joint] + k);
      if (gear[k] == 0) continue;
      sums_[dof] = sums_[dof] + range.scaled(gear[k]);
      add_servo(i, motors_[dof], gear[k]);
    }
    return;
  }
  const MjcfCoupling& line = couplings_.of(joint);
  if (line.leader < 0) return;
  const std::size_t own = slot(m_->jnt_dofadr[joint]), leader = slot(m_->jnt_dofadr[line.leader]);
  forces_[own] = forces_[own] + range.scaled(gear[0]);
  sums_[leader] = sums_[leader] + range.scaled(line.ratio * gear[0]);
  add_servo(i, motors_[leader], line.ratio * gear[0]);
  add_commands(i, line);
}

/// A position servo, with the force c·command + b₀ − k_p q − k_v q̇ and the gear g, gives its coordinate the stiffness k_p g² and the damping
/// k_v g²; (c·command + b₀)/k_p is the commanded position. @param lever  motion of the actuator per motion of the coordinate
void MjcfMotors::add_servo(int i, MjcfMotor& motor, double lever) {
  motor.driven = true;
  if (!is_position_servo(*m_, i)) return;
  const mjtNum* bias = m_->actuator_biasprm + i * mjNBIAS;
  motor.spring = motor.spring.value_or(0) - bias[1] * lever * lever;
  motor.servo_damping += std::max(0.0, -bias[2]) * lever * lever;
}

void MjcfMotors::add_commands(int i, const MjcfCoupling& line) {
  const auto positions = commanded_positions(*m_, i);
  if (!positions || line.ratio == 0) return;
  const auto [from, to] = std::minmax({(positions->first - line.offset) / line.ratio, (positions->second - line.offset) / line.ratio});
  auto& range = of_joint(line.leader).commands;
  range = range ? std::pair(std::min(from, range->first), std::max(to, range->second)) : std::pair(from, to);
}

/// Forces of the actuators on a tendon, after their gears. MuJoCo limits the sum of their forces before the gears.
ForceRange MjcfMotors::range_of_tendon(int tendon) const {
  ForceRange sum, bound;
  for (int i = 0; i < m_->nactuator; ++i) {
    if (m_->actuator_trntype[i] != mjTRN_TENDON || m_->actuator_trnid[2 * i] != tendon) continue;
    const double gear = m_->actuator_gear[6 * m_->actuator_outadr[i]];
    sum = sum + range_of(i).scaled(gear);
    const ForceRange most = range_from(m_->tendon_actfrcrange[2 * tendon], m_->tendon_actfrcrange[2 * tendon + 1]).scaled(gear);
    bound = {std::min(bound.lower, most.lower), std::max(bound.upper, most.upper)};
  }
  const mjtNum ends[] = {bound.lower, bound.upper};
  return m_->tendon_actfrclimited[tendon] ? sum.clamped(ends) : sum;
}

/// Takes the actuators on a tendon. They move joints that have no motor of their own.
void MjcfMotors::add_tendon(int tendon) {
  const auto joints = joints_of_tendon(tendon);
  const ForceRange range = range_of_tendon(tendon);
  std::vector<std::pair<int, double>> moved;
  for (int i = 0; i < m_->nactuator; ++i) {
    if (m_->actuator_trntype[i] != mjTRN_TENDON || m_->actuator_trnid[2 * i] != tendon) continue;
    moved = couplings_.moved_by_tendon(i);
    for (const auto& [leader, lever] : moved) add_servo(i, of_joint(leader), lever * m_->actuator_gear[6 * m_->actuator_outadr[i]]);
  }
  for (const auto& [leader, lever] : moved) {
    ForceRange& sum = sums_[slot(m_->jnt_dofadr[leader])];
    sum = sum + range.scaled(lever);
    for (const auto& [joint, coefficient] : *joints) {
      ForceRange& own = forces_[slot(m_->jnt_dofadr[joint])];
      if (couplings_.of(joint).leader == leader) own = own + range.scaled(coefficient);
    }
  }
}

/// Finds the efforts of all coordinates. The forces on a joint count within the range that the joint itself has for them.
void MjcfMotors::set_efforts() {
  std::vector<ForceRange> bounds(slot(m_->nv));
  for (int j = 0; j < m_->njnt; ++j) {
    const MjcfCoupling& line = couplings_.of(j);
    const ForceRange& own = forces_[slot(m_->jnt_dofadr[j])];
    if (!is_motor(j) || line.leader < 0 || own.is_zero()) continue;
    ForceRange& bound = bounds[slot(m_->jnt_dofadr[line.leader])];
    bound = bound + (m_->jnt_actfrclimited[j] ? own.clamped(m_->jnt_actfrcrange + 2 * j) : own).scaled(line.ratio);
  }
  for (int dof = 0; dof < m_->nv; ++dof) {
    const int joint = m_->dof_jntid[dof];
    const ForceRange &sum = sums_[slot(dof)], &bound = bounds[slot(dof)];
    if (!is_motor(joint))
      set_effort(dof, sum);
    else if (!sum.is_zero())
      set_effort(dof, {std::max(sum.lower, bound.lower), std::min(sum.upper, bound.upper)});
    else if (m_->jnt_actfrclimited[joint])
      set_effort(dof, range_from(m_->jnt_actfrcrange[2 * joint], m_->jnt_actfrcrange[2 * joint + 1]));
  }
}

/// Efforts are the same in both directions, so the weaker direction counts; for a motor that acts in one direction, its force in that direction.
void MjcfMotors::set_effort(int dof, const ForceRange& range) {
  constexpr double kRounding = 1e-9;
  const double weaker = std::min(-range.lower, range.upper), stronger = std::max(-range.lower, range.upper);
  const double effort = weaker > 0 ? weaker : stronger;
  if (effort <= 0 || !std::isfinite(effort)) return;
  motors_[slot(dof)].effort = effort;
  if (weaker <= 0)
    one_sided_.push_back(name_of(dof));
  else if (weaker < (1 - kRounding) * stronger)
    uneven_.push_back(name_of(dof));
}

void MjcfMotors::add_spring(int j) {
  const MjcfCoupling& line = couplings_.of(j);
  if (roles_.of_joint(j) != MjcfRole::Robot || !has_linear_spring(j) || line.leader < 0) return;
  MjcfMotor& motor = of_joint(line.leader);
  if (!motor.spring && motor.driven) {  // the motor is much stiffer than the spring
    unsprung_.push_back(joint_name(j));
    return;
  }
  const double stiffness = line.ratio * line.ratio * m_->jnt_stiffness[j];
  if (!motor.spring) {
    motor.passive_spring += stiffness;
    return;
  }
  *motor.spring += stiffness;
  sprung_.push_back(joint_name(j));
}

/// Coordinates without an actuator, which belong to a robot only because another joint of their tree has one.
std::vector<std::string> MjcfMotors::without_actuator() const {
  std::vector<std::string> names;
  for (int dof = 0; roles_.by_actuators() && dof < m_->nv; ++dof) {
    const int joint = m_->dof_jntid[dof];
    const bool leads = couplings_.of(joint).leader == joint;
    if (roles_.of_joint(joint) == MjcfRole::Robot && !of(dof).driven && leads) names.push_back(name_of(dof));
  }
  return names;
}

std::vector<std::string> MjcfMotors::notes() const {
  std::vector<std::string> out = couplings_.notes(), silent;
  for (const int j : roles_.silent_motors()) silent.push_back(joint_name(j));
  const auto add = [&](const char* text, const std::vector<std::string>& names) {
    if (!names.empty()) out.push_back(fmt::format(fmt::runtime(text), list_some(names)));
  };
  add("springs add to the stiffness of motors, whose commands act against them, of joints: {}", sprung_);
  add("springs beside motors that are no position servos are left out, of joints: {}", unsprung_);
  add("efforts are the same in both directions, so motors that act in one direction act in both with the same force, of joints: {}",
      one_sided_);
  add("efforts are the same in both directions, so the weaker direction of motors counts for both, of joints: {}", uneven_);
  add("actuators that turn a ball joint about several of its axes act on each hinge alone: {}", mixed_);
  add("joints in trees without an actuator have motors here: {}; with `file:` in the scene they are objects", silent);
  add("joints of the robot that no actuator of the file moves have motors here: {}", without_actuator());
  return out;
}

}  // namespace stiction::world
