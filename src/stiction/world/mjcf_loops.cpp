#include "stiction/world/mjcf_loops.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace stiction::world {
namespace {

constexpr int kIterations = 100;
constexpr double kMeet = 1e-4;     // largest gap between anchors that meet [size of the loop]
constexpr double kMostStep = 0.2;  // largest step of a hinge [rad]
constexpr double kSpring = 1e-7;   // weight of the springs relative to the gap: so small that springs do not open the loop
constexpr double kStill = 1e-9;    // a shorter step ends the search [rad, size of the loop]
constexpr int kMostParts = 64;     // largest number of parts of the way from one solution to the next

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<int> bodies_above(const mjModel& m, int body) {
  std::vector<int> out;
  for (; body > 0; body = m.body_parentid[body]) out.push_back(body);
  return out;
}

/// Joints on the path between two bodies: joints above exactly one of them.
std::vector<int> joints_between(const mjModel& m, int a, int b) {
  const auto above_a = bodies_above(m, a), above_b = bodies_above(m, b);
  std::vector<int> out;
  for (const auto& [some, others] : {std::pair(&above_a, &above_b), std::pair(&above_b, &above_a)}) {
    for (const int body : *some) {
      if (std::ranges::find(*others, body) != others->end()) continue;
      for (int j = 0; j < m.body_jntnum[body]; ++j) out.push_back(m.body_jntadr[body] + j);
    }
  }
  return out;
}

}  // namespace

MjcfLoop::MjcfLoop(const mjModel& m, int equality) : m_(&m), data_(mj_makeData(&m)), equality_(equality) {}

std::optional<MjcfLoop> MjcfLoop::find(const mjModel& m, int equality, const MjcfView& view,
                                       const std::function<const MjcfCoupling&(int)>& line, const std::vector<bool>& driven) {
  if (m.eq_type[equality] != mjEQ_CONNECT || m.eq_objtype[equality] != mjOBJ_BODY) return std::nullopt;
  std::vector<int> leaders, free;
  for (const int j : joints_between(m, m.eq_obj1id[equality], m.eq_obj2id[equality])) {
    if (!view.is_motor(j)) return std::nullopt;
    const int leader = line(j).leader;
    if (leader < 0) continue;
    auto& list = driven[at(leader)] ? leaders : free;
    if (std::ranges::find(list, leader) == list.end()) list.push_back(leader);
  }
  if (leaders.size() != 1 || free.empty()) return std::nullopt;
  MjcfLoop out(m, equality);
  out.leader_ = leaders[0], out.free_ = free;
  for (int j = 0; j < m.njnt; ++j) {
    if (!view.slides_or_turns(j)) continue;
    const MjcfCoupling& coupling = line(j);
    if (coupling.leader < 0 || coupling.leader == leaders[0] || std::ranges::find(free, coupling.leader) != free.end())
      out.lines_.push_back(coupling);
  }
  const auto n = static_cast<Eigen::Index>(free.size());
  out.lower_.setConstant(n, -std::numeric_limits<double>::infinity());
  out.upper_ = -out.lower_;
  out.rest_.setZero(n), out.stiffness_.setZero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int j = free[static_cast<std::size_t>(i)];
    if (m.jnt_limited[j]) out.lower_[i] = m.jnt_range[2 * j], out.upper_[i] = m.jnt_range[2 * j + 1];
    out.rest_[i] = m.qpos_spring[m.jnt_qposadr[j]];
    out.stiffness_[i] = m.jnt_stiffness[j];
  }
  if (out.stiffness_.maxCoeff() > 0) out.stiffness_ /= out.stiffness_.maxCoeff();
  out.place(m.qpos0[m.jnt_qposadr[out.leader_]], out.file_pose());
  for (const MjcfCoupling& coupling : out.lines_) {
    const Eigen::Map<const Eigen::Vector3d> axis_at(out.data_->xanchor + 3 * coupling.joint);
    out.size_ = std::max(out.size_, (axis_at - out.anchor(0)).norm());
  }
  return out;
}

/// Values of the free joints in the file.
Eigen::VectorXd MjcfLoop::file_pose() const {
  Eigen::VectorXd y(static_cast<Eigen::Index>(free_.size()));
  for (Eigen::Index i = 0; i < y.size(); ++i) y[i] = m_->qpos0[m_->jnt_qposadr[free_[static_cast<std::size_t>(i)]]];
  return y.cwiseMax(lower_).cwiseMin(upper_);
}

void MjcfLoop::place(double x, const Eigen::VectorXd& y) {
  mju_copy(data_->qpos, m_->qpos0, m_->nq);
  for (const MjcfCoupling& line : lines_) {
    double value = line.offset;
    if (line.leader == leader_) {
      value += line.ratio * x;
    } else if (line.leader >= 0) {
      value += line.ratio * y[std::ranges::find(free_, line.leader) - free_.begin()];
    }
    data_->qpos[m_->jnt_qposadr[line.joint]] = value;
  }
  mj_kinematics(m_, data_.get());
  mj_comPos(m_, data_.get());  // for the Jacobians
}

/// Position of an anchor in the world [m]. @param side  0: anchor on the first body, 1: on the second body
Eigen::Vector3d MjcfLoop::anchor(int side) const {
  const int body = side == 0 ? m_->eq_obj1id[equality_] : m_->eq_obj2id[equality_];
  const Eigen::Map<const Eigen::Vector3d> p_WB(data_->xpos + 3 * body), p_B(m_->eq_data + equality_ * mjNEQDATA + 3 * side);
  return p_WB + Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(data_->xmat + 9 * body) * p_B;
}

/// Derivative of the vector from the second anchor to the first one by the free joints (3 × n).
Eigen::Matrix3Xd MjcfLoop::gap_rates() const {
  using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>;
  Jacobian rates[2] = {Jacobian(3, m_->nv), Jacobian(3, m_->nv)};
  for (const int side : {0, 1}) {
    const Eigen::Vector3d point = anchor(side);
    mj_jac(m_, data_.get(), rates[side].data(), nullptr, point.data(), side == 0 ? m_->eq_obj1id[equality_] : m_->eq_obj2id[equality_]);
  }
  Eigen::Matrix3Xd out = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(free_.size()));
  for (const MjcfCoupling& line : lines_) {
    const auto found = std::ranges::find(free_, line.leader);
    if (found == free_.end()) continue;
    const int v = m_->jnt_dofadr[line.joint];
    out.col(found - free_.begin()) += line.ratio * (rates[0].col(v) - rates[1].col(v));
  }
  return out;
}

/// Minimises ½‖gap‖² + ½ε‖k^½ (y − y_rest)‖² within the joint limits by Gauss–Newton steps. A joint whose step would cross its limit stays at the
/// limit for this step.
bool MjcfLoop::close(double x, Eigen::VectorXd& y) {
  const Eigen::Index n = y.size();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    place(x, y);
    const Eigen::Vector3d gap = anchor(0) - anchor(1);
    const Eigen::Matrix3Xd J = gap_rates();
    const double unit = J.squaredNorm();
    if (unit == 0) return gap.norm() <= kMeet * size_;
    Eigen::MatrixXd H = J.transpose() * J;
    H.diagonal() += kSpring * unit * (stiffness_.array() + kSpring).matrix();
    const Eigen::VectorXd slope = J.transpose() * gap + kSpring * unit * stiffness_.cwiseProduct(y - rest_);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
    std::vector<char> held(at(static_cast<int>(n)), 0);
    for (bool again = true; again;) {
      again = false;
      Eigen::MatrixXd A = H;
      Eigen::VectorXd b = -slope;
      for (Eigen::Index i = 0; i < n; ++i) {
        if (held[static_cast<std::size_t>(i)]) A.row(i).setZero(), A.col(i).setZero(), A(i, i) = 1, b[i] = 0;
      }
      step = A.ldlt().solve(b);
      for (Eigen::Index i = 0; i < n && !again; ++i) {
        const bool outward = (y[i] <= lower_[i] && step[i] < 0) || (y[i] >= upper_[i] && step[i] > 0);
        if (outward && !held[static_cast<std::size_t>(i)]) held[static_cast<std::size_t>(i)] = again = true;
      }
    }
    if (!step.allFinite()) return false;
    step *= std::min(1.0, kMostStep / std::max(step.cwiseAbs().maxCoeff(), 1e-300));
    const Eigen::VectorXd next = (y + step).cwiseMax(lower_).cwiseMin(upper_);
    const double moved = (next - y).cwiseAbs().maxCoeff();
    y = next;
    if (moved < kStill) return gap.norm() <= kMeet * size_;
  }
  place(x, y);
  return (anchor(0) - anchor(1)).norm() <= kMeet * size_;
}

const Eigen::VectorXd& MjcfLoop::solve(double x) {
  const auto known = solved_.find(x);
  if (known != solved_.end()) return known->second;
  const double begin = last_ ? last_->first : m_->qpos0[m_->jnt_qposadr[leader_]];
  const Eigen::VectorXd from = last_ ? last_->second : file_pose();
  Eigen::VectorXd y = from;
  bool closed = false;
  for (int parts = 1; parts <= kMostParts && !closed; parts *= 4) {
    y = from;
    closed = true;
    for (int k = 1; k <= parts && closed; ++k) closed = close(begin + (x - begin) * k / parts, y);
  }
  if (closed) {
    last_ = {x, y};
  } else {
    y.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  return solved_.emplace(x, y).first->second;
}

}  // namespace stiction::world
