#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <optional>

#include "contact/features.hpp"
#include "dynamics/systems.hpp"

// A, B and the derivatives of the impulses of a step against differences through retract.

namespace stiction::dynamics::test {

inline constexpr int kStates = 100;
inline constexpr double kTolerance = 1e-6;  // of the largest entry
inline constexpr double kStep = 2e-5;       // of the differences: 1/100 of the smallest gap, around which sharp features turn [m, rad]
inline constexpr double kReach = 5e-4;      // features and the set of rows stay the same this far in every coordinate [m, rad]

/// What a step gives, as one vector in the tangent space at q_next followed by all impulses.
struct Outcome {
  bool solved = false;
  Eigen::VectorXd q_next, impulses;
  std::vector<std::uint64_t> rows;  // contacts in the program
  std::vector<int> features;        // of their witness points
  std::vector<int> motions;         // of an exact step: 0 open, 1 sticking, 2 sliding; and joints
  std::vector<int> motors;          // which springs saturate, and to which side joints with friction slide
  bool clear = false, clear_motors = true;
  bool steady_frames = true;
};

class System {
 public:
  System(std::shared_ptr<const world::Model> m, const StepOptions& o) : model(std::move(m)), options(o), work(model) {}

  Outcome outcome(const Eigen::VectorXd& q, const Eigen::VectorXd& u, bool with_features = false) {
    Outcome out;
    work.forget();
    out.solved = step(*model, {q, u, nullptr, damping.size() > 0 ? &damping : nullptr}, options, work, result) == core::Status::Solved;
    if (!out.solved) return out;
    out.q_next = result.q_next;
    if (exact()) judge(u, out);
    for (int j = 0; j < model->n_a(); ++j) {
      const double share = std::abs(model->stiffness()[j] * (u[j] - result.q_next[model->n_qu() + j])) / model->effort()[j];
      out.motors.push_back(result.saturated[static_cast<std::size_t>(j)]);
      if (options.effort_limits && share > 0.9 && share < 1.1) out.clear_motors = false;
    }
    for (Eigen::Index v = 0; v < result.joint_friction.size(); ++v) {
      const double friction = model->dofs()[static_cast<std::size_t>(v)].friction, force = result.joint_friction[v];
      if (friction == 0) continue;
      const bool slides = std::abs(force) > (1 - 1e-4) * friction;
      out.motors.push_back(!slides ? 0 : force < 0 ? 1 : -1);
      if (!slides && std::abs(force) > 0.9 * friction) out.clear_motors = false;
    }
    out.impulses.resize(3 * static_cast<Eigen::Index>(result.contacts.size()));
    if (with_features) world::calc_kinematics(*model, q, kinematics_work, kinematics);
    for (std::size_t i = 0; i < result.contacts.size(); ++i) {
      const ContactImpulse& c = result.contacts[i];
      out.impulses.segment<3>(3 * static_cast<Eigen::Index>(i)) = c.lambda;
      if (c.lambda.isZero(0)) continue;
      // The components of λ turn with the frame (4), which spins by up to 1/(1 + n_z) against the normal.
      if (!model->planar_axis() && c.contact.nhat_BA_W.z() < -0.9) out.steady_frames = false;
      out.rows.push_back(c.contact.id);
      if (with_features)
        out.features.insert(out.features.end(),
                            {feature(c.contact), static_cast<int>(c.contact.kind), static_cast<int>(c.contact.reference)});
    }
    return out;
  }

  int feature(const contact::Contact& c) const {
    const auto one = [&](int index, const Eigen::Vector3d& p, const Eigen::Vector3d& m) {
      const world::Geometry& g = model->geometries()[static_cast<std::size_t>(index)];
      return contact::test::find_feature(g.shape, kinematics.X_WB[static_cast<std::size_t>(g.body)] * g.X_BG, p, m);
    };
    const world::Pair& pair = model->pairs()[static_cast<std::size_t>(c.pair)];
    return 10000 * one(pair.geometry_a, c.p_WA, -c.nhat_BA_W) + one(pair.geometry_b, c.p_WB, c.nhat_BA_W);
  }

  Eigen::VectorXd moved(const Eigen::VectorXd& q, Eigen::Index j, double by) const {
    Eigen::VectorXd out(model->n_q());
    world::retract(*model, q, by * Eigen::VectorXd::Unit(model->n_v(), j), out);
    return out;
  }

  /// The same rows act on the same features up to kReach away in every coordinate; an exact step also keeps what each contact does.
  bool smooth(const Eigen::VectorXd& q, const Eigen::VectorXd& u) {
    const Outcome here = outcome(q, u, true);
    if (!here.solved || !here.steady_frames || !here.clear_motors || (exact() && !here.clear)) return false;
    for (int j = 0; j < model->n_v(); ++j) {
      for (const double by : {-kReach, kReach}) {
        const Outcome there = outcome(moved(q, j, by), u, true);
        if (!there.solved || there.rows != here.rows || there.motors != here.motors || there.features != here.features) return false;
        if (exact() && (!there.clear || there.motions != here.motions)) return false;
      }
    }
    return true;
  }

  /// Derivatives of q_next and of the impulses by q (or by u) from differences of sixth order.
  bool differences(const Eigen::VectorXd& q, const Eigen::VectorXd& u, bool by_u, double step_size, Eigen::MatrixXd& D,
                   Eigen::MatrixXd& D_impulse) {
    const Outcome here = outcome(q, u);
    const int n = by_u ? model->n_a() : model->n_v();
    D.setZero(model->n_v(), n);
    D_impulse.setZero(here.impulses.size(), n);
    Eigen::VectorXd e(model->n_v());
    for (Eigen::Index j = 0; j < n; ++j) {
      for (const auto& [offset, weight] : {std::pair{-3, -1.0}, {-2, 9.0}, {-1, -45.0}, {1, 45.0}, {2, -9.0}, {3, 1.0}}) {
        const double by = offset * step_size;
        const Outcome there = by_u ? outcome(q, u + by * Eigen::VectorXd::Unit(n, j)) : outcome(moved(q, j, by), u);
        if (!there.solved || there.impulses.size() != here.impulses.size()) return false;
        world::local(*model, here.q_next, there.q_next, e);
        D.col(j) += weight / (60 * step_size) * e;
        D_impulse.col(j) += weight / (60 * step_size) * there.impulses;
      }
    }
    return true;
  }

  bool exact() const { return std::holds_alternative<Exact>(options.smoothing); }

  /// What every contact and joint does, and whether that is clear: open, sticking or sliding by a margin, on its limit or not.
  void judge(const Eigen::VectorXd& u, Outcome& out) const {
    out.clear = true;
    for (const auto& c : result.contacts) {
      const double force = c.lambda[0] / options.h;
      const double reserve = c.contact.friction * force - c.lambda.tail<2>().norm() / options.h;
      const bool open = force < 1e-3 && c.gap > 4e-4;
      const bool sticking = force > 0.3 && reserve > 0.3 && c.slide() < 1e-6;
      const bool sliding = force > 0.3 && reserve < 1e-3 && c.slide() > 4e-4;
      out.clear = out.clear && (open || sticking || sliding);
      out.motions.push_back(open ? 0 : sticking ? 1 : 2);
    }
    for (int j = 0; j < model->n_a(); ++j) {
      const double q = result.q_next[model->n_qu() + j];
      const bool pressed = u[j] < model->lower()[j] - 1e-3 || u[j] > model->upper()[j] + 1e-3;
      out.clear = out.clear && (pressed || std::min(q - model->lower()[j], model->upper()[j] - q) > 1e-3);
      out.motions.push_back(pressed);
    }
  }

  std::shared_ptr<const world::Model> model;
  StepOptions options;
  Eigen::VectorXd damping;
  StepWorkspace work;
  StepResult result;
  world::KinematicsWorkspace kinematics_work{*model};
  world::Kinematics kinematics;
};

inline double largest(const Eigen::MatrixXd& m) { return m.size() == 0 ? 0.0 : m.cwiseAbs().maxCoeff(); }

inline Eigen::MatrixXd stack(const ImpulseDerivatives& D, Eigen::Index columns) {
  Eigen::MatrixXd out(3 * static_cast<Eigen::Index>(D.size()), columns);
  for (std::size_t i = 0; i < D.size(); ++i) out.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = D[i];
  return out;
}

/// log2 of the error of a second-order difference along a direction over that at half its step; 0 where it is small: the solver's own
/// accuracy, about 1e-11 in q_next, decides there.
inline double calc_order(System& s, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const Eigen::VectorXd& direction) {
  const Outcome here = s.outcome(q, u);
  const Eigen::VectorXd want = s.result.A * direction;
  double error[2];
  for (const int k : {0, 1}) {
    const double by = k ? 1.5e-4 : 3e-4;
    Eigen::VectorXd q_moved(q.size()), above(want.size()), below(want.size());
    for (const double sign : {-1.0, 1.0}) {
      world::retract(*s.model, q, sign * by * direction, q_moved);
      world::local(*s.model, here.q_next, s.outcome(q_moved, u).q_next, sign < 0 ? below : above);
    }
    error[k] = ((above - below) / (2 * by) - want).norm();
  }
  return error[1] > 1e-6 * want.norm() ? std::log2(error[0] / error[1]) : 0;
}

struct Errors {
  double A = 0, B = 0, lambda_q = 0, lambda_u = 0;
};

/// Relative errors at q, u; nothing where a difference cannot be taken.
inline std::optional<Errors> compare(System& s, const Eigen::VectorXd& q, const Eigen::VectorXd& u, double step_size) {
  Eigen::MatrixXd A_fd, B_fd, Lq_fd, Lu_fd;
  if (!s.differences(q, u, false, step_size, A_fd, Lq_fd) || !s.differences(q, u, true, step_size, B_fd, Lu_fd)) return std::nullopt;
  if (!s.outcome(q, u).solved) return std::nullopt;
  const StepResult& r = s.result;
  const auto error = [](const Eigen::MatrixXd& got, const Eigen::MatrixXd& want) {
    return largest(got - want) / std::max(largest(want), 0.1);
  };
  return Errors{error(r.A, A_fd), error(r.B, B_fd), error(stack(r.D_lambda_q, s.model->n_v()), Lq_fd),
                error(stack(r.D_lambda_u, s.model->n_a()), Lu_fd)};
}

inline void expect_small(const Errors& e, int attempt) {
  EXPECT_LE(e.A, kTolerance) << "#" << attempt;
  EXPECT_LE(e.B, kTolerance) << "#" << attempt;
  EXPECT_LE(e.lambda_q, kTolerance) << "#" << attempt;
  EXPECT_LE(e.lambda_u, kTolerance) << "#" << attempt;
}

}  // namespace stiction::dynamics::test
