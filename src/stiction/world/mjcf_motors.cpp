#include "stiction/world/mjcf_motors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stiction/core/number.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

double largest(const mjtNum* range) { return std::max(std::abs(range[0]), std::abs(range[1])); }

}  // namespace

MjcfMotors::MjcfMotors(const MjcfView& view) : MjcfView(view), couplings_(view) { find_springs(); }

double MjcfMotors::gear_of(int actuator) const { return m_->actuator_gear[6 * m_->actuator_outadr[actuator]]; }

/// Finds stiffness, servo damping and effort of all joints. A position servo, with the force c·command + b₀ − k_p q − k_v q̇ and the gear g, gives its
/// joint the stiffness k_p g² and the damping k_v g²; (c·command + b₀)/k_p is the commanded position. The effort is the
/// actuator's force range through the gear, and for a motor at most the force of its largest command. A force range of the joint itself
/// replaces both.
void MjcfMotors::find_springs() {
  spring_.resize(static_cast<std::size_t>(m_->njnt));
  effort_.resize(static_cast<std::size_t>(m_->njnt));
  damping_.assign(static_cast<std::size_t>(m_->njnt), 0);
  passive_.assign(static_cast<std::size_t>(m_->njnt), 0);
  commands_.resize(static_cast<std::size_t>(m_->njnt));
  has_actuator_.assign(static_cast<std::size_t>(m_->njnt), false);
  for (int i = 0; i < m_->nactuator; ++i) {
    if (!is_on_joint(i) || roles_.of_joint(m_->actuator_trnid[2 * i]) != MjcfRole::Robot) continue;
    const MjcfCoupling& line = couplings_.of(m_->actuator_trnid[2 * i]);
    if (line.leader < 0) continue;
    add_actuator(i, line.leader, line.ratio * gear_of(i));
    add_commands(i, line);
  }
  for (int i = 0; i < m_->nactuator; ++i) {
    for (const auto& [joint, lever] : couplings_.moved_by_tendon(i)) add_actuator(i, joint, lever * gear_of(i));
  }
  for (int j = 0; j < m_->njnt; ++j) {
    const double force = largest(m_->jnt_actfrcrange + 2 * j);
    if (m_->jnt_actfrclimited[j] && force <= core::kLargestNumber) effort_[static_cast<std::size_t>(j)] = force;
  }
  for (int j = 0; j < m_->njnt; ++j) add_spring(j);
}

void MjcfMotors::add_spring(int j) {
  const MjcfCoupling& line = couplings_.of(j);
  if (roles_.of_joint(j) != MjcfRole::Robot || !has_linear_spring(j) || line.leader < 0) return;
  const auto leader = static_cast<std::size_t>(line.leader);
  if (!spring_[leader] && has_actuator_[leader]) {  // the motor is much stiffer than the spring
    unsprung_.push_back(joint_name(j));
    return;
  }
  const double stiffness = line.ratio * line.ratio * m_->jnt_stiffness[j];
  if (!spring_[leader]) {
    passive_[leader] += stiffness;
    return;
  }
  spring_[leader] = *spring_[leader] + stiffness;
  sprung_.push_back(joint_name(j));
}

/// @param lever  motion of the actuator per motion of the joint
void MjcfMotors::add_actuator(int i, int j, double lever) {
  const mjtNum* gain = m_->actuator_gainprm + i * mjNGAIN;
  const mjtNum* bias = m_->actuator_biasprm + i * mjNBIAS;
  const auto joint = static_cast<std::size_t>(j);
  has_actuator_[joint] = true;
  const bool fixed_gain = m_->actuator_gaintype[i] == mjGAIN_FIXED;
  std::optional<double> force;
  if (m_->actuator_forcelimited[i]) force = largest(m_->actuator_forcerange + 2 * i);
  const int command = m_->actuator_ctrladr[i];
  if (fixed_gain && m_->actuator_biastype[i] == mjBIAS_NONE && m_->actuator_ctrlnum[i] > 0 && m_->actuator_ctrllimited[command]) {
    const double asked = std::abs(gain[0]) * largest(m_->actuator_ctrlrange + 2 * command);
    force = force ? std::min(*force, asked) : asked;
  }
  if (force && *force <= core::kLargestNumber && *force * lever != 0)
    effort_[joint] = effort_[joint].value_or(0) + *force * std::abs(lever);
  if (!is_position_servo(*m_, i)) return;
  spring_[joint] = spring_[joint].value_or(0) - bias[1] * lever * lever;
  damping_[joint] += std::max(0.0, -bias[2]) * lever * lever;
}

void MjcfMotors::add_commands(int i, const MjcfCoupling& line) {
  const auto positions = commanded_positions(*m_, i);
  if (!positions || line.ratio == 0) return;
  const auto [from, to] = std::minmax({(positions->first - line.offset) / line.ratio, (positions->second - line.offset) / line.ratio});
  auto& range = commands_[static_cast<std::size_t>(line.leader)];
  range = range ? std::pair(std::min(from, range->first), std::max(to, range->second)) : std::pair(from, to);
}

/// Leading joints without an actuator, which belong to a robot only because another joint of their tree has one.
std::vector<std::string> MjcfMotors::without_actuator() const {
  std::vector<std::string> names;
  for (int j = 0; roles_.by_actuators() && j < m_->njnt; ++j) {
    const bool leads = couplings_.of(j).leader == j;
    if (roles_.of_joint(j) == MjcfRole::Robot && !has_actuator_[static_cast<std::size_t>(j)] && leads) names.push_back(joint_name(j));
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
  add("joints in trees without an actuator have motors here: {}; with `file:` in the scene they are objects", silent);
  add("joints of the robot that no actuator of the file moves have motors here: {}", without_actuator());
  return out;
}

}  // namespace stiction::world
