#pragma once

#include <optional>
#include <string>

#include "bindings.hpp"

namespace stiction::python {

/// An argument that another one took the place of. @throws nb::python_error: warnings are errors
inline void warn_deprecated(const char* name, const char* instead) {
  const std::string text = std::string(name) + "= is deprecated, write " + instead;
  if (PyErr_WarnEx(PyExc_DeprecationWarning, text.c_str(), 1) < 0) throw nb::python_error();
}

/// Defines `name` with the arguments of `function` followed by those of the step, which are the same everywhere.
/// @param arguments  names of the arguments before them, nb::kw_only() among them
template <class R, class... Head, class... Arguments>
void def_with_step_options(nb::module_& m, const char* name, R (*function)(const dynamics::StepOptions&, Head...), const char* doc,
                           const Arguments&... arguments) {
  const dynamics::StepOptions standard;
  const std::string text = std::string(doc) + R"(

Arguments of the step:
  h: time step [s], > 0.
  smoothing: Exact() (2.6), or Analytic(kappa=...) [1/J] (2.27).
  regularisation: regularisation of the objects: ByRule(ratio=...) (docs/theory/step.md), or FixedEpsilon(epsilon=...), where 1 is the true mass.
  friction_cone: SecondOrderCone(), or PolyhedralCone(rays=...).
  friction_law: law of exact steps. Anitescu: a sliding contact opens by mu |J_t dq|. Coulomb: a sliding contact stays closed (S.14).
  friction_scale: factor of every coefficient of friction, >= 0.
  contact_margin: distance that is added to the contact distance of the scene [m], >= 0.
  joint_limits: True: the joint limits are constraints of the step.
  effort_limits: True: a joint pushes with Model.effort at most (S.15). False: the spring forces have no limit.
  tol_complementarity: largest |v lambda| of a contact, divided by 5 L F h with the scales L and F of docs/theory/scales.md [-], in [1e-12, 1e-2].
  kappa, epsilon: deprecated; use smoothing=Analytic(kappa=...) and regularisation=FixedEpsilon(epsilon=...).

Raises InvalidInput, which names the argument.)";
  m.def(
      name,
      [function](Head... head, double h, const dynamics::Smoothing& smoothing, const dynamics::Regularisation& regularisation,
                 const dynamics::FrictionCone& friction_cone, dynamics::FrictionLaw friction_law, double friction_scale,
                 double contact_margin, Flag joint_limits, Flag effort_limits, double tol_complementarity, std::optional<double> kappa,
                 std::optional<double> epsilon) {
        dynamics::StepOptions options;
        options.h = h;
        options.smoothing = smoothing;
        options.regularisation = regularisation;
        options.friction_cone = friction_cone;
        options.friction_law = friction_law;
        options.friction_scale = friction_scale;
        options.contact_margin = contact_margin;
        options.joint_limits = joint_limits;
        options.effort_limits = effort_limits;
        options.tol_complementarity = tol_complementarity;
        if (kappa) {
          warn_deprecated("kappa", "smoothing=Analytic(kappa=...)");
          options.smoothing = dynamics::Analytic{*kappa};
        }
        if (epsilon) {
          warn_deprecated("epsilon", "regularisation=FixedEpsilon(epsilon=...)");
          options.regularisation = dynamics::FixedEpsilon{*epsilon};
        }
        return function(options, head...);
      },
      arguments..., "h"_a = standard.h, "smoothing"_a = standard.smoothing, "regularisation"_a = standard.regularisation,
      "friction_cone"_a = standard.friction_cone, "friction_law"_a = standard.friction_law, "friction_scale"_a = standard.friction_scale,
      "contact_margin"_a = standard.contact_margin, "joint_limits"_a = standard.joint_limits, "effort_limits"_a = standard.effort_limits,
      "tol_complementarity"_a = standard.tol_complementarity, "kappa"_a = nb::none(), "epsilon"_a = nb::none(), text.c_str());
}

}  // namespace stiction::python
