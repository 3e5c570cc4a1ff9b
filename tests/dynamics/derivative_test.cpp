#include <Eigen/Geometry>

#include "dynamics/systems.hpp"
#include "stiction/world/scales.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using world::Model;

constexpr int kStates = 200;

/// Fourth-order central difference of q_next in its own tangent.
bool central_difference(const Model& model, const Eigen::VectorXd& q, const Eigen::VectorXd& u, const StepOptions& options,
                        double step_size, StepWorkspace& work, const Eigen::VectorXd& q_next, Eigen::MatrixXd& B) {
  B.resize(model.n_v(), model.n_a());
  StepResult r;
  Eigen::VectorXd e(model.n_v());
  for (int j = 0; j < model.n_a(); ++j) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(model.n_v());
    for (const auto& [offset, weight] : {std::pair{-2.0, 1.0}, std::pair{-1.0, -8.0}, std::pair{1.0, 8.0}, std::pair{2.0, -1.0}}) {
      Eigen::VectorXd u_moved = u;
      u_moved[j] += offset * step_size;
      work.forget();
      if (step(model, {q, u_moved}, options, work, r) != Status::Solved) return false;
      world::local(model, q_next, r.q_next, e);
      sum += weight * e;
    }
    B.col(j) = sum / (12 * step_size);
  }
  return true;
}

/// Every contact is clearly open, clearly sticking or clearly sliding, and every joint clearly off or on its limit. The stiffness that an open row
/// is left with, z/w, falls with the square of its gap.
bool away_from_kinks(const Model& model, const StepOptions& options, const Eigen::VectorXd& u, const StepResult& r) {
  for (const auto& c : r.contacts) {
    const double mu = c.contact.friction;
    const double force = c.lambda[0] / options.h;  // [N]
    const double reserve = mu * force - c.lambda.tail<2>().norm() / options.h;
    const bool open = force < 1e-3 && c.gap > 4e-3 * model.scales().pair(c.contact.pair).length;
    const bool sticking = force > 0.3 && reserve > 0.3 && c.slide() < 1e-6;
    const bool sliding = force > 0.3 && reserve < 1e-3 && c.slide() > 4e-4;
    if (!open && !sticking && !sliding) return false;
  }
  for (int j = 0; j < model.n_a(); ++j) {
    const double q = r.q_next[model.n_qu() + j];
    const double room = std::min(q - model.lower()[j], model.upper()[j] - q);
    const bool pressed = u[j] < model.lower()[j] - 1e-3 || u[j] > model.upper()[j] + 1e-3;
    if (room < 1e-3 && !pressed) return false;
  }
  return true;
}

class InputDerivative : public testing::TestWithParam<const char*> {};

TEST_P(InputDerivative, Smoothed_MatchesCentralDifferences) {
  const auto model = load_task(GetParam());
  StepWorkspace work(model);
  core::Random random(11, 0);
  StepOptions options{.smoothing = Analytic{}, .with_B = true};
  double worst = 0, largest_object_row = 0;
  int states = 0;
  for (int attempt = 0; attempt < 3 * kStates && states < kStates; ++attempt) {
    const Eigen::VectorXd q = sample_task(GetParam(), *model, random);
    Eigen::VectorXd u = q.tail(model->n_a());
    for (Eigen::Index j = 0; j < u.size(); ++j) u[j] += 0.02 * random.normal();
    StepResult r;
    work.forget();
    if (step(*model, {q, u}, options, work, r) != Status::Solved) continue;  // starts that penetrate deeper than a barrier allows
    ++states;
    Eigen::MatrixXd B_fd;
    ASSERT_TRUE(central_difference(*model, q, u, options, 1e-5, work, r.q_next, B_fd));
    worst = std::max(worst, (r.B - B_fd).cwiseAbs().maxCoeff() / r.B.cwiseAbs().maxCoeff());
    largest_object_row = std::max(largest_object_row, r.B.topRows(model->n_vu()).cwiseAbs().maxCoeff());
  }
  EXPECT_EQ(states, kStates);
  EXPECT_GT(largest_object_row, 0.01) << "the robot never moved the object: the test would say nothing";
  EXPECT_LE(worst, 1e-6);
  RecordProperty("worst", std::to_string(worst));
}

TEST_P(InputDerivative, Exact_MatchesCentralDifferencesAwayFromKinks) {
  const auto model = load_task(GetParam());
  StepWorkspace work(model);
  core::Random random(12, 0);
  StepOptions options{.with_B = true};
  double worst = 0, largest_object_row = 0;
  int states = 0, attempts = 0;
  for (; attempts < 200 * kStates && states < kStates; ++attempts) {
    const Eigen::VectorXd q = sample_task(GetParam(), *model, random);
    Eigen::VectorXd u = q.tail(model->n_a());
    for (Eigen::Index j = 0; j < u.size(); ++j) u[j] += 0.03 * random.normal();
    StepResult r;
    work.forget();
    if (step(*model, {q, u}, options, work, r) != Status::Solved || !away_from_kinks(*model, options, u, r)) continue;
    ++states;
    Eigen::MatrixXd B_fd;
    // stationarity 1e-8 leaves about 1e-10 in q_next: a step of 3e-5 keeps that below 1e-5 of B
    ASSERT_TRUE(central_difference(*model, q, u, options, 3e-5, work, r.q_next, B_fd));
    const double error = (r.B - B_fd).cwiseAbs().maxCoeff() / r.B.cwiseAbs().maxCoeff();
    worst = std::max(worst, error);
    largest_object_row = std::max(largest_object_row, r.B.topRows(model->n_vu()).cwiseAbs().maxCoeff());
  }
  EXPECT_EQ(states, kStates) << "of " << attempts << " attempts";
  EXPECT_GT(largest_object_row, 0.01) << "the robot never moved the object: the test would say nothing";
  EXPECT_LE(worst, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Tasks, InputDerivative, testing::Values("planar_pushing", "planar_hand", "allegro_ball"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace stiction::dynamics::test
