#include <fmt/format.h>

#include <algorithm>

#include "pickles.hpp"
#include "sensor.hpp"
#include "stiction/sensing/detectability.hpp"
#include "stiction/world/cache_file.hpp"
#include "torque_arguments.hpp"
#include "watcher.hpp"

namespace stiction::python {

sensing::SenseWorkspace Sensor::take() {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) return sensing::SenseWorkspace(sensor_);
  sensing::SenseWorkspace out = std::move(idle_.back());
  idle_.pop_back();
  return out;
}

void Sensor::put(sensing::SenseWorkspace&& work) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(work));
}

Eigen::VectorXd configuration_of(const world::Model& model, const std::string& name, Eigen::Ref<const Eigen::VectorXd> q) {
  if (q.size() != model.n_a()) {
    world::require_configuration(model, name, q);
    return q;
  }
  core::require_finite(name, {q.data(), static_cast<std::size_t>(q.size())});
  return sensing::place_robots(model, q);
}

SenseResult sense(Sensor& sensor, const Eigen::VectorXd& q, const Eigen::VectorXd& tau, const SenseResult* last,
                  const sensing::SenseOptions& options) {
  if (last != nullptr && last->sensor != sensor.ptr()) core::throw_invalid("last", "a result of another sensor", "one of this sensor");
  std::vector<sensing::ContactPoint> points;
  if (last != nullptr) points = last->result.best_points();
  SenseResult out{sensor.ptr(), {}};
  Sensor::Borrowed borrowed(sensor);
  sensing::sense(sensor.get(), {q, tau, &points}, options, borrowed.work(), out.result);
  return out;
}

std::vector<SenseResult> sense_series(Sensor& sensor, const Eigen::MatrixXd& q, const Eigen::MatrixXd& tau,
                                      const sensing::SenseOptions& options, const core::RunControl& control, const std::vector<int>& gaps) {
  std::vector<SenseResult> out;
  out.reserve(static_cast<std::size_t>(q.cols()));
  for (Eigen::Index i = 0; i < q.cols() && !control.stop(); ++i) {
    const bool fresh = i == 0 || std::find(gaps.begin(), gaps.end(), static_cast<int>(i)) != gaps.end();
    out.push_back(sense(sensor, configuration_of(sensor.model(), fmt::format("q[{}]", i), q.col(i)), tau.col(i),
                        fresh ? nullptr : &out.back(), options));
  }
  return out;
}

namespace {

using sensing::SenseOptions;
using sensing::SensorOptions;
using sensing::SurfaceOptions;

SensorPtr make_sensor(const ModelPtr& model, const std::vector<std::string>& links, int samples, sensing::Sampling sampling,
                      sensing::Normals normals, std::uint64_t seed, SurfaceOptions surface) {
  const nb::gil_scoped_release unlocked;
  surface.cache_dir = world::default_cache_dir();
  return sensing::Sensor::make(model, {links, samples, sampling, normals, seed, surface});
}

/// Defines a method of Sensor with the arguments of `function` followed by those of sense(), which are the same everywhere.
template <class R, class... Head, class... Arguments>
void def_with_sense_options(nb::class_<Sensor>& type, const char* name, R (*function)(const SenseOptions&, Sensor&, Head...),
                            const char* doc, const Arguments&... arguments) {
  const SenseOptions standard;
  const std::string text = std::string(doc) + R"(

Options:
  friction: friction coefficient of the cone of possible contact forces (4.2).
  rays: number of rays of this cone, in [3, 64]. 0: the exact cone.
  noise: standard deviation of every torque [N m], > 0; or one for each joint (n_a), or the covariance (n_a, n_a), as Calibration.noise.
  rest: measured torques without contact (n_a), or a Calibration. None: 0.
  sign: -1 if the robot reports the torques that it exerts on its surroundings, as libfranka does; otherwise 1.
  unmeasured: joints without a torque sensor, by index or name. Their torques count as unknown, not as 0.
  threshold: the search for contacts begins if max |tau| is at least this [N m], > 0. None: 4 times the noise of the joint, or more if the
    noise is known from few rows.
  accept: largest residual l of an accepted sample [(N m)^2]. None: accept_share |tau|^2, or the residual that noise may cause if that is
    more.
  tolerance: share of |tau| that a contact may leave unexplained if there is no noise.
  method: GaussNewton(), SteepestDescent() (algorithm 4) or RejectionSampling().
  merge: points closer than this many sample spacings form one candidate.
  thin: Gauss-Newton skips starts within this many sample spacings of an earlier start or result, >= 0.
  plausible_force: plausible contact force F [N], > 0. Candidates that explain the torques are ordered by l + (noise/F)^2 |f|^2. None: the
    force that the weakest joint holds at its full reach.
  friction_error: share by which the true friction may be larger, in [0, 1). It is used if no contact explains the torques.
  posterior: True: also compute SenseResult.posterior, and order the candidates that explain the torques by probability.
  touch_prior: prior probability of a contact, in (0, 1).
  freedom: degrees of freedom of the noise estimate, one number or one for each joint (n_a), > 0, as Calibration.freedom. None: the noise is
    known exactly.

Raises InvalidInput, which names the argument: wrong sizes, numbers that are not finite, options out of range.)";
  type.def(
      name,
      [function](Sensor& self, Head... head, double friction, int rays, const NoiseArgument& noise, std::optional<double> threshold,
                 std::optional<double> accept, double accept_share, double tolerance, const sensing::Method& method, double merge,
                 double thin, std::optional<double> plausible_force, double friction_error, const std::optional<RestArgument>& rest,
                 int sign, const std::vector<JointArgument>& unmeasured, Flag posterior, double touch_prior,
                 const FreedomArgument& freedom) {
        SenseOptions options{.cone = sensing::FrictionCone(friction, rays),
                             .threshold = threshold,
                             .accept = accept,
                             .accept_share = accept_share,
                             .tolerance = tolerance,
                             .method = method,
                             .merge = merge,
                             .thin = thin,
                             .plausible_force = plausible_force,
                             .friction_error = friction_error,
                             .posterior = posterior,
                             .touch_prior = touch_prior};
        set_torques(self.model(), {noise, freedom, rest, sign, unmeasured}, options);
        return function(options, self, head...);
      },
      arguments..., "friction"_a = standard.cone.friction(), "rays"_a = standard.cone.rays(), "noise"_a = standard.noise,
      "threshold"_a = nb::none(), "accept"_a = nb::none(), "accept_share"_a = standard.accept_share, "tolerance"_a = standard.tolerance,
      "method"_a = standard.method, "merge"_a = standard.merge, "thin"_a = standard.thin, "plausible_force"_a = nb::none(),
      "friction_error"_a = standard.friction_error, "rest"_a = nb::none(), "sign"_a = 1, "unmeasured"_a = std::vector<JointArgument>(),
      "posterior"_a = false, "touch_prior"_a = standard.touch_prior, "freedom"_a = nb::none(), text.c_str());
}

SenseResult sense_once(const SenseOptions& options, Sensor& sensor, Vector q, Vector tau, const SenseResult* last) {
  const Eigen::VectorXd full = configuration_of(sensor.model(), "q", q.named("q"));
  const nb::gil_scoped_release unlocked;
  return sense(sensor, full, tau.named("tau"), last, options);
}

std::vector<SenseResult> sense_many(const SenseOptions& options, Sensor& sensor, Matrix q, Matrix tau) {
  if (q.named("q").rows() != tau.named("tau").rows())
    core::throw_invalid("tau", fmt::format("{} moments", tau.named("tau").rows()), fmt::format("those of q, {}", q.named("q").rows()));
  Interrupt interrupt;
  std::vector<SenseResult> out;
  {
    const nb::gil_scoped_release unlocked;
    out = sense_series(sensor, q.named("q").transpose(), tau.named("tau").transpose(), options, interrupt.control({}));
  }
  interrupt.rethrow();
  return out;
}

SenseResult sense_moments(const SenseOptions& options, Sensor& sensor, Matrix q, Matrix tau, double correlation) {
  Eigen::MatrixXd full(sensor.model().n_q(), q.named("q").rows());
  for (Eigen::Index i = 0; i < q.named("q").rows(); ++i)
    full.col(i) = configuration_of(sensor.model(), fmt::format("q[{}]", i), q.named("q").row(i).transpose());
  const nb::gil_scoped_release unlocked;
  SenseResult out{sensor.ptr(), {}};
  Sensor::Borrowed borrowed(sensor);
  sensing::sense_touch(sensor.get(), full, tau.named("tau").transpose(), correlation, options, borrowed.work(), out.result);
  return out;
}

/// Vectors, one a row. @throws core::InvalidInput: not (n, 3), not finite
const Eigen::MatrixXd& require_points(const char* name, const Matrix& matrix) {
  if (matrix.named(name).cols() != 3)
    core::throw_invalid(name, fmt::format("shape ({}, {})", matrix.named(name).rows(), matrix.named(name).cols()), "(points, 3)");
  core::require_finite(name, {matrix.named(name).data(), static_cast<std::size_t>(matrix.named(name).size())});
  return matrix.named(name);
}

/// Points of a surface with their outward normals, of any length but 0.
sensing::SampleBatch make_batch(const Matrix& p_L, const Matrix& n_L) {
  const Eigen::MatrixXd& points = require_points("p_L", p_L);
  const Eigen::MatrixXd& normals = require_points("n_L", n_L);
  if (points.rows() != normals.rows())
    core::throw_invalid("n_L", fmt::format("{} normals", normals.rows()), fmt::format("one for each point, {}", points.rows()));
  sensing::SampleBatch out;
  out.resize(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d n = normals.row(i);
    if (!(n.norm() > 0)) core::throw_invalid(fmt::format("n_L[{}]", i), "0", "a direction");
    out.set(i, points.row(i).transpose(), sensing::make_contact_frame(n.normalized()));
  }
  return out;
}

std::vector<SensedLink> sensed_links_of(const Sensor& sensor) {
  std::vector<SensedLink> out;
  for (int i = 0; i < static_cast<int>(sensor.get().links().size()); ++i) out.push_back({sensor.ptr(), i});
  return out;
}

const sensing::SensedLink& link_of(const Sensor& sensor, const std::string& name) {
  return sensor.get().links()[static_cast<std::size_t>(sensor.get().link_index(name))];
}

Eigen::VectorXd calc_residuals(Sensor& sensor, const Vector& q, const Vector& tau, const std::string& link, const Matrix& p_L,
                               const Matrix& n_L, double friction, int rays) {
  const world::Model& model = sensor.model();
  const Eigen::VectorXd full = configuration_of(model, "q", q.named("q"));
  require_vector("tau", tau, model.n_a());
  const sensing::SampleBatch batch = make_batch(p_L, n_L);
  const sensing::FrictionCone cone(friction, rays);
  const int body = link_of(sensor, link).surface.body;
  const nb::gil_scoped_release unlocked;
  world::KinematicsWorkspace work(model);
  world::Kinematics kinematics;
  world::calc_kinematics(model, full, work, kinematics);
  Eigen::Matrix3Xd J_w, J_v;
  sensing::calc_link_jacobian(model, kinematics, body, J_w, J_v);
  Eigen::VectorXd out(batch.rows.cols());
  sensing::calc_residuals(sensing::LinkTorque(J_w, J_v, tau.named("tau")), batch, cone, out);
  return out.head(batch.size);
}

Eigen::VectorXd calc_undetectability(Sensor& sensor, const std::string& link, const Matrix& p_L, const Matrix& n_L, double friction,
                                     double epsilon) {
  core::require_nonnegative("friction", friction);
  core::require_positive("epsilon", epsilon);
  const sensing::SampleBatch batch = make_batch(p_L, n_L);
  const sensing::JointLine joint = sensing::find_joint_line(sensor.model(), link_of(sensor, link).surface.body);
  Eigen::VectorXd out(batch.size);
  for (Eigen::Index i = 0; i < batch.size; ++i)
    out[i] = sensing::calc_undetectability(joint.lever(batch.p_L(i)), batch.R_LC(i).col(0), friction, epsilon);
  return out;
}

sensing::DetectabilityMap calc_detectability(Sensor& sensor, const std::string& link, double friction, int rays, double epsilon) {
  core::require_positive("epsilon", epsilon);
  const sensing::FrictionCone cone(friction, rays);
  const nb::gil_scoped_release unlocked;
  return sensing::calc_detectability(sensor.model(), link_of(sensor, link), cone, epsilon);
}

Eigen::VectorXd calc_contact_torque(const ModelPtr& model, const Vector& q, const std::string& link, const Vector& p_L, const Vector& f_L) {
  const Eigen::VectorXd full = configuration_of(*model, "q", q.named("q"));
  const int body = find_link(*model, "link", link);
  return sensing::calc_contact_torque(*model, full, body, require_vector3("p_L", p_L), require_vector3("f_L", f_L));
}

void bind_options(nb::module_& m) {
  const SurfaceOptions surface;
  nb::enum_<sensing::Sampling>(m, "Sampling", "Distribution of sample points on the surface of a link.")
      .value("Uniform", sensing::Sampling::Uniform, "independent points, uniform by area")
      .value("Stratified", sensing::Sampling::Stratified, "one point in each of equal areas")
      .value("BlueNoise", sensing::Sampling::BlueNoise, "the points farthest apart, chosen from five times as many");
  nb::enum_<sensing::Normals>(m, "Normals", "Kind of surface normals.")
      .value("Flat", sensing::Normals::Flat, "normal of the triangle")
      .value("Smooth", sensing::Normals::Smooth, "interpolated from vertex normals, except at sharp edges");
  nb::class_<SurfaceOptions>(m, "SurfaceOptions", R"(Options for the surface of a link on which contacts are possible.

  segments: number of triangles around a sphere, a cylinder or a capsule, >= 3.
  rays: number of rays from each point whose visibility is tested. 0: hidden faces are kept.
  postures: number of robot postures in which a face may be visible, >= 1.
  crease: edges with a larger angle stay sharp with smooth normals [rad].)")
      .def(
          "__init__",
          [](SurfaceOptions* self, int segments, int rays, int postures, double crease) {
            new (self) SurfaceOptions{segments, rays, postures, crease};
          },
          nb::kw_only(), "segments"_a = surface.segments, "rays"_a = surface.rays, "postures"_a = surface.postures,
          "crease"_a = surface.crease)
      .def_ro("segments", &SurfaceOptions::segments, "triangles around a round shape")
      .def_ro("rays", &SurfaceOptions::rays, "rays of the visibility test")
      .def_ro("postures", &SurfaceOptions::postures, "postures of the visibility test")
      .def_ro("crease", &SurfaceOptions::crease, "angle of a sharp edge [rad]")
      .def("__repr__", [](const SurfaceOptions& o) {
        return fmt::format("SurfaceOptions(segments={}, rays={}, postures={}, crease={})", o.segments, o.rays, o.postures, o.crease);
      });
  using sensing::GaussNewton, sensing::RejectionSampling, sensing::SteepestDescent;
  const GaussNewton newton;
  nb::class_<GaussNewton>(m, "GaussNewton",
                          "Levenberg-Marquardt over contact point and force together. Step lengths are shares of the link's size.")
      .def(
          "__init__",
          [](GaussNewton* self, int max_steps, double tol_step, double damping, double max_step) {
            new (self) GaussNewton{max_steps, tol_step, damping, max_step};
          },
          nb::kw_only(), "max_steps"_a = newton.max_steps, "tol_step"_a = newton.tol_step, "damping"_a = newton.damping,
          "max_step"_a = newton.max_step)
      .def("__repr__", [](const GaussNewton& o) {
        return fmt::format("GaussNewton(max_steps={}, tol_step={}, damping={}, max_step={})", o.max_steps, o.tol_step, o.damping,
                           o.max_step);
      });
  const SteepestDescent steepest;
  nb::class_<SteepestDescent>(m, "SteepestDescent", "Steepest descent on the surface: algorithm 4 of the thesis (RSGD).")
      .def(
          "__init__",
          [](SteepestDescent* self, int max_steps, double tol_gradient, double armijo, double backtrack, int max_backtracks,
             double max_step) { new (self) SteepestDescent{max_steps, tol_gradient, armijo, backtrack, max_backtracks, max_step}; },
          nb::kw_only(), "max_steps"_a = steepest.max_steps, "tol_gradient"_a = steepest.tol_gradient, "armijo"_a = steepest.armijo,
          "backtrack"_a = steepest.backtrack, "max_backtracks"_a = steepest.max_backtracks, "max_step"_a = steepest.max_step)
      .def("__repr__", [](const SteepestDescent& o) {
        return fmt::format("SteepestDescent(max_steps={}, tol_gradient={}, armijo={}, backtrack={}, max_backtracks={}, max_step={})",
                           o.max_steps, o.tol_gradient, o.armijo, o.backtrack, o.max_backtracks, o.max_step);
      });
  nb::class_<RejectionSampling>(m, "RejectionSampling", "Rejection sampling: the accepted samples, without descent (4.9).")
      .def(nb::init<>())
      .def("__repr__", [](const RejectionSampling&) { return "RejectionSampling()"; });
}

/// Sensors are immutable and large: pickle writes the options of each one once, whatever the number of results that name its links.
void bind_pickle(nb::module_& m) {
  nb::class_<sensing::Sensor>(m, "_SharedSensor")
      .def(
          "__reduce__",
          [](const sensing::Sensor& sensor) {
            pickles::Writer options;
            options.put(sensor.options());
            return nb::make_tuple(nb::module_::import_("stiction._pickles").attr("make_shared_sensor"),
                                  nb::make_tuple(sensor.model_ptr(), options.state()));
          },
          nb::sig("def __reduce__(self) -> tuple"));
  m.def(
      "_make_shared_sensor",
      [](const ModelPtr& model, const nb::tuple& state) {
        auto options = pickles::Reader(state).get<SensorOptions>();
        options.surface.cache_dir = world::default_cache_dir();
        return sensing::Sensor::make(model, options);
      },
      "model"_a, "options"_a, nb::sig("def _make_shared_sensor(model: Model, options: tuple) -> _SharedSensor"));
  add_method<Sensor>(
      "__getstate__", [](const Sensor& self) { return nb::make_tuple(self.ptr()); }, nb::sig("def __getstate__(self) -> tuple"));
  add_method<Sensor>(
      "__setstate__", [](Sensor& self, const nb::tuple& state) { new (&self) Sensor(nb::cast<SensorPtr>(state[0])); },
      nb::sig("def __setstate__(self, state: tuple, /) -> None"));
  def_shared_copy<sensing::Sensor>();
  def_shared_copy<Sensor>();
  def_pickle<SurfaceOptions, sensing::GaussNewton, sensing::SteepestDescent, sensing::RejectionSampling, sensing::DetectabilityMap>();
}

void bind_detectability(nb::module_& m) {
  using sensing::Detectability, sensing::DetectabilityMap;
  nb::enum_<Detectability>(m, "Detectability", "Whether a contact on a link causes a torque in the last joint before the link (4.7).")
      .value("Undetectable", Detectability::Undetectable, "no force of the friction cone causes a torque")
      .value("Partial", Detectability::Partial, "some forces of the cone cause a torque")
      .value("Full", Detectability::Full, "every force of the cone except 0 causes a torque");
  nb::class_<DetectabilityMap>(m, "DetectabilityMap", "Detectability of contacts at the sample points of a link.")
      .def_ro("kinds", &DetectabilityMap::kinds, "detectability at each sample")
      .def_ro("eta", &DetectabilityMap::eta, "share of the unit forces whose torque is at most epsilon, in [0, 1] (4.8) (samples)")
      .def_ro("full", &DetectabilityMap::full, "number of fully detectable samples");
}

}  // namespace

void bind_sensing(nb::module_& m) {
  bind_options(m);
  bind_detectability(m);
  bind_sense_results(m);
  bind_calibration(m);
  bind_observer(m);
  const SensorOptions standard;
  auto sensor =
      nb::class_<Sensor>(m, "Sensor",
                         R"(Locates contacts on the links of a robot from joint torques.

A sensor holds sample points on the surface of each link. Make it once and call sense() for every measurement. It is immutable, and threads
may share it.

  model: Model with at least one robot.
  links: names of the links to sense, as "robot/link"; * matches any characters. Empty: all links that a joint moves and that have geometry.
  samples: number of sample points on each link, >= 1.
  sampling: distribution of the sample points.
  normals: kind of surface normals.
  seed: of the sample points, and of the postures in the visibility test of the surface.
  surface: SurfaceOptions.

Raises InvalidInput: a pattern matches no link, or a link is not moved by a joint or has no surface.

    >>> model = st.load_model({"robots": [{"name": "arm", "urdf": "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"}]})
    >>> sensor = st.Sensor(model, links=["arm/forearm_link"], samples=200)
    >>> q, link = np.array([0.3, -1.2, 1.6, -2.0, -1.6, 0.4]), sensor.links[0]
    >>> tau = st.calc_contact_torque(model, q, link.name, link.p_L[50], -20 * link.n_L[50])  # a push of 20 N
    >>> result = sensor.sense(q, tau)
    >>> result.verdict, result.calc_distance(link.name, link.p_L[50]) < 0.02
    (Verdict.Explained, True))")
          .def(
              "__init__",
              [](Sensor* self, const ModelPtr& model, const std::vector<std::string>& links, int samples, sensing::Sampling sampling,
                 sensing::Normals normals, std::uint64_t seed, const SurfaceOptions& surfaces) {
                new (self) Sensor(make_sensor(model, links, samples, sampling, normals, seed, surfaces));
              },
              "model"_a, nb::kw_only(), "links"_a = standard.links, "samples"_a = standard.samples, "sampling"_a = standard.sampling,
              "normals"_a = standard.normals, "seed"_a = standard.seed, "surface"_a = standard.surface)
          .def_prop_ro(
              "model", [](const Sensor& s) { return s.get().model_ptr(); }, "model of the robot")
          .def_prop_ro("links", &sensed_links_of, "sensed links, in the order of the model")
          .def_prop_ro(
              "notes", [](const Sensor& s) { return std::vector<std::string>(s.get().notes().begin(), s.get().notes().end()); },
              "remarks, one sentence each: faces that were left out, and links with too few joints to locate a contact")
          .def("calc_residuals", &calc_residuals, "q"_a, "tau"_a, "link"_a, "p_L"_a, "n_L"_a, nb::kw_only(),
               "friction"_a = SenseOptions{}.cone.friction(), "rays"_a = SenseOptions{}.cone.rays(),
               R"(Computes the residual l(p) = min over f in the cone of |J_C^T f - tau|^2 at given points (4.5).

  q: configuration (n_q), or joint positions alone (n_a).
  tau: external torques (n_a) [N m; N].
  link: name of the link, as "robot/link".
  p_L, n_L: points and outward normals in the frame of the link (points, 3) [m].
  friction, rays: friction cone, as in sense().

Returns the residuals [(N m)^2] (points).)")
          .def("calc_undetectability", &calc_undetectability, "link"_a, "p_L"_a, "n_L"_a, nb::kw_only(),
               "friction"_a = SenseOptions{}.cone.friction(), "epsilon"_a,
               R"(Computes the undetectability eta at given points (4.8): the share of unit forces of the exact cone whose torque is small.

  link: name of the link, as "robot/link".
  p_L, n_L: points and outward normals in the frame of the link (points, 3) [m].
  friction: friction coefficient of the cone.
  epsilon: a torque of at most this per unit of force is small [N m/N], > 0.

Returns eta (points).)")
          .def("calc_detectability", &calc_detectability, "link"_a, nb::kw_only(), "friction"_a = SenseOptions{}.cone.friction(),
               "rays"_a = SenseOptions{}.cone.rays(), "epsilon"_a,
               R"(Computes whether contacts at the samples of a link cause a torque in the last joint before the link (4.7), (4.8).

  link: name of the link, as "robot/link".
  friction, rays: friction cone, as in sense().
  epsilon: a torque of at most this per unit of force is small [N m/N], > 0.

Returns a DetectabilityMap.)");
  def_with_sense_options(sensor, "sense", &sense_once,
                         R"(Finds all single contacts on the sensed links that explain the joint torques of one measurement.

  q: configuration (n_q), or joint positions alone (n_a) [rad or m]; objects are then at their placed frames.
  tau: external torques (n_a), in the order of u: the measured torques minus the torques of gravity and motion [N m; N].
  last: SenseResult of the previous cycle. The search also starts from its candidates. None: no previous result.

Returns a SenseResult with the candidates.)",
                         "q"_a, "tau"_a, "last"_a = nb::none(), nb::kw_only());
  def_with_sense_options(
      sensor, "sense_series", &sense_many,
      R"(Calls sense() for a series of measurements. Each search also starts from the candidates of the previous measurement.

  q: configurations (time, n_q), or joint positions alone (time, n_a).
  tau: external torques (time, n_a) [N m; N].

Returns a list with one SenseResult for each measurement.)",
      "q"_a, "tau"_a, nb::kw_only());
  def_with_sense_options(
      sensor, "sense_touch", &sense_moments,
      R"(Locates one contact from several measurements: the same point on the same link, with a different force in each measurement.

  q: configurations (moments, n_q), or joint positions alone (moments, n_a).
  tau: external torques (moments, n_a) [N m; N].
  correlation: correlation of the errors of the measurements, in [0, 1]: m measurements count as m/(1 + (m - 1) correlation). An error of
    `rest`, for example, is common to all measurements.

Returns a SenseResult. Its candidates come from the measurement whose torques are largest relative to their noise. It always has
probabilities.)",
      "q"_a, "tau"_a, "correlation"_a = 0.0, nb::kw_only());
  bind_contact_sets(m, sensor);
  m.def("calc_contact_torque", &calc_contact_torque, "model"_a, "q"_a, "link"_a, "p_L"_a, "f_L"_a,
        R"(Computes the joint torques that a contact force on a link causes (Y.1).

  model: Model with the robot.
  q: configuration (n_q), or joint positions alone (n_a).
  link: name of the link, as "robot/link".
  p_L: contact point in the frame of the link [m] (3).
  f_L: force on the robot in the frame of the link [N] (3).

Returns the torques (n_a) [N m; N].)");
  bind_sensing_scenario(m);
  bind_pickle(m);
}

}  // namespace stiction::python
