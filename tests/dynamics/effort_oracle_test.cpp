// Independent oracle of (S.15): planar steps as a quadratic program with the slack of every spring written out, by ProxQP.
#include "dynamics/systems.hpp"
#include "proxqp.hpp"

namespace stiction::dynamics::test {
namespace {

using core::Status;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using world::Model;

/// min ½xᵀPx + gᵀx subject to Cx ≥ l, over x = (δq, s⁺, s⁻) with ½hK(u − qᵃ − δqᵃ − s⁺ + s⁻)² + hτ(s⁺ + s⁻) for every joint.
struct SlackProgram {
  SlackProgram(const Model& model, const VectorXd& q, const VectorXd& u, double h, const StepResult& step)
      : P(MatrixXd::Zero(n(model), n(model))), g(VectorXd::Zero(n(model))) {
    world::KinematicsWorkspace work(model);
    world::Kinematics kinematics;
    world::calc_kinematics(model, q, work, kinematics);
    VectorXd tau(model.n_vu());
    world::calc_gravity(model, kinematics, tau);
    g.head(model.n_vu()) = -h * tau;
    for (std::size_t o = 0; o < model.objects().size(); ++o) {
      const auto& object = model.objects()[o];
      MatrixXd M(object.n_v, object.n_v);
      world::calc_object_mass(model, kinematics, static_cast<int>(o), M);
      P.block(object.v_begin, object.v_begin, object.n_v, object.n_v) = step.epsilon[static_cast<Eigen::Index>(o)] / h * M;
    }
    for (int j = 0; j < model.n_a(); ++j) {
      const int x[3] = {model.n_vu() + j, model.n_v() + j, model.n_v() + model.n_a() + j};  // δq, s⁺, s⁻
      const double sign[3] = {1, 1, -1}, K = model.stiffness()[j], stretch = u[j] - q[model.n_qu() + j];
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) P(x[a], x[b]) += h * K * sign[a] * sign[b];
        g[x[a]] -= h * K * sign[a] * stretch;
      }
      g[x[1]] += h * model.effort()[j];
      g[x[2]] += h * model.effort()[j];
    }
    const auto contacts = static_cast<Eigen::Index>(step.contacts.size());
    C = MatrixXd::Zero(2 * contacts + 2 * model.n_a(), P.rows());
    l = VectorXd::Zero(C.rows());
    Eigen::Index row = 0;
    for (const auto& c : step.contacts) {
      const auto& variables = model.supports()[static_cast<std::size_t>(model.pairs()[static_cast<std::size_t>(c.contact.pair)].support)];
      const auto k = static_cast<Eigen::Index>(variables.size());
      Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor> J(3, k);
      contact::calc_jacobian(model, kinematics, c.contact, J.data());
      for (const double side : {1.0, -1.0}) {
        for (Eigen::Index i = 0; i < k; ++i) C(row, variables[static_cast<std::size_t>(i)]) = J(0, i) + side * c.contact.friction * J(1, i);
        l[row++] = -c.contact.phi;
      }
    }
    C.bottomRightCorner(2 * model.n_a(), 2 * model.n_a()).setIdentity();
  }

  static Eigen::Index n(const Model& model) { return model.n_v() + 2 * model.n_a(); }

  MatrixXd P, C;
  VectorXd g, l;
};

TEST(EffortOracle, PlanarSteps_AgreeWithSlacksInProxQp) {
  const auto plain = load_task("planar_hand");
  world::Scene scene = plain->scene();
  core::Random random(11, 0);
  for (auto& robot : scene.robots) robot.effort.clear();
  for (int j = 0; j < plain->n_a(); ++j) {
    const world::Dof& dof = plain->dofs()[static_cast<std::size_t>(plain->n_vu() + j)];
    scene.robots[static_cast<std::size_t>(dof.owner)].effort.emplace_back(dof.name.substr(dof.name.find('/') + 1),
                                                                          dof.stiffness * random.uniform(0.005, 0.05));
  }
  const auto model = Model::make(scene);
  StepWorkspace work(model);
  int compared = 0, saturated = 0;
  for (int attempt = 0; attempt < 200; ++attempt) {
    const VectorXd q = sample_task("planar_hand", *model, random);
    VectorXd u = q.tail(model->n_a());
    for (double& x : u) x += 0.2 * random.normal();
    StepResult r;
    const StepOptions options{.joint_limits = false, .effort_limits = true};
    if (step(*model, {q, u}, options, work, r) != Status::Solved) continue;
    const SlackProgram program(*model, q, u, options.h, r);
    const auto minimiser = bench::minimise_by_proxqp(
        {.H = program.P, .g = program.g, .C = program.C, .lower = program.l, .upper = VectorXd::Constant(program.C.rows(), 1e20)},
        {.residual = 1e-11});
    if (!minimiser) continue;
    const VectorXd& x = *minimiser;
    ++compared;
    for (const char s : r.saturated) saturated += s;
    // Both are off by the root of their gap over the curvature (docs/theory/cone.md, §5).
    EXPECT_LE((r.delta - x.head(model->n_v())).lpNorm<Eigen::Infinity>(), 2e-5) << attempt;
    for (int j = 0; j < model->n_a(); ++j) {
      const Eigen::Index s = model->n_v() + j;
      const double stretch = u[j] - q[model->n_qu() + j] - x[model->n_vu() + j];
      const double torque = model->stiffness()[j] * (stretch - x[s] + x[s + model->n_a()]);
      EXPECT_NEAR(r.torque[j], torque, 1e-4 * model->stiffness()[j]) << attempt;
    }
  }
  EXPECT_GT(compared, 100);
  EXPECT_GT(saturated, 100);
}

}  // namespace
}  // namespace stiction::dynamics::test
