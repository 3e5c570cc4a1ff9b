#include <fmt/format.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/unique_ptr.h>

#include "pickles.hpp"
#include "step_arguments.hpp"
#include "stiction/dynamics/disturbances.hpp"
#include "stiction/dynamics/rollout_batch.hpp"
#include "watcher.hpp"

namespace stiction::python {
namespace {

using Cube = nb::ndarray<nb::numpy, const double, nb::ndim<3>>;

/// dynamics::StepBatchWorkspace that two threads cannot use at once.
struct BatchWorkspace {
  BatchWorkspace(const ModelPtr& of, int threads) : model(of), work(of, threads) {}
  ModelPtr model;
  dynamics::StepBatchWorkspace work;
  std::atomic<bool> busy{false};
};

/// The workspace that the caller keeps, or one for this call alone.
class WorkspaceOfCall {
 public:
  WorkspaceOfCall(const ModelPtr& model, int threads, BatchWorkspace* kept) : kept_(kept) {
    if (kept == nullptr) {
      own_.emplace(model, threads);
    } else {
      if (kept->model != model) core::throw_invalid("workspace", "one of another model", "one of this model");
      if (threads != 0) core::throw_invalid("threads", std::to_string(threads), "0 with a workspace, which has its own");
      occupied_.emplace(kept->busy);
    }
  }
  dynamics::StepBatchWorkspace& get() { return kept_ == nullptr ? own_->work : kept_->work; }

 private:
  BatchWorkspace* kept_;
  std::optional<BatchWorkspace> own_;
  std::optional<Occupied> occupied_;
};

struct StepBatch {
  ModelPtr model;
  dynamics::StepBatchResult result;
  double wall_s = 0;
};

/// (N, rows, columns) without a copy: the array keeps the batch alive.
std::optional<Cube> cube(const StepBatch& batch, const Eigen::MatrixXd& values, int rows, int columns) {
  if (values.cols() == 0) return std::nullopt;
  return Cube(values.data(), {static_cast<std::size_t>(values.cols()), static_cast<std::size_t>(rows), static_cast<std::size_t>(columns)},
              nb::find(batch));
}

std::unique_ptr<StepBatch> step_batch(const dynamics::StepOptions& given, ModelPtr model, Matrix q, Matrix u, std::optional<Matrix> tau_ext,
                                      Flag with_A, Flag with_B, int threads, BatchWorkspace* workspace) {
  core::require_size("q.shape[1]", q.named("q").cols(), model->n_q());
  core::require_size("u.shape[1]", u.named("u").cols(), model->n_a());
  if (tau_ext) core::require_size("tau_ext.shape[1]", tau_ext->named("tau_ext").cols(), model->n_v());
  dynamics::StepOptions options = given;
  options.with_A = with_A;
  options.with_B = with_B;
  auto out = std::make_unique<StepBatch>(StepBatch{model, {}, 0});
  Interrupt interrupt;
  {
    const nb::gil_scoped_release unlocked;
    const Eigen::MatrixXd q_columns = q.named("q").transpose(), u_columns = u.named("u").transpose();
    const Eigen::MatrixXd tau_columns = tau_ext ? tau_ext->named("tau_ext").transpose() : Eigen::MatrixXd();
    WorkspaceOfCall work(model, threads, workspace);
    const auto start = std::chrono::steady_clock::now();
    (void)dynamics::step_batch(*model, {q_columns, u_columns, tau_ext ? &tau_columns : nullptr}, options, work.get(), out->result,
                               interrupt.control({}));  // the statuses are in the result
    out->wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  interrupt.rethrow();
  return out;
}

Rows calc_weights_aside(const world::Model& model, const Matrix& q, double angle, int draw) {
  core::require_size("q.shape[1]", q.named("q").cols(), model.n_q());
  if (!(angle >= 0 && angle < 1.57)) core::throw_invalid("angle", fmt::format("{}", angle), "[0, pi/2) [rad]");
  if (draw < 0 || draw >= dynamics::kDisturbances)
    core::throw_invalid("draw", std::to_string(draw), fmt::format("[0, {}]", dynamics::kDisturbances - 1));
  Rows out(q.named("q").rows(), model.n_v());
  for (Eigen::Index i = 0; i < q.named("q").rows(); ++i) out.row(i) = dynamics::calc_weights_aside(model, q.named("q").row(i), angle, draw);
  return out;
}

struct RolloutBatch {
  dynamics::RolloutBatchResult result;
  long n_q = 0;
  double wall_s = 0;
};

/// (N, T, n) of columns that hold T vectors of n numbers each, without a copy: the array keeps `owner` alive.
Cube series(const Eigen::MatrixXd& columns, long n, nb::handle owner) {
  const auto size = static_cast<std::size_t>(n);
  return Cube(columns.data(), {static_cast<std::size_t>(columns.cols()), static_cast<std::size_t>(columns.rows()) / size, size}, owner);
}

/// The same, and the array is the owner.
Cube owned_series(Eigen::MatrixXd columns, long n) {
  auto kept = std::make_unique<Eigen::MatrixXd>(std::move(columns));
  const Eigen::MatrixXd& values = *kept;
  const nb::capsule owner(kept.release(), [](void* p) noexcept { delete static_cast<Eigen::MatrixXd*>(p); });
  return series(values, n, owner);
}

std::unique_ptr<RolloutBatch> rollout_batch(const dynamics::StepOptions& options, ModelPtr model, Matrix q_start, Series u, int threads,
                                            BatchWorkspace* workspace) {
  core::require_size("q_start.shape[1]", q_start.named("q_start").cols(), model->n_q());
  const SeriesColumns& u_series = u.named("u");
  core::require_size("u.shape[2]", u_series.size, model->n_a());
  auto out = std::make_unique<RolloutBatch>();
  out->n_q = model->n_q();
  Interrupt interrupt;
  {
    const nb::gil_scoped_release unlocked;
    const Eigen::MatrixXd starts = q_start.named("q_start").transpose();
    WorkspaceOfCall work(model, threads, workspace);
    const auto start = std::chrono::steady_clock::now();
    (void)dynamics::rollout_batch(*model, {starts, u_series.columns}, options, work.get(), out->result,
                                  interrupt.control({}));  // the statuses are in the result
    out->wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  interrupt.rethrow();
  return out;
}

std::pair<Rows, Cube> pull_back(const dynamics::StepOptions& options, ModelPtr model, const RolloutBatch& rolled, Series u, Series D_L_q,
                                int threads, BatchWorkspace* workspace) {
  const SeriesColumns &u_series = u.named("u"), &D_series = D_L_q.named("D_L_q");
  core::require_size("u.shape[2]", u_series.size, model->n_a());
  core::require_size("D_L_q.shape[2]", D_series.size, model->n_q());
  core::require_size("rolled.q.shape[2]", rolled.n_q, model->n_q());
  dynamics::RolloutGradient gradient;
  Interrupt interrupt;
  {
    const nb::gil_scoped_release unlocked;
    const Eigen::MatrixXd starts = rolled.result.q.topRows(rolled.n_q);
    WorkspaceOfCall work(model, threads, workspace);
    (void)dynamics::pull_back_rollout(*model, {starts, u_series.columns}, rolled.result, D_series.columns, options, work.get(), gradient,
                                      interrupt.control({}));
  }
  interrupt.rethrow();
  return {rows(gradient.q_start), owned_series(std::move(gradient.u), model->n_a())};
}

void bind_workspace(nb::module_& m) {
  nb::class_<BatchWorkspace>(m, "BatchWorkspace",
                             "Threads and their memory, kept for many small batches. Only one thread of the caller may use it at a time.")
      .def(nb::init<const ModelPtr&, int>(), "model"_a, "threads"_a = 0,
           R"(Makes the threads for batches of one model.

  model: Model of the batches.
  threads: number of threads; 0: all cores.

Raises InvalidInput.

    >>> model = st.load_task("planar_pushing").model
    >>> work = st.BatchWorkspace(model, threads=1)
    >>> q = model.neutral()[None]
    >>> [st.step_batch(model, q, q[:, 3:], workspace=work).failed for _ in range(2)]
    [0, 0])");
  def_no_pickle<BatchWorkspace>("BatchWorkspace", "a workspace made from the model in each process");
}

void bind_steps(nb::module_& m) {
  nb::class_<StepBatch>(m, "StepBatch", "Results of step_batch(): N steps. The first axis of each array is the index of the step.")
      .def_prop_ro(
          "status", [](const StepBatch& b) { return b.result.status; }, "status of each step (N)")
      .def_prop_ro(
          "solved",
          [](const StepBatch& b) {
            Eigen::Matrix<bool, Eigen::Dynamic, 1> out(static_cast<Eigen::Index>(b.result.status.size()));
            for (Eigen::Index i = 0; i < out.size(); ++i) out[i] = b.result.status[static_cast<std::size_t>(i)] == core::Status::Solved;
            return out;
          },
          "True for each step with the status Solved (N); otherwise q_next is q, and A and B are 0")
      .def_prop_ro(
          "failed", [](const StepBatch& b) { return b.result.failed; }, "number of steps that are not Solved")
      .def_prop_ro(
          "q_next", [](const StepBatch& b) { return rows(b.result.q_next); }, "next configurations (N, n_q)")
      .def_prop_ro(
          "torque", [](const StepBatch& b) { return rows(b.result.torque); }, "torques of the joint springs (N, n_a) [N m, N]")
      .def_prop_ro(
          "A", [](const StepBatch& b) { return cube(b, b.result.A, b.model->n_v(), b.model->n_v()); },
          "derivatives of q_next by q (N, n_v, n_v), a read-only array; None unless with_A was set")
      .def_prop_ro(
          "B", [](const StepBatch& b) { return cube(b, b.result.B, b.model->n_v(), b.model->n_a()); },
          "derivatives of q_next by u (N, n_v, n_a), a read-only array; None unless with_B was set")
      .def_ro("wall_s", &StepBatch::wall_s, "wall time of the steps, without copies of arrays [s]")
      .def("__len__", [](const StepBatch& b) { return b.result.status.size(); })
      .def("__repr__", [](const StepBatch& b) {
        return fmt::format("<stiction.StepBatch: {} steps, {} failed>", b.result.status.size(), b.result.failed);
      });
  def_with_step_options(
      m, "step_batch", &step_batch,
      R"(Computes N independent steps in parallel, as step() does for one, with their derivatives if asked for (docs/theory/local_models.md).

  model: Model of the scene.
  q: configurations (N, n_q).
  u: commands (N, n_a) [m or rad].
  tau_ext: external generalised forces besides gravity (N, n_v) [N, N m]. None: 0.
  with_A, with_B: also compute the derivatives StepBatch.A and StepBatch.B.
  threads: 0: all cores. The result does not depend on this number, bit for bit, since no step uses a warm start.
  workspace: BatchWorkspace of the model, which saves time for many small batches. None: a new one for this call.

Returns a StepBatch.

    >>> task = st.load_task("planar_pushing")
    >>> q = np.tile(task.q_start, (1000, 1))
    >>> batch = st.step_batch(task.model, q, q[:, 3:] + np.linspace(0, 0.2, 1000)[:, None], smoothing=st.Analytic(kappa=100), with_B=True)
    >>> batch.q_next.shape, batch.B.shape, batch.failed
    ((1000, 5), (1000, 5, 2), 0))",
      "model"_a, "q"_a, "u"_a, nb::kw_only(), "tau_ext"_a = nb::none(), "with_A"_a = false, "with_B"_a = false, "threads"_a = 0,
      "workspace"_a = nb::none());
  def_pickle<StepBatch>();
  m.def(
      "calc_weights_aside", &calc_weights_aside, "model"_a, "q"_a, "angle"_a, "draw"_a,
      R"(Computes the forces that tilt gravity by an angle, for free objects at many configurations. Use them as tau_ext of step_batch(), to test
whether an object rests stably.

  q: configurations (N, n_q).
  angle: angle by which gravity is tilted [rad], in [0, pi/2).
  draw: direction of the tilt, in [0, 3]; each direction is a quarter turn from the previous one.

Returns generalised forces (N, n_v) [N, N m]. They are 0 without gravity, and for objects on joints.

    >>> task = st.load_task("allegro_ball")
    >>> st.calc_weights_aside(task.model, task.q_start[None], 0.1, 0)[0, :3].round(4)
    array([0.    , 0.0502, 0.    ]))");
}

void bind_rollouts(nb::module_& m) {
  nb::class_<RolloutBatch>(m, "RolloutBatch", "Results of rollout_batch(): N trajectories of T steps each.")
      .def_prop_ro(
          "q", [](const RolloutBatch& b) { return series(b.result.q, b.n_q, nb::find(b)); },
          "configurations, the start first (N, T + 1, n_q); a read-only array")
      .def_prop_ro(
          "status", [](const RolloutBatch& b) { return b.result.status; },
          "status of each trajectory (N): Solved, or the status of its first step that is not Solved")
      .def_prop_ro(
          "steps", [](const RolloutBatch& b) { return b.result.steps; },
          "number of solved steps of each trajectory (N); a trajectory stays where a step failed")
      .def_prop_ro(
          "failed", [](const RolloutBatch& b) { return b.result.failed; }, "number of trajectories that are not Solved")
      .def_ro("wall_s", &RolloutBatch::wall_s, "wall time of the steps, without copies of arrays [s]")
      .def("__len__", [](const RolloutBatch& b) { return b.result.status.size(); })
      .def("__repr__", [](const RolloutBatch& b) {
        return fmt::format("<stiction.RolloutBatch: {} trajectories, {} failed>", b.result.status.size(), b.result.failed);
      });
  def_with_step_options(m, "rollout_batch", &rollout_batch,
                        R"(Computes N trajectories q[t + 1] = step(q[t], u[t]) in parallel.

  model: Model of the scene.
  q_start: configurations at the start (N, n_q).
  u: commands (N, T, n_a) [m or rad].
  threads: 0: all cores. The result does not depend on this number, bit for bit, since no step uses a warm start.
  workspace: BatchWorkspace of the model, which saves time for many small batches. None: a new one for this call.

Returns a RolloutBatch.

    >>> task = st.load_task("planar_pushing")
    >>> q = np.tile(task.q_start, (100, 1))
    >>> u = q[:, None, 3:] + np.linspace(0, 0.2, 8)[None, :, None]
    >>> rolled = st.rollout_batch(task.model, q, u)
    >>> rolled.q.shape, rolled.failed
    ((100, 9, 5), 0))",
                        "model"_a, "q_start"_a, "u"_a, nb::kw_only(), "threads"_a = 0, "workspace"_a = nb::none());
  def_with_step_options(
      m, "pull_back_rollout", &pull_back,
      R"(Back-propagates the gradient of a scalar L through the trajectories of rollout_batch(), by the adjoint of the steps (S.25).

Use it to optimise commands: give dL/dq at all configurations, and get dL/dq_start and dL/du.

  model: Model of the scene.
  rolled: RolloutBatch of rollout_batch(), for the same u.
  u: commands of that call (N, T, n_a) [m or rad].
  D_L_q: dL/dq (N, T + 1, n_q).
  threads, workspace: as in rollout_batch().

The arguments of the step are those of rollout_batch(), or smoother ones: an exact step has the derivative 0 if nothing touches.

Returns dL/dq_start (N, n_q) and dL/du (N, T, n_a). The derivative by a quaternion is tangent to the sphere of unit quaternions.

    >>> task = st.load_task("planar_pushing")
    >>> q = task.q_start[None]
    >>> u = q[:, None, 3:] + np.linspace(0, 0.2, 8)[None, :, None]
    >>> rolled = st.rollout_batch(task.model, q, u)
    >>> D_L_q = np.zeros_like(rolled.q)
    >>> D_L_q[:, -1, 1] = 1  # L: where the box ends along z
    >>> D_L_q_start, D_L_u = st.pull_back_rollout(task.model, rolled, u, D_L_q, smoothing=st.Analytic(kappa=100))
    >>> D_L_q_start.shape, D_L_u.shape
    ((1, 5), (1, 8, 2)))",
      "model"_a, "rolled"_a, "u"_a, "D_L_q"_a, nb::kw_only(), "threads"_a = 0, "workspace"_a = nb::none());
  def_pickle<RolloutBatch>();
}

}  // namespace

void bind_batch(nb::module_& m) {
  bind_workspace(m);
  bind_steps(m);
  bind_rollouts(m);
}

}  // namespace stiction::python
