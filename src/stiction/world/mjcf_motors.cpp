#include "stiction/world/mjcf_motors.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

double largest(const mjtNum* range) { return std::max(std::abs(range[0]), std::abs(range[1])); }

}  // namespace

MjcfMotors::MjcfMotors(const MjcfView& view) : MjcfView(view) {
  find_springs();
  find_equalities();
}

double MjcfMotors::gear_of(int actuator) const { return m_->actuator_gear[6 * m_->actuator_outadr[actuator]]; }

/// A position servo of gain k_p through gear g holds its joint with the stiffness k_p g². What any actuator can bear: its range of forces
/// through the gear, or of a motor that of its commands; of a joint with a range of its own that.
void MjcfMotors::find_springs() {
  spring_.resize(static_cast<std::size_t>(m_->njnt));
  effort_.resize(static_cast<std::size_t>(m_->njnt));
  has_actuator_.assign(static_cast<std::size_t>(m_->njnt), false);
  for (int i = 0; i < m_->nactuator; ++i) {
    if (!is_on_joint(i) || roles_.of_joint(m_->actuator_trnid[2 * i]) != MjcfRole::Robot) continue;
    add_actuator(i, m_->actuator_trnid[2 * i], gear_of(i));
  }
  for (int i = 0; i < m_->nactuator; ++i) {
    if (drives_joints(i)) add_tendon(i);
  }
  for (int j = 0; j < m_->njnt; ++j) {
    const auto joint = static_cast<std::size_t>(j);
    if (m_->jnt_actfrclimited[j]) effort_[joint] = largest(m_->jnt_actfrcrange + 2 * j);
    if (roles_.of_joint(j) != MjcfRole::Robot || !has_linear_spring(j)) continue;
    if (!spring_[joint] && has_actuator_[joint]) {  // its motor is stiffer by far
      unsprung_.push_back(joint_name(j));
      continue;
    }
    spring_[joint] = spring_[joint].value_or(0) + m_->jnt_stiffness[j];
    sprung_.push_back(joint_name(j));
  }
}

/// @param lever  how far the actuator moves per motion of the joint
void MjcfMotors::add_actuator(int i, int j, double lever) {
  const mjtNum* gain = m_->actuator_gainprm + i * mjNGAIN;
  const mjtNum* bias = m_->actuator_biasprm + i * mjNBIAS;
  const auto joint = static_cast<std::size_t>(j);
  has_actuator_[joint] = true;
  const bool fixed_gain = m_->actuator_gaintype[i] == mjGAIN_FIXED;
  std::optional<double> force;
  if (m_->actuator_forcelimited[i])
    force = largest(m_->actuator_forcerange + 2 * i);
  else if (fixed_gain && m_->actuator_biastype[i] == mjBIAS_NONE && m_->actuator_ctrllimited[i])
    force = std::abs(gain[0]) * largest(m_->actuator_ctrlrange + 2 * i);
  if (force && *force * lever != 0) effort_[joint] = effort_[joint].value_or(0) + *force * std::abs(lever);
  const bool servo = fixed_gain && m_->actuator_biastype[i] == mjBIAS_AFFINE && gain[0] > 0 && bias[0] == 0 && bias[1] == -gain[0] &&
                     m_->actuator_dyntype[i] != mjDYN_INTEGRATOR;
  if (servo) spring_[joint] = spring_[joint].value_or(0) + gain[0] * lever * lever;
}

/// An actuator pulls with the same force on all joints of its tendon, each by its coefficient: they turn in that ratio, and the first one
/// without a motor of its own leads.
void MjcfMotors::add_tendon(int actuator) {
  const int tendon = m_->actuator_trnid[2 * actuator];
  int leader = -1;
  double leading = 0, lever = 0;
  for (int w = m_->tendon_adr[tendon]; w < m_->tendon_adr[tendon] + m_->tendon_num[tendon]; ++w) {
    const int j = m_->wrap_objid[w];
    if (has_actuator_[static_cast<std::size_t>(j)]) continue;
    const double coefficient = m_->wrap_prm[w];
    if (leader < 0) leader = j, leading = coefficient;
    const double ratio = coefficient / leading;
    lever += coefficient * ratio;
    if (j == leader) continue;
    has_actuator_[static_cast<std::size_t>(j)] = true;
    couplings_.push_back({j, leader, ratio, reference(j) - ratio * reference(leader)});
    on_tendons_.push_back(joint_name(j));
  }
  if (leader >= 0) add_actuator(actuator, leader, lever * gear_of(actuator));
}
void MjcfMotors::find_equalities() {
  for (int i = 0; i < m_->neq; ++i) {
    if (!m_->eq_active0[i] || !couples_joints(i)) continue;
    double error = 0;
    couplings_.push_back(read_equality(i, error));
    if (error > 0) curved_.push_back(fmt::format("{} {:.3g}", joint_name(couplings_.back().joint), error));
  }
}

/// The line nearest to y − y₀ = Σ a_k (x − x₀)^k over the range of the leader, by least squares.
MjcfCoupling MjcfMotors::read_equality(int i, double& error) const {
  const int joint = m_->eq_obj1id[i], leader = m_->eq_obj2id[i];
  const mjtNum* a = m_->eq_data + i * mjNEQDATA;
  const double y0 = reference(joint);
  if (leader < 0) return {joint, leader, 0, y0 + a[0]};
  const double x0 = reference(leader);
  if (a[2] == 0 && a[3] == 0 && a[4] == 0) return {joint, leader, a[1], y0 + a[0] - a[1] * x0};
  constexpr int kPoints = 65;
  const mjtNum* range = m_->jnt_range + 2 * leader;
  const bool limited = m_->jnt_limited[leader];
  const double lower = limited ? range[0] : x0 - 1, upper = limited ? range[1] : x0 + 1;
  Eigen::MatrixX2d A(kPoints, 2);
  Eigen::VectorXd y(kPoints);
  for (int k = 0; k < kPoints; ++k) {
    const double x = lower + (upper - lower) * k / (kPoints - 1), d = x - x0;
    A.row(k) << x, 1;
    y[k] = y0 + a[0] + d * (a[1] + d * (a[2] + d * (a[3] + d * a[4])));
  }
  const Eigen::Vector2d line = A.colPivHouseholderQr().solve(y);
  error = (A * line - y).cwiseAbs().maxCoeff();
  return {joint, leader, line[0], line[1]};
}

/// Joints of robots that the rule made so because of other joints of their tree.
std::vector<std::string> MjcfMotors::without_actuator() const {
  std::vector<std::string> names;
  for (int j = 0; roles_.by_actuators() && j < m_->njnt; ++j) {
    const bool follows = std::any_of(couplings_.begin(), couplings_.end(), [&](const MjcfCoupling& c) { return c.joint == j; });
    if (roles_.of_joint(j) == MjcfRole::Robot && !has_actuator_[static_cast<std::size_t>(j)] && !follows) names.push_back(joint_name(j));
  }
  return names;
}

std::vector<std::string> MjcfMotors::notes() const {
  std::vector<std::string> out, silent;
  for (const int j : roles_.silent_motors()) silent.push_back(joint_name(j));
  const auto add = [&](const char* text, const std::vector<std::string>& names) {
    if (!names.empty()) out.push_back(fmt::format(fmt::runtime(text), list_some(names)));
  };
  add("joints that share a tendon with an actuator move in the ratio of its coefficients; these follow: {}", on_tendons_);
  add("joints that follow others by a polynomial follow the nearest line, which is off by at most [rad, m]: {}", curved_);
  add("springs add to the stiffness of motors, whose commands act against them, of joints: {}", sprung_);
  add("springs beside motors that are no position servos are left out, of joints: {}", unsprung_);
  add("joints in trees without an actuator have motors here: {}; with `file:` in the scene they are objects", silent);
  add("joints of the robot that no actuator of the file moves have motors here: {}", without_actuator());
  return out;
}

}  // namespace stiction::world
