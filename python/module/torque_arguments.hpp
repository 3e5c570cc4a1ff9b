#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sensor.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/sensing/few_rows.hpp"
#include "stiction/sensing/sense.hpp"

namespace stiction::python {

using NoiseArgument = std::variant<double, VectorAlone, MatrixAlone>;
using FreedomArgument = std::optional<std::variant<double, VectorAlone>>;
using RestArgument = std::variant<Calibrated, Vector>;
using JointArgument = std::variant<int, std::string>;

/// Index in u of a joint of `unmeasured`. @throws core::InvalidInput: no such joint
inline int find_unmeasured(const world::Model& model, const JointArgument& joint) {
  if (const int* index = std::get_if<int>(&joint)) {
    if (*index < 0 || *index >= model.n_a())
      core::throw_invalid("unmeasured", "joint " + std::to_string(*index), "joints from 0 to " + std::to_string(model.n_a() - 1));
    return *index;
  }
  try {
    return model.joint_index(std::get<std::string>(joint));
  } catch (const core::InvalidInput& error) {
    throw core::InvalidInput(std::string("unmeasured: ") + error.what());
  }
}

/// What is known of torques, as it is given. Without a configuration a payload of the calibration is left out.
struct TorqueArguments {
  const NoiseArgument& noise;
  const FreedomArgument& freedom;
  const std::optional<RestArgument>& rest;
  int sign;
  const std::vector<JointArgument>& unmeasured;
};

inline void set_torques(const world::Model& model, const TorqueArguments& given, sensing::SenseOptions& options) {
  const int n = static_cast<int>(model.n_a());
  if (const auto* number = std::get_if<double>(&given.noise))
    options.noise = *number;
  else if (const auto* vector = std::get_if<VectorAlone>(&given.noise))
    options.torques.covariance = sensing::make_covariance(vector->value, n, options.noise);
  else
    options.torques.covariance = sensing::make_covariance(std::get<MatrixAlone>(given.noise).value, n, options.noise);
  if (given.rest) {
    if (const auto* vector = std::get_if<Vector>(&*given.rest))
      options.torques.rest = vector->named("rest");
    else
      options.torques.rest = std::get<Calibrated>(*given.rest).values.rest;
  }
  if (given.freedom) {
    Eigen::VectorXd freedom = std::holds_alternative<double>(*given.freedom)
                                  ? Eigen::VectorXd::Constant(n, std::get<double>(*given.freedom))
                                  : std::get<VectorAlone>(*given.freedom).value;
    for (const double x : freedom) core::require_positive("freedom", x);
    options.torques.deviations = freedom.unaryExpr([](double x) { return sensing::calc_student_bound(x, sensing::kDeviations); });
  }
  options.torques.sign = given.sign;
  for (const JointArgument& joint : given.unmeasured) options.torques.unmeasured.push_back(find_unmeasured(model, joint));
  options.torques.validate(n);
}

}  // namespace stiction::python
