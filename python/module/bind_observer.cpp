#include "pickles.hpp"
#include "sensor.hpp"
#include "stiction/sensing/observer.hpp"

namespace stiction::python {
namespace {

using sensing::JointFriction;

sensing::MotionRecord make_record(const Vector& t, const Matrix& q, const Matrix& qd, const Matrix& tau) {
  return {{t.value.begin(), t.value.end()}, q.value.transpose(), qd.value.transpose(), tau.value.transpose()};
}

Rows observe(const ModelPtr& model, const Vector& t, const Matrix& q, const Matrix& qd, const Matrix& tau, double time_constant,
             const std::optional<JointFriction>& friction) {
  const sensing::MotionRecord record = make_record(t, q, qd, tau);
  const nb::gil_scoped_release unlocked;
  return rows(sensing::observe(*model, record, {time_constant, friction ? &*friction : nullptr}));
}

JointFriction identify_friction(const ModelPtr& model, const Vector& t, const Matrix& q, const Matrix& qd, const Matrix& tau,
                                double time_constant, double stiction_speed) {
  const sensing::MotionRecord record = make_record(t, q, qd, tau);
  const nb::gil_scoped_release unlocked;
  return sensing::identify_friction(*model, record, time_constant, stiction_speed);
}

}  // namespace

void bind_observer(nb::module_& m) {
  nb::class_<JointFriction>(m, "JointFriction",
                            "Friction coulomb tanh(qd/stiction_speed) + viscous qd of each joint, and the offset of its torque sensor.")
      .def_ro("coulomb", &JointFriction::coulomb, "(n_a) [N m; N]")
      .def_ro("viscous", &JointFriction::viscous, "(n_a) [N m s/rad; N s/m]")
      .def_ro("offset", &JointFriction::offset, "(n_a) [N m; N]")
      .def_ro("stiction_speed", &JointFriction::stiction_speed, "below which friction has no sure sign [rad/s or m/s]");
  const sensing::ObserverSettings standard;
  m.def("observe", &observe, "model"_a, "t"_a, "q"_a, "qd"_a, "tau"_a, nb::kw_only(), "time_constant"_a = standard.time_constant,
        "friction"_a = nb::none(),
        R"(External torques from motion and motor torques, by the momentum observer: no accelerations are needed (time, n_a) [N m; N].

  t: times, increasing [s] (time). q, qd, tau: joint positions, velocities and torques of the motors on the links (time, n_a).
  time_constant: lag [s], > 0. friction: of identify_friction(), or None.

Raises InvalidInput: sizes, numbers that are not finite, times that do not increase, a robot without masses.)");
  m.def("identify_friction", &identify_friction, "model"_a, "t"_a, "q"_a, "qd"_a, "tau"_a, nb::kw_only(),
        "time_constant"_a = standard.time_constant, "stiction_speed"_a = JointFriction{}.stiction_speed,
        R"(Friction of each joint, from motion in which nothing touches the robot and every joint moves in both directions.

  Arguments as of observe(). stiction_speed: below which friction has no sure sign [rad/s or m/s], > 0.

Raises InvalidInput: as observe(); a joint that does not move in both directions.)");
  def_pickle<JointFriction>();
}

}  // namespace stiction::python
