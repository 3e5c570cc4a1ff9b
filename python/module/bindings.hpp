#pragma once

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "arrays.hpp"
#include "stiction/core/invalid_input.hpp"
#include "stiction/core/run_control.hpp"
#include "stiction/dynamics/step.hpp"
#include "stiction/world/model.hpp"

// One function per layer. Names, shapes, units and meaning are those of the C++ headers.

namespace stiction::python {

namespace nb = nanobind;
using namespace nb::literals;

using ModelPtr = std::shared_ptr<const world::Model>;

void bind_world(nb::module_& m);
void bind_visuals(nb::module_& m);
void bind_dynamics(nb::module_& m);
void bind_batch(nb::module_& m);
void bind_simulation(nb::module_& m);
void bind_driven_plant(nb::module_& m);
void bind_tasks(nb::module_& m);
void bind_planning(nb::module_& m);
void bind_trajopt(nb::module_& m);
void bind_solve(nb::module_& m);
void bind_execution(nb::module_& m);
void bind_control(nb::module_& m);
void bind_control_run(nb::module_& m);
void bind_sensing(nb::module_& m);

/// Keeps a workspace or a plant to one thread at a time: steps run without Python's lock, so a second thread could enter.
class Occupied {
 public:
  explicit Occupied(std::atomic<bool>& flag, const char* what = "workspace") : flag_(flag) {
    if (flag_.exchange(true))
      core::throw_invalid(what, "one that another thread is using", std::string("a ") + what + " of this thread alone");
  }
  ~Occupied() { flag_.store(false); }
  Occupied(const Occupied&) = delete;
  Occupied& operator=(const Occupied&) = delete;

 private:
  std::atomic<bool>& flag_;
};

/// `timeout_s` from now. @throws core::InvalidInput: not > 0
inline core::RunControl::Clock::time_point deadline_in(double timeout_s) {
  core::require_positive("timeout_s", timeout_s);
  constexpr double kLongest = 1e8;  // [s], what the clock can count
  return core::RunControl::Clock::now() +
         std::chrono::duration_cast<core::RunControl::Clock::duration>(std::chrono::duration<double>(std::min(timeout_s, kLongest)));
}

/// A contact together with what gives its numbers names and units.
struct StepContact {
  ModelPtr model;
  dynamics::ContactImpulse impulse;
  double h = 0.1;
};

/// None where a matrix was not asked for.
inline std::optional<Eigen::MatrixXd> unless_empty(const Eigen::MatrixXd& matrix) {
  if (matrix.size() == 0) return std::nullopt;
  return matrix;
}

inline std::string name_of_geometry(const world::Model& model, int index) {
  return model.geometries()[static_cast<std::size_t>(index)].name;
}

/// Index of a body, or of a robot's link, by its name. @throws core::InvalidInput with the names that there are
int find_body(const world::Model& model, std::string_view field, const std::string& name);
int find_link(const world::Model& model, std::string_view field, const std::string& name);

/// @throws core::InvalidInput: size, not finite
inline const Eigen::VectorXd& require_vector(std::string_view name, const Vector& vector, long size) {
  const Eigen::VectorXd& value = vector.named(name);
  core::require_size(name, value.size(), size);
  core::require_finite(name, {value.data(), static_cast<std::size_t>(size)});
  return value;
}
inline Eigen::Vector3d require_vector3(std::string_view name, const Vector& vector) { return require_vector(name, vector, 3); }

std::vector<StepContact> with_names(const ModelPtr& model, const std::vector<dynamics::ContactImpulse>& contacts, double h);

}  // namespace stiction::python
