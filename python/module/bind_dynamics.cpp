#include <fmt/format.h>

#include "bindings.hpp"
#include "pickles.hpp"
#include "step_arguments.hpp"
#include "stiction/dynamics/local_model.hpp"
#include "stiction/dynamics/rollout.hpp"
#include "watcher.hpp"

namespace stiction::python {

std::vector<StepContact> with_names(const ModelPtr& model, const std::vector<dynamics::ContactImpulse>& contacts, double h) {
  std::vector<StepContact> out;
  out.reserve(contacts.size());
  for (const auto& contact : contacts) out.push_back({model, contact, h});
  return out;
}

namespace {

using dynamics::Sampling;
using dynamics::StepOptions;

/// dynamics::StepWorkspace that two threads cannot use at once.
struct StepWorkspace {
  explicit StepWorkspace(const ModelPtr& model) : work(model) {}
  dynamics::StepWorkspace work;
  std::atomic<bool> busy{false};
};

struct StepResult {
  ModelPtr model;
  double h = 0.1;
  dynamics::StepResult result;
};

struct RolloutResult {
  ModelPtr model;
  double h = 0.1;
  dynamics::RolloutResult result;
};

struct Knot {
  Eigen::VectorXd u, q;
  std::vector<StepContact> contacts;
};

/// The arguments of a step. @throws core::InvalidInput by the name of the argument
dynamics::StepInput step_input(const world::Model& model, const Vector& q, const Vector& u, const std::optional<Vector>& tau_ext,
                               const std::optional<Vector>& damping) {
  world::require_configuration(model, "q", q.named("q"));
  require_vector("u", u, model.n_a());
  dynamics::StepInput in{q.named("q"), u.named("u")};
  if (tau_ext) {
    require_vector("tau_ext", *tau_ext, model.n_v());
    in.tau_ext = &tau_ext->named("tau_ext");
  }
  if (damping) {
    require_vector("damping", *damping, model.n_v());
    in.damping = &damping->named("damping");
  }
  return in;
}

StepResult step(const StepOptions& given, ModelPtr model, Vector q, Vector u, std::optional<Vector> tau_ext, std::optional<Vector> damping,
                Flag with_A, Flag with_B, Flag with_force_derivatives, Flag warm_start, StepWorkspace* workspace) {
  StepOptions options = given;
  options.with_A = with_A;
  options.with_B = with_B;
  options.with_force_derivatives = with_force_derivatives;
  options.warm_start = warm_start;
  StepResult out{model, options.h, {}};
  const dynamics::StepInput in = step_input(*model, q, u, tau_ext, damping);
  const nb::gil_scoped_release unlocked;
  std::optional<StepWorkspace> own;
  if (workspace == nullptr) workspace = &own.emplace(model);
  const Occupied occupied(workspace->busy);
  (void)dynamics::step(*model, in, options, workspace->work, out.result);  // the status is in the result
  return out;
}

dynamics::LocalModel calc_local_model(const StepOptions& options, ModelPtr model, Vector q, Vector u,
                                      std::optional<dynamics::LocalModelScheme> scheme, std::optional<Vector> tau_ext,
                                      std::optional<Vector> damping, Flag with_A, int threads) {
  dynamics::LocalModel out;
  const dynamics::StepInput in = step_input(*model, q, u, tau_ext, damping);
  // The smoothing of the step stands for the scheme where none is given.
  const auto chosen = scheme ? *scheme : std::visit([](const auto& s) { return dynamics::LocalModelScheme(s); }, options.smoothing);
  Interrupt interrupt;
  {
    const nb::gil_scoped_release unlocked;
    dynamics::LocalModelWorkspace work(model, threads);
    (void)dynamics::calc_local_model(*model, in, chosen, options, with_A, work, out, interrupt.control({}));
  }
  interrupt.rethrow();
  return out;
}

RolloutResult rollout(const StepOptions& options, ModelPtr model, Vector q, Vector u_start, Vector u_end, double joint_angle,
                      double joint_travel, double slide, int max_substeps, StepWorkspace* workspace) {
  RolloutResult out{model, options.h, {}};
  const dynamics::SubstepLimits limits{joint_angle, joint_travel, slide, max_substeps};
  world::require_configuration(*model, "q", q.named("q"));
  require_vector("u_start", u_start, model->n_a());
  require_vector("u_end", u_end, model->n_a());
  const nb::gil_scoped_release unlocked;
  std::optional<StepWorkspace> own;
  if (workspace == nullptr) workspace = &own.emplace(model);
  const Occupied occupied(workspace->busy);
  (void)dynamics::rollout(*model, q.named("q"), u_start.named("u_start"), u_end.named("u_end"), options, limits, workspace->work,
                          out.result);
  return out;
}

template <class F>
auto of_impulse(F field) {
  return [field](const StepContact& c) { return c.impulse.*field; };
}

template <class F>
auto of_contact(F field) {
  return [field](const StepContact& c) { return c.impulse.contact.*field; };
}

Eigen::Matrix3d frame(const StepContact& c) {
  Eigen::Matrix3d R;
  R << c.impulse.contact.nhat_BA_W, c.impulse.contact.t1_W, c.impulse.contact.t2_W;
  return R;
}

const world::Pair& pair_of(const StepContact& c) { return c.model->pairs()[static_cast<std::size_t>(c.impulse.contact.pair)]; }

void bind_contact(nb::module_& m) {
  using dynamics::ContactImpulse;
  nb::class_<StepContact>(m, "ContactImpulse",
                          "One contact of a step. Its impulse acts on geometry a, and the opposite impulse on geometry b.")
      .def_prop_ro(
          "a", [](const StepContact& c) { return name_of_geometry(*c.model, pair_of(c).geometry_a); },
          "name of the first geometry, as body/geometry")
      .def_prop_ro(
          "b", [](const StepContact& c) { return name_of_geometry(*c.model, pair_of(c).geometry_b); }, "name of the second geometry")
      .def_prop_ro("pair", of_contact(&contact::Contact::pair), "index into Model.pairs")
      .def_prop_ro("id", of_contact(&contact::Contact::id), "number of the contact, the same from step to step")
      .def_prop_ro("phi", of_contact(&contact::Contact::phi), "signed distance before the step [m]")
      .def_prop_ro("p_WA", of_contact(&contact::Contact::p_WA), "closest point on a, in W [m] (3)")
      .def_prop_ro("p_WB", of_contact(&contact::Contact::p_WB), "closest point on b, in W [m] (3)")
      .def_prop_ro("nhat_BA_W", of_contact(&contact::Contact::nhat_BA_W), "unit normal from b to a, in W (3)")
      .def_prop_ro("t1_W", of_contact(&contact::Contact::t1_W), "first unit tangent, in W (3)")
      .def_prop_ro("t2_W", of_contact(&contact::Contact::t2_W), "second unit tangent, in W (3)")
      .def_prop_ro("friction", of_contact(&contact::Contact::friction), "friction coefficient")
      .def_prop_ro("spin", of_contact(&contact::Contact::spin),
                   "arm of a contact that resists turning [m]: its moment about the normal is spin times the force along t2 (S.26)")
      .def_prop_ro("lambda_", of_impulse(&ContactImpulse::lambda), "impulse along (n, t1, t2) [N s] (3)")
      .def_prop_ro(
          "force", [](const StepContact& c) -> Eigen::Vector3d { return c.impulse.lambda / c.h; }, "force along (n, t1, t2) [N] (3)")
      .def_prop_ro(
          "force_W", [](const StepContact& c) -> Eigen::Vector3d { return frame(c) * c.impulse.lambda / c.h; }, "force in W [N] (3)")
      .def_prop_ro("displacement", of_impulse(&ContactImpulse::displacement),
                   "displacement of a relative to b, J_c δq, along (n, t1, t2) [m] (3)")
      .def_prop_ro("gap", of_impulse(&ContactImpulse::gap), "slack of the contact constraint, φ + J_n δq - μ‖J_t δq‖ [m]")
      .def_prop_ro("active", of_impulse(&ContactImpulse::active), "True: the contact carries a force that counts")
      .def_prop_ro(
          "slide", [](const StepContact& c) { return c.impulse.slide(); }, "sliding distance ‖J_t δq‖ [m]")
      .def_prop_ro(
          "anitescu_gap", [](const StepContact& c) { return c.impulse.anitescu_gap(); }, "distance after the step, φ + J_n δq [m]")
      .def(
          "calc_wrench", [](const StepContact& c) { return Eigen::VectorXd(dynamics::calc_wrench(c.impulse, c.h)); },
          "Returns the force on a and its moment about the world origin, in W [N, N m] (6).")
      .def("__repr__", [](const StepContact& c) {
        const auto& l = c.impulse.lambda;
        return fmt::format("ContactImpulse({} on {}, phi={:.6g}, lambda_=[{:.6g}, {:.6g}, {:.6g}])",
                           name_of_geometry(*c.model, pair_of(c).geometry_b), name_of_geometry(*c.model, pair_of(c).geometry_a),
                           c.impulse.contact.phi, l[0], l[1], l[2]);
      });
}

template <class T, class Get>
Eigen::Matrix<T, Eigen::Dynamic, 1> column(const StepResult& r, Get get) {
  Eigen::Matrix<T, Eigen::Dynamic, 1> out(static_cast<Eigen::Index>(r.result.contacts.size()));
  for (std::size_t i = 0; i < r.result.contacts.size(); ++i) out[static_cast<Eigen::Index>(i)] = get(r.result.contacts[i]);
  return out;
}

std::optional<std::vector<Eigen::MatrixXd>> blocks(const dynamics::ImpulseDerivatives& derivatives) {
  if (derivatives.size() == 0) return std::nullopt;
  std::vector<Eigen::MatrixXd> out;
  for (std::size_t i = 0; i < derivatives.size(); ++i) out.emplace_back(derivatives[i]);
  return out;
}

void bind_results(nb::module_& m) {
  nb::class_<cone::Residuals>(m, "Residuals", "Residuals of the optimality conditions of a step.")
      .def_ro("stationarity", &cone::Residuals::stationarity, "residual of the force balance, relative")
      .def_ro("primal", &cone::Residuals::primal, "residual of the constraint slacks, relative")
      .def_ro("complementarity", &cone::Residuals::complementarity, "largest violation of complementarity")
      .def_ro("cone", &cone::Residuals::cone, "largest distance by which a slack or an impulse leaves its cone");
  nb::class_<StepResult>(m, "StepResult", "Result of step(): the next configuration, the contacts, and derivatives if asked for.")
      .def_prop_ro("status", [](const StepResult& r) { return r.result.status; })
      .def_prop_ro(
          "q_next", [](const StepResult& r) { return r.result.q_next; }, "next configuration (n_q)")
      .def_prop_ro(
          "delta", [](const StepResult& r) { return r.result.delta; }, "displacement δq in tangent coordinates (n_v) [m, rad]")
      .def_prop_ro(
          "torque", [](const StepResult& r) { return r.result.torque; },
          "torques of the joint springs (n_a) [N m, N]; at most Model.effort if effort_limits is set")
      .def_prop_ro(
          "joint_friction", [](const StepResult& r) { return r.result.joint_friction; },
          "friction torques of the objects' hinges and sliders (n_vu) [N m, N]; empty if no joint has friction")
      .def_prop_ro(
          "saturated",
          [](const StepResult& r) {
            Eigen::Matrix<bool, Eigen::Dynamic, 1> out(static_cast<Eigen::Index>(r.result.saturated.size()));
            for (Eigen::Index i = 0; i < out.size(); ++i) out[i] = r.result.saturated[static_cast<std::size_t>(i)] != 0;
            return out;
          },
          "True for each joint whose motor is at its effort limit (n_a)")
      .def_prop_ro(
          "contacts", [](const StepResult& r) { return with_names(r.model, r.result.contacts, r.h); }, "contacts of the step (n_c)")
      .def_prop_ro(
          "phi", [](const StepResult& r) { return column<double>(r, [](const auto& c) { return c.contact.phi; }); },
          "signed distances before the step [m] (n_c)")
      .def_prop_ro(
          "gap", [](const StepResult& r) { return column<double>(r, [](const auto& c) { return c.gap; }); },
          "slacks of the contact constraints [m] (n_c)")
      .def_prop_ro(
          "active", [](const StepResult& r) { return column<bool>(r, [](const auto& c) { return c.active; }); },
          "True for each contact that carries a force (n_c)")
      .def_prop_ro(
          "lambda_",
          [](const StepResult& r) {
            Eigen::MatrixXd out(static_cast<Eigen::Index>(r.result.contacts.size()), 3);
            for (Eigen::Index i = 0; i < out.rows(); ++i) out.row(i) = r.result.contacts[static_cast<std::size_t>(i)].lambda;
            return out;
          },
          "impulses along (n, t1, t2) [N s] (n_c, 3)")
      .def_prop_ro(
          "A", [](const StepResult& r) { return unless_empty(r.result.A); },
          "derivative of q_next by q (n_v, n_v); None unless with_A was set")
      .def_prop_ro(
          "B", [](const StepResult& r) { return unless_empty(r.result.B); },
          "derivative of q_next by u (n_v, n_a); None unless with_B was set")
      .def_prop_ro(
          "D_lambda_q", [](const StepResult& r) { return blocks(r.result.D_lambda_q); },
          "derivative of each impulse by q, a list of (3, n_v); None unless with_force_derivatives and with_A were set")
      .def_prop_ro(
          "D_lambda_u", [](const StepResult& r) { return blocks(r.result.D_lambda_u); },
          "derivative of each impulse by u, a list of (3, n_a); None unless with_force_derivatives and with_B were set")
      .def_prop_ro(
          "epsilon", [](const StepResult& r) { return r.result.epsilon; }, "regularisation that was used for each object")
      .def_prop_ro(
          "residuals", [](const StepResult& r) { return r.result.residuals; }, "residuals of the optimality conditions")
      .def_prop_ro(
          "iterations", [](const StepResult& r) { return r.result.iterations; }, "number of solver iterations")
      .def_ro("h", &StepResult::h, "time step [s]")
      .def("__repr__", [](const StepResult& r) {
        return fmt::format("<stiction.StepResult: {}, {} contacts, {} iterations>", core::to_string(r.result.status),
                           r.result.contacts.size(), r.result.iterations);
      });
  nb::class_<dynamics::LocalModel>(m, "LocalModel", "Linear model of a step: q_next(q ⊕ δq, u + δu) ≈ c ⊕ (A δq + B δu).")
      .def_ro("status", &dynamics::LocalModel::status)
      .def_ro("c", &dynamics::LocalModel::c, "next configuration, smoothed by the scheme (n_q)")
      .def_prop_ro(
          "A", [](const dynamics::LocalModel& l) { return unless_empty(l.A); }, "derivative by q (n_v, n_v); None unless with_A was set")
      .def_ro("B", &dynamics::LocalModel::B, "derivative by u (n_v, n_a)")
      .def_ro("failed", &dynamics::LocalModel::failed, "number of samples whose step had no solution; they are left out");
  nb::class_<Knot>(m, "Knot", "State after one sub-step of rollout().")
      .def_ro("u", &Knot::u, "command (n_a) [m or rad]")
      .def_ro("q", &Knot::q, "configuration (n_q)")
      .def_ro("contacts", &Knot::contacts, "active contacts");
  nb::class_<RolloutResult>(m, "RolloutResult", "Result of rollout(): the states after its sub-steps.")
      .def_prop_ro("status", [](const RolloutResult& r) { return r.result.status; })
      .def_prop_ro(
          "knots",
          [](const RolloutResult& r) {
            std::vector<Knot> out;
            for (const auto& knot : r.result.knots) out.push_back({knot.u, knot.q, with_names(r.model, knot.contacts, r.h)});
            return out;
          },
          "states after the sub-steps")
      .def_prop_ro(
          "steps", [](const RolloutResult& r) { return r.result.steps; }, "number of steps that were computed")
      .def_prop_ro(
          "max_slide", [](const RolloutResult& r) { return r.result.max_slide; },
          "largest mu * slip of an active contact in a sub-step [m]")
      .def_prop_ro(
          "min_phi", [](const RolloutResult& r) { return r.result.min_phi; }, "smallest signed distance [m]; negative: penetration");
}

template <class Scheme>
void bind_sampling(nb::module_& m, const char* name, const char* doc) {
  const Sampling standard;
  nb::class_<Scheme>(m, name, doc)
      .def(
          "__init__",
          [](Scheme* self, const Vector& std_q, const Vector& std_u, int samples, std::uint64_t seed) {
            new (self) Scheme{{std_q.named("std_q"), std_u.named("std_u"), samples, seed}};
          },
          nb::kw_only(), "std_q"_a, "std_u"_a, "samples"_a = standard.samples, "seed"_a = standard.seed,
          R"(A scheme that samples configurations and commands from a normal distribution.

  std_q: standard deviations of q in tangent coordinates [m, rad], >= 0: (n_v), or (1) for all.
  std_u: standard deviations of u [m or rad], >= 0: (n_a), or (1) for all.
  samples: number of samples, >= 1.
  seed: of the samples.)")
      .def_ro("std_q", &Scheme::std_q, "standard deviations of q [m, rad]")
      .def_ro("std_u", &Scheme::std_u, "standard deviations of u [m or rad]")
      .def_ro("samples", &Scheme::samples, "number of samples")
      .def_ro("seed", &Scheme::seed, "seed of the samples");
}

/// An alternative with one number, `name`.
template <class T, class Number>
void bind_number(nb::module_& m, const char* type, const char* name, Number T::*field, const char* doc) {
  nb::class_<T>(m, type, doc)
      .def(
          "__init__",
          [field](T* self, Number value) {
            new (self) T{};
            self->*field = value;
          },
          nb::kw_only(), nb::arg(name) = T{}.*field)
      .def_ro(name, field)
      .def("__repr__", [type, name, field](const T& self) { return fmt::format("{}({}={})", type, name, self.*field); });
}

void bind_step_options(nb::module_& m) {
  using dynamics::FrictionLaw;
  bind_number(m, "ByRule", "ratio", &dynamics::ByRule::ratio,
              "Regularisation of the objects as a ratio to the stiffness of the joint springs, > 0 (docs/theory/step.md).");
  bind_number(m, "FixedEpsilon", "epsilon", &dynamics::FixedEpsilon::epsilon,
              "Regularisation of the objects as a factor epsilon of their mass matrix (2.6c), > 0; 1: the true mass.");
  nb::class_<dynamics::SecondOrderCone>(m, "SecondOrderCone", "Exact friction cone. In planar models two rays represent it exactly.")
      .def(nb::init<>())
      .def("__repr__", [](const dynamics::SecondOrderCone&) { return "SecondOrderCone()"; });
  bind_number(m, "PolyhedralCone", "rays", &dynamics::PolyhedralCone::rays,
              "Friction pyramid with this number of rays, in [3, 64], inside the friction cone.");
  nb::enum_<FrictionLaw>(m, "FrictionLaw", "Law of sliding contacts.")
      .value("Anitescu", FrictionLaw::Anitescu, "convex relaxation: a sliding contact opens by mu |J_t dq| (2.3.4)")
      .value("Coulomb", FrictionLaw::Coulomb,
             "a sliding contact stays closed (S.14); only in exact steps of spatial models with second-order cones");
}

void bind_schemes(nb::module_& m) {
  const dynamics::Analytic standard;
  nb::class_<dynamics::Exact>(m, "Exact", "Contact dynamics without smoothing (2.6).")
      .def(nb::init<>())
      .def("__repr__", [](const dynamics::Exact&) { return "Exact()"; });
  nb::class_<dynamics::Analytic>(m, "Analytic",
                                 R"(Contact dynamics that are smoothed by a log barrier (2.27).

kappa is the weight of the barrier [1/J], > 0; larger values are closer to Exact. Contacts among robot parts and fixed bodies have the
weight self_sharpness * kappa, and joint limits have limit_sharpness * kappa.)")
      .def(
          "__init__",
          [](dynamics::Analytic* self, double kappa, double self_sharpness, double limit_sharpness) {
            new (self) dynamics::Analytic{kappa, self_sharpness, limit_sharpness};
          },
          nb::kw_only(), "kappa"_a = standard.kappa, "self_sharpness"_a = standard.self_sharpness,
          "limit_sharpness"_a = standard.limit_sharpness)
      .def_ro("kappa", &dynamics::Analytic::kappa, "weight of the barrier [1/J]")
      .def_ro("self_sharpness", &dynamics::Analytic::self_sharpness, "factor of kappa for contacts among robot parts and fixed bodies")
      .def_ro("limit_sharpness", &dynamics::Analytic::limit_sharpness, "factor of kappa for joint limits")
      .def("__repr__", [](const dynamics::Analytic& a) {
        return fmt::format("Analytic(kappa={}, self_sharpness={}, limit_sharpness={})", a.kappa, a.self_sharpness, a.limit_sharpness);
      });
  bind_sampling<dynamics::RandomizedFirstOrder>(m, "RandomizedFirstOrder",
                                                "Smoothing by the average of exact steps and their derivatives at random samples (2.22).");
  bind_sampling<dynamics::RandomizedZerothOrder>(m, "RandomizedZerothOrder",
                                                 "Smoothing by a least-squares fit to exact steps at random samples (2.23).");
}

}  // namespace

void bind_dynamics(nb::module_& m) {
  bind_contact(m);
  bind_results(m);
  bind_schemes(m);
  bind_step_options(m);
  nb::class_<StepWorkspace>(m, "StepWorkspace",
                            "Memory and warm starts that several calls of step() or rollout() share. Only one thread may use it at a time.")
      .def(nb::init<const ModelPtr&>(), "model"_a)
      .def(
          "forget",
          [](StepWorkspace& self) {
            const Occupied occupied(self.busy);
            self.work.forget();
          },
          "Drops the warm starts, so that the next step depends only on its arguments.");

  const dynamics::SubstepLimits limits;
  def_with_step_options(m, "step", &step,
                        R"(Computes one quasi-static step of robots and objects (2.6).

The robot joints are springs that pull towards the command u. The step finds the next configuration, in which spring forces, gravity and
contact forces are in balance. Use it to simulate contact without inertia, or to get its derivatives.

  model: Model of the scene.

  q: configuration (n_q): objects first, quaternions of length 1.
  u: commanded joint positions (n_a) [m or rad].
  tau_ext: external generalised forces besides gravity (n_v) [N, N m]; None: 0.
  damping: coefficients of a viscous force -damping dq/h on each coordinate (n_v) [N s/m, N m s/rad], >= 0; None: 0.
  with_A, with_B: also compute the derivatives StepResult.A and StepResult.B.
  with_force_derivatives: also compute StepResult.D_lambda_q (with with_A) and StepResult.D_lambda_u (with with_B).
  warm_start: start the solver from the previous step in the workspace.
  workspace: StepWorkspace to share memory between calls; only one thread may use it at a time. None: a new one for this call.

Returns a StepResult. Its status is Solved; MaxIterations; Infeasible: bodies overlap, and no motion within reach separates them; or
NumericalFailure.

    >>> task = st.load_task("planar_pushing")
    >>> result = st.step(task.model, task.q_start, [0.0, 0.1], h=0.1, smoothing=st.Analytic(kappa=100), with_B=True)
    >>> result.status, result.q_next.shape, result.B.shape
    (Status.Solved, (5,), (5, 2)))",
                        "model"_a, "q"_a, "u"_a, nb::kw_only(), "tau_ext"_a = nb::none(), "damping"_a = nb::none(), "with_A"_a = false,
                        "with_B"_a = false, "with_force_derivatives"_a = false, "warm_start"_a = true, "workspace"_a = nb::none());
  def_with_step_options(
      m, "calc_local_model", &calc_local_model,
      R"(Linearises a step around a configuration and a command (2.4.1): q_next(q + dq, u + du) ~ c + (A dq + B du) in tangent coordinates.

  q: configuration (n_q). u: command (n_a) [m or rad].
  scheme: Exact, Analytic, RandomizedFirstOrder or RandomizedZerothOrder. None: the argument `smoothing`.
  tau_ext, damping: as in step() (n_v).
  with_A: also compute LocalModel.A.
  threads: number of threads for randomised schemes. The result does not depend on it.

Returns a LocalModel. Its status is Solved, or the status of the step that failed. A randomised scheme leaves failed samples out and counts
them in LocalModel.failed.

    >>> task = st.load_task("planar_pushing")
    >>> local = st.calc_local_model(task.model, task.q_start, task.q_start[3:], scheme=st.Analytic(kappa=100), with_A=True)
    >>> local.A.shape, local.B.shape, local.failed
    ((5, 5), (5, 2), 0))",
      "model"_a, "q"_a, "u"_a, nb::kw_only(), "scheme"_a = nb::none(), "tau_ext"_a = nb::none(), "damping"_a = nb::none(),
      "with_A"_a = false, "threads"_a = 1);
  def_with_step_options(m, "rollout", &rollout,
                        R"(Simulates a straight motion of the command from u_start to u_end in small exact steps, from the configuration q.

  q: configuration at the start (n_q).
  u_start, u_end: commands (n_a) [m or rad].
  joint_angle, joint_travel: largest change of a command in a sub-step, for revolute [rad] and prismatic [m] joints, > 0.
  slide: largest mu * slip of an active contact in a sub-step [m], > 0. The sub-steps are made smaller for it as far as max_substeps allows.
  max_substeps: largest number of sub-steps, >= 1.
  workspace: StepWorkspace to share memory between calls; only one thread may use it at a time. None: a new one for this call.

Returns a RolloutResult. Its status is Solved, or the status of the sub-step that failed; the knots before that sub-step are kept.

    >>> task = st.load_task("planar_pushing")
    >>> path = st.rollout(task.model, task.q_start, [0.0, 0.0], [0.0, 0.1], joint_travel=0.01)
    >>> path.status, len(path.knots)
    (Status.Solved, 10))",
                        "model"_a, "q"_a, "u_start"_a, "u_end"_a, nb::kw_only(), "joint_angle"_a = limits.joint_angle,
                        "joint_travel"_a = limits.joint_travel, "slide"_a = limits.slide, "max_substeps"_a = limits.max_substeps,
                        "workspace"_a = nb::none());
  def_pickle<StepContact, cone::Residuals, StepResult, dynamics::LocalModel, Knot, RolloutResult>();
  def_pickle<dynamics::Exact, dynamics::Analytic, dynamics::RandomizedFirstOrder, dynamics::RandomizedZerothOrder, dynamics::ByRule,
             dynamics::FixedEpsilon, dynamics::SecondOrderCone, dynamics::PolyhedralCone>();
  def_no_pickle<StepWorkspace>("StepWorkspace", "a workspace made from the model in each process");
}

}  // namespace stiction::python
