#pragma once

#include <Eigen/Core>

#include "stiction/core/random.hpp"
#include "stiction/sensing/contact_rows.hpp"
#include "stiction/simulation/momentum_observer.hpp"

namespace stiction::execution {

/// Noise of a force and moment sensor under the base of an arm, with which it measures the effect of contacts. Standard deviations of each component.
struct BaseSensorOptions {
  double force_noise = 1;     ///< white noise of the measured force [N], > 0
  double moment_noise = 0.1;  ///< white noise of the measured moment [N·m], > 0
  double force_offset = 0;    ///< offset of the force, from the sensor and from errors of masses and accelerations [N], ≥ 0
  double moment_offset = 0;   ///< offset of the moment, likewise [N·m], ≥ 0
  void validate() const;      ///< @throws core::InvalidInput naming the field
};

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Force and moment sensor under the base of a simulated arm. Its noise is white noise behind the lag of a MomentumObserver, and its offsets change with the
/// posture as those of the observer's torques do.
/// Tests: tests/execution/base_sensor_test.cpp
class BaseSensor {
 public:
  /// @param joints  n_a   @param period  h [s], > 0   @param torques  observer whose lag, distance over which offsets change, and seed are also used here
  BaseSensor(Eigen::Index joints, double period, const simulation::ObserverOptions& torques, const BaseSensorOptions& options);

  /// Measures at the end of a period. @param wrench_W  DrivenPlant::base_wrench() at its end   @param q  joint positions (n_a)
  const sensing::BaseWrench& update(const Vector6& wrench_W, const Eigen::Ref<const Eigen::VectorXd>& q);

 private:
  double gain_;
  Vector6 white_, cosine_, sine_, noise_ = Vector6::Zero();  ///< noise deviations before the lag; amplitudes of offsets; present noise
  Eigen::MatrixXd waves_;                                    ///< wave numbers of the offsets (6 × n_a) [1/rad; 1/m]
  core::Random random_;
  sensing::BaseWrench measured_;
};

}  // namespace stiction::execution
