#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "bindings.hpp"
#include "stiction/sensing/calibrate.hpp"
#include "stiction/sensing/scenario.hpp"

namespace stiction::python {

using SensorPtr = std::shared_ptr<const sensing::Sensor>;

/// sensing::Sensor with workspaces that calls borrow, so that any number of threads may share it.
class Sensor {
 public:
  explicit Sensor(SensorPtr sensor) : sensor_(std::move(sensor)) {}

  const sensing::Sensor& get() const { return *sensor_; }
  const SensorPtr& ptr() const { return sensor_; }
  const world::Model& model() const { return sensor_->model(); }

  class Borrowed {
   public:
    explicit Borrowed(Sensor& owner) : owner_(owner), work_(owner.take()) {}
    ~Borrowed() { owner_.put(std::move(work_)); }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    sensing::SenseWorkspace& work() { return work_; }

   private:
    Sensor& owner_;
    sensing::SenseWorkspace work_;
  };

 private:
  sensing::SenseWorkspace take();
  void put(sensing::SenseWorkspace&& work);

  SensorPtr sensor_;
  std::mutex mutex_;
  std::vector<sensing::SenseWorkspace> idle_;
};

struct SensedLink {
  SensorPtr sensor;
  int index;
  const sensing::SensedLink& get() const { return sensor->links()[static_cast<std::size_t>(index)]; }
};

/// What one measurement says, with the sensor that gives its links names.
struct SenseResult {
  SensorPtr sensor;
  sensing::SenseResult result;
};

/// The same of contacts at the same time.
struct ContactSets {
  SensorPtr sensor;
  sensing::ContactSetResult result;
};

/// What rows at rest say, with the model that gives its link a name.
struct Calibrated {
  ModelPtr model;
  sensing::Calibration values;
};

/// Where the robots are: a configuration (n_q), or joint positions alone (n_a) with objects at their placed frames.
/// @throws core::InvalidInput by the name of the argument
Eigen::VectorXd configuration_of(const world::Model& model, const std::string& name, Eigen::Ref<const Eigen::VectorXd> q);

/// One measurement. @param last  of the cycle before, or null
SenseResult sense(Sensor& sensor, const Eigen::VectorXd& q, const Eigen::VectorXd& tau, const SenseResult* last,
                  const sensing::SenseOptions& options);

/// One after the other, each from the candidates of the one before, until `control` stops it.
/// @param q, tau  one column a moment  @param gaps  moments that start afresh
std::vector<SenseResult> sense_series(Sensor& sensor, const Eigen::MatrixXd& q, const Eigen::MatrixXd& tau,
                                      const sensing::SenseOptions& options, const core::RunControl& control,
                                      const std::vector<int>& gaps = {});

/// Contacts at the same time. @param base, last  wrench at the base and the cycle before, or null
ContactSets sense_contacts(const Sensor& sensor, const Eigen::VectorXd& q, const Eigen::VectorXd& tau, const sensing::BaseWrench* base,
                           const ContactSets* last, const sensing::ContactSetOptions& options);

void bind_contact_sets(nb::module_& m, nb::class_<Sensor>& sensor);
void bind_sense_results(nb::module_& m);
void bind_calibration(nb::module_& m);
void bind_observer(nb::module_& m);
void bind_sensing_scenario(nb::module_& m);

}  // namespace stiction::python
