#include "stiction/world/mjcf_couplings.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stiction/world/mjcf_loops.hpp"
#include "stiction/world/nearest_line.hpp"
#include "stiction/world/robot_tree.hpp"

namespace stiction::world {
namespace {

constexpr double kRounding = 1e-9;  // rounding error, relative to the largest term
constexpr double kUnlimited = 1;    // half of the range in which a joint without limits is sampled [rad, m]
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Range of y = ratio·x + offset for x in a range.
std::pair<double, double> mapped(std::pair<double, double> range, double ratio, double offset) {
  const double one = ratio * range.first + offset, other = ratio * range.second + offset;
  return {std::min(one, other), std::max(one, other)};
}

std::pair<double, double> common(std::pair<double, double> a, std::pair<double, double> b) {
  return {std::max(a.first, b.first), std::min(a.second, b.second)};
}

}  // namespace

MjcfCouplings::MjcfCouplings(const MjcfView& view) : MjcfView(view) {
  for (int j = 0; j < m_->njnt; ++j) lines_.push_back({.joint = j, .leader = j});
  limits_.resize(at(m_->njnt));
  meaning_.equality.assign(at(m_->neq), false);
  meaning_.tendon_limit.assign(at(m_->ntendon), false);
  meaning_.tendon_spring.assign(at(m_->ntendon), false);
  find_motors();
  take_equalities();
  take_actuated_tendons();
  take_loops();
  take_narrow_limits();
  take_other_limits();
  take_springs();
}

void MjcfCouplings::find_motors() {
  has_motor_.assign(at(m_->njnt), false);
  driven_.assign(at(m_->njnt), false);
  for (int i = 0; i < m_->nactuator; ++i) {
    if (is_on_joint(i) && is_motor(m_->actuator_trnid[2 * i])) {
      has_motor_[at(m_->actuator_trnid[2 * i])] = driven_[at(m_->actuator_trnid[2 * i])] = true;
    } else if (m_->actuator_trntype[i] == mjTRN_TENDON) {
      for (const auto& [joint, coefficient] : joints_of_tendon(m_->actuator_trnid[2 * i]).value_or(std::map<int, double>{}))
        driven_[at(joint)] = true;
    }
  }
}

/// Expresses a relation in terms of leading joints.
MjcfCouplings::Relation MjcfCouplings::reduce(const Relation& relation) const {
  Relation out{.terms = {}, .constant = relation.constant};
  double largest = 0;
  for (const auto& [joint, coefficient] : relation.terms) {
    const MjcfCoupling& line = of(joint);
    out.constant += coefficient * line.offset;
    if (line.leader >= 0) out.terms[line.leader] += coefficient * line.ratio;
    largest = std::max(largest, std::abs(coefficient));
  }
  std::erase_if(out.terms, [&](const auto& term) { return std::abs(term.second) <= kRounding * largest; });
  return out;
}

/// Makes a leading joint and all its followers follow another joint.
void MjcfCouplings::follow(int joint, int leader, double ratio, double offset) {
  for (MjcfCoupling& line : lines_) {
    if (line.leader != joint) continue;
    line.leader = leader;
    line.offset += line.ratio * offset;
    line.ratio *= ratio;
  }
  if (leader < 0) return;
  has_motor_[at(leader)] = has_motor_[at(leader)] || has_motor_[at(joint)];
  driven_[at(leader)] = driven_[at(leader)] || driven_[at(joint)];
}

/// Makes one joint of a relation follow the other.
/// @param follower        the joint that follows if an actuator moves both joints or none; −1: the last one
/// @param only_to_driven  true: a relation between two joints without an actuator is left for later
/// @returns whether the relation holds from now on
bool MjcfCouplings::couple(const Relation& relation, int follower, bool only_to_driven) {
  const Relation left = reduce(relation);
  if (left.terms.empty()) return std::abs(left.constant) <= kRounding * std::max(1.0, std::abs(relation.constant));
  const auto& [a, c_a] = *left.terms.begin();
  const auto& [b, c_b] = *left.terms.rbegin();
  if (left.terms.size() == 1) {
    follow(a, -1, 0, -left.constant / c_a);
    return true;
  }
  const bool neither = !driven_[at(a)] && !driven_[at(b)];
  if (left.terms.size() > 2 || (only_to_driven && neither)) return false;
  const bool a_follows = driven_[at(a)] != driven_[at(b)] ? driven_[at(b)] : follower >= 0 && of(follower).leader == a;
  if (a_follows)
    follow(a, b, -c_b / c_a, -left.constant / c_a);
  else
    follow(b, a, -c_a / c_b, -left.constant / c_b);
  return true;
}

/// Couples joints by the equalities of the file. Of the tendon equalities, those on an actuated joint come first.
void MjcfCouplings::take_equalities() {
  const auto is_open = [&](int i, mjtEq type) { return m_->eq_active0[i] && m_->eq_type[i] == type && !meaning_.equality[at(i)]; };
  for (int i = 0; i < m_->neq; ++i) {
    if (!is_open(i, mjEQ_JOINT) || !couples_joints(i)) continue;
    double error = 0;
    meaning_.equality[at(i)] = couple(relation_of_joints(i, error), m_->eq_obj1id[i]);
    if (error > 0) curved_.push_back(fmt::format("{} {:.3g}", joint_name(m_->eq_obj1id[i]), error));
  }
  for (const bool only_to_driven : {true, false}) {
    for (bool again = true; again;) {
      again = false;
      for (int i = 0; i < m_->neq; ++i) {
        if (!is_open(i, mjEQ_TENDON)) continue;
        const auto relation = relation_of_tendons(i);
        if (relation && couple(*relation, -1, only_to_driven)) meaning_.equality[at(i)] = again = true;
      }
    }
  }
}

/// Approximates y − y₀ = Σ a_k (x − x₀)^k by the nearest line, over the values of x that the ranges of both joints allow.
MjcfCouplings::Relation MjcfCouplings::relation_of_joints(int i, double& error) const {
  const int joint = m_->eq_obj1id[i], leader = m_->eq_obj2id[i];
  const mjtNum* a = m_->eq_data + i * mjNEQDATA;
  const double y0 = reference(joint);
  if (leader < 0) return {{{joint, 1.0}}, -(y0 + a[0])};
  const double x0 = reference(leader);
  if (a[2] == 0 && a[3] == 0 && a[4] == 0) return {{{joint, 1.0}, {leader, -a[1]}}, -(y0 + a[0] - a[1] * x0)};
  const std::pair<double, double> all{-kInfinity, kInfinity};
  const auto range = [&](int j) { return m_->jnt_limited[j] ? std::pair{m_->jnt_range[2 * j], m_->jnt_range[2 * j + 1]} : all; };
  const auto along = m_->jnt_limited[leader] ? range(leader) : std::pair{x0 - kUnlimited, x0 + kUnlimited};
  const auto value = [&](double x) {
    const double d = x - x0;
    return y0 + a[0] + d * (a[1] + d * (a[2] + d * (a[3] + d * a[4])));
  };
  const NearestLine line = nearest_line(value, along, range(joint));
  error = line.error;
  return {{{joint, 1.0}, {leader, -line.slope}}, -line.offset};
}

/// The relation L₁ − L₁₀ = a₀ + a₁ (L₂ − L₂₀) between fixed tendons; nullopt for other tendons, and for a polynomial of higher degree.
std::optional<MjcfCouplings::Relation> MjcfCouplings::relation_of_tendons(int i) const {
  const mjtNum* a = m_->eq_data + i * mjNEQDATA;
  const int first = m_->eq_obj1id[i], second = m_->eq_obj2id[i];
  const auto one = joints_of_tendon(first);
  const auto other = second >= 0 ? joints_of_tendon(second) : std::map<int, double>{};
  if (!one || !other || (second >= 0 && (a[2] != 0 || a[3] != 0 || a[4] != 0))) return std::nullopt;
  Relation out{.terms = *one, .constant = -a[0]};
  for (const auto& [joint, coefficient] : *other) out.terms[joint] -= a[1] * coefficient;
  for (const auto& [joint, coefficient] : out.terms) out.constant -= coefficient * reference(joint);
  return out;
}

/// Couples the joints on a tendon with an actuator. The actuator pulls on all joints of its tendon with the same force, scaled by each joint's
/// coefficient, so the joints move in that ratio; the first joint without a motor of its own leads. If as many actuated tendons as joints act on
/// a set of joints, the joints move by themselves.
void MjcfCouplings::take_actuated_tendons() {
  std::map<int, std::vector<int>> tendons_of;  // actuators by joint that leads
  for (int i = 0; i < m_->nactuator; ++i) {
    for (const auto& [joint, lever] : moved_by_tendon(i)) tendons_of[joint].push_back(i);
  }
  for (int i = 0; i < m_->nactuator; ++i) {
    const auto moved = moved_by_tendon(i);
    if (moved.size() < 2) continue;
    std::vector<int> actuators;
    for (const auto& [joint, lever] : moved) actuators.insert(actuators.end(), tendons_of[joint].begin(), tendons_of[joint].end());
    std::sort(actuators.begin(), actuators.end());
    actuators.erase(std::unique(actuators.begin(), actuators.end()), actuators.end());
    Eigen::MatrixXd levers = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(actuators.size()), static_cast<Eigen::Index>(moved.size()));
    for (std::size_t row = 0; row < actuators.size(); ++row) {
      for (const auto& [joint, lever] : moved_by_tendon(actuators[row])) {
        const auto column = std::find_if(moved.begin(), moved.end(), [&](const auto& entry) { return entry.first == joint; });
        if (column != moved.end()) levers(static_cast<Eigen::Index>(row), column - moved.begin()) = lever;
      }
    }
    if (levers.colPivHouseholderQr().rank() == levers.cols()) continue;
    const auto [leader, lead] = moved[0];
    for (std::size_t k = 1; k < moved.size(); ++k) {
      const auto [joint, lever] = moved[k];
      const double ratio = lever / lead;
      follow(joint, leader, ratio, reference(joint) - ratio * reference(leader));
      on_tendons_.push_back(joint_name(joint));
    }
  }
}

std::vector<std::pair<int, double>> MjcfCouplings::moved_by_tendon(int actuator) const {
  if (m_->actuator_trntype[actuator] != mjTRN_TENDON) return {};
  const auto joints = joints_of_tendon(m_->actuator_trnid[2 * actuator]);
  if (!joints) return {};
  std::vector<std::pair<int, double>> out;
  for (const auto& term : reduce({*joints, 0}).terms) {
    if (!has_motor_[at(term.first)]) out.push_back(term);
  }
  return out;
}

/// Makes the joints of a loop follow its driven joint. The lines are fitted over the range of the driven joint; if it has no limits, over one
/// unit to both sides of its value in the file.
void MjcfCouplings::take_loops() {
  for (int i = 0; i < m_->neq; ++i) {
    if (!m_->eq_active0[i]) continue;
    auto loop = MjcfLoop::find(
        *m_, i, *this, [this](int joint) -> const MjcfCoupling& { return of(joint); }, driven_);
    if (!loop) continue;
    const double place = reference(loop->leader());
    const auto range = range_of(loop->leader());
    const bool limited = std::isfinite(range.first) && std::isfinite(range.second);
    const std::pair<double, double> along = limited ? range : std::pair{place - kUnlimited, place + kUnlimited};
    std::vector<NearestLine> lines;
    for (std::size_t k = 0; k < loop->joints().size(); ++k) {
      const auto value = [&](double x) { return loop->solve(x)[static_cast<Eigen::Index>(k)]; };
      lines.push_back(nearest_line(value, along, {-kInfinity, kInfinity}));
    }
    const auto closes = [](const NearestLine& line) { return std::isfinite(line.slope + line.offset); };
    if (!std::ranges::all_of(lines, closes)) continue;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const int joint = loop->joints()[k];
      follow(joint, loop->leader(), lines[k].slope, lines[k].offset);
      in_loops_.push_back(fmt::format("{} {:.3g}", joint_name(joint), lines[k].error));
    }
    meaning_.equality[at(i)] = true;
  }
}

/// Range of a leading joint: the intersection of its own range and the ranges of its followers.
std::pair<double, double> MjcfCouplings::range_of(int leader) const {
  std::pair<double, double> out{-kInfinity, kInfinity};
  for (const MjcfCoupling& line : lines_) {
    if (line.leader != leader || line.ratio == 0 || !m_->jnt_limited[line.joint]) continue;
    const mjtNum* range = m_->jnt_range + 2 * line.joint;
    out = common(out, mapped({range[0], range[1]}, 1 / line.ratio, -line.offset / line.ratio));
  }
  return out;
}

std::pair<double, double> MjcfCouplings::range_of(const Relation& length) const {
  std::pair<double, double> out{length.constant, length.constant};
  for (const auto& [joint, coefficient] : length.terms) {
    const auto part = mapped(range_of(joint), coefficient, 0);
    out.first += part.first, out.second += part.second;
  }
  return out;
}

/// Of two joints on a tendon, the one without an actuator, if the limits of the tendon leave it less than half of its range at a given value of
/// the other joint.
std::optional<int> MjcfCouplings::narrow_follower(const Relation& length, int tendon) const {
  constexpr double kNarrow = 0.5;
  if (length.terms.size() != 2) return std::nullopt;
  const auto& [a, c_a] = *length.terms.begin();
  const auto& [b, c_b] = *length.terms.rbegin();
  if (driven_[at(a)] == driven_[at(b)]) return std::nullopt;
  const auto& [joint, coefficient] = driven_[at(a)] ? *length.terms.rbegin() : *length.terms.begin();
  const auto [lower, upper] = range_of(joint);
  const mjtNum* limits = m_->tendon_range + 2 * tendon;
  return limits[1] - limits[0] < kNarrow * (upper - lower) * std::abs(coefficient) ? std::optional(joint) : std::nullopt;
}

/// Makes a joint without an actuator follow another joint if a tendon keeps the two near a linear relation, as for the outermost joints of
/// tendon-driven fingers.
void MjcfCouplings::take_narrow_limits() {
  for (int i = 0; i < m_->ntendon; ++i) {
    const auto joints = m_->tendon_limited[i] ? joints_of_tendon(i) : std::nullopt;
    if (!joints) continue;
    Relation length = reduce({*joints, 0});
    const auto follower = narrow_follower(length, i);
    if (!follower) continue;
    const mjtNum* limits = m_->tendon_range + 2 * i;
    const double room = (limits[1] - limits[0]) / 2 / std::abs(length.terms.at(*follower));
    length.constant -= (limits[0] + limits[1]) / 2;
    for (MjcfCoupling& line : lines_) {
      if (line.leader == *follower) line.room += std::abs(line.ratio) * room;
    }
    if (couple(length, *follower) && room > 0) kept_near_.push_back(fmt::format("{} {:.3g}", joint_name(*follower), room));
  }
}

/// Turns the length limits of a tendon over one joint into limits of that joint, and drops limits that the joints never reach.
void MjcfCouplings::take_other_limits() {
  for (int i = 0; i < m_->ntendon; ++i) {
    const auto joints = m_->tendon_limited[i] ? joints_of_tendon(i) : std::nullopt;
    if (!joints) continue;
    const Relation length = reduce({*joints, 0});
    const auto [least, most] = range_of(length);
    const mjtNum* limits = m_->tendon_range + 2 * i;
    const double rounding = kRounding * std::max(std::abs(limits[0]), std::abs(limits[1]));
    meaning_.tendon_limit[at(i)] = least >= limits[0] - rounding && most <= limits[1] + rounding;
    if (meaning_.tendon_limit[at(i)] || length.terms.size() != 1) continue;
    const auto& [joint, coefficient] = *length.terms.begin();
    const auto set = common(mapped({limits[0], limits[1]}, 1 / coefficient, -length.constant / coefficient),
                            limits_[at(joint)].value_or(std::pair{-kInfinity, kInfinity}));
    const auto left = common(set, range_of(joint));
    if (left.first > left.second) continue;
    limits_[at(joint)] = set;
    meaning_.tendon_limit[at(i)] = true;
  }
}

/// Ignores the spring of a tendon whose length never changes.
void MjcfCouplings::take_springs() {
  for (int i = 0; i < m_->ntendon; ++i) {
    const auto joints = joints_of_tendon(i);
    meaning_.tendon_spring[at(i)] = joints && reduce({*joints, 0}).terms.empty();
  }
}

std::vector<MjcfCoupling> MjcfCouplings::list() const {
  std::vector<MjcfCoupling> out;
  std::copy_if(lines_.begin(), lines_.end(), std::back_inserter(out), [](const MjcfCoupling& line) { return line.leader != line.joint; });
  return out;
}

std::optional<std::pair<double, double>> MjcfCouplings::limits(int joint) const { return limits_[at(joint)]; }

/// Joints with a motor of their own on tendons with an actuator, which the actuator does not move here.
std::vector<std::string> MjcfCouplings::unmoved_by_tendons() const {
  std::vector<std::string> out;
  for (int i = 0; i < m_->nactuator; ++i) {
    if (!drives_joints(i)) continue;
    const int tendon = m_->actuator_trnid[2 * i];
    for (const auto& [joint, lever] : reduce({*joints_of_tendon(tendon), 0}).terms) {
      const std::string name = fmt::format("{} on {}", describe("tendon", mjOBJ_TENDON, tendon), joint_name(joint));
      if (has_motor_[at(joint)] && std::ranges::find(out, name) == out.end()) out.push_back(name);
    }
  }
  return out;
}

std::vector<std::string> MjcfCouplings::notes() const {
  std::vector<std::string> out;
  const auto add = [&](const char* text, const std::vector<std::string>& names) {
    if (!names.empty()) out.push_back(fmt::format(fmt::runtime(text), list_some(names)));
  };
  add("joints that share a tendon with an actuator move in the ratio of its coefficients; these follow: {}", on_tendons_);
  add("actuators on tendons do not act on joints that have motors of their own: {}", unmoved_by_tendons());
  add("joints that follow others by a polynomial follow the nearest line, which is off by at most [rad, m]: {}", curved_);
  add("joints that a connection closes to a loop follow its driven joint by the nearest line, which is off by at most [rad, m]: {}",
      in_loops_);
  add("joints without an actuator that a tendon keeps near others follow them, from which the file lets them go by at most [rad, m]: {}",
      kept_near_);
  return out;
}

}  // namespace stiction::world
