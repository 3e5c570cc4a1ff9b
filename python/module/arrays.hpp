#pragma once

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Core>
#include <type_traits>

// Arguments that NumPy can turn into an array: arrays of any type and layout, lists, tuples.

namespace stiction::python {

struct Vector {
  Eigen::VectorXd value;
};

struct Matrix {
  Eigen::MatrixXd value;
};

/// The array as NumPy reads it, or an empty object (and no Python error) where it cannot.
inline nanobind::object as_array(nanobind::handle source) noexcept {
  try {
    nanobind::module_ numpy = nanobind::module_::import_("numpy");
    return numpy.attr("asarray")(source, nanobind::arg("dtype") = numpy.attr("float64"), nanobind::arg("order") = "F");
  } catch (...) {
    PyErr_Clear();
    return {};
  }
}

/// Copies an array of `T` into `out`, by way of NumPy unless it already has the right layout.
template <class T>
bool read_array(nanobind::handle source, T& out) noexcept {
  nanobind::detail::make_caster<T> caster;
  if (!caster.from_python(source, 0, nullptr)) {
    const nanobind::object array = as_array(source);
    if (!array.is_valid() || !caster.from_python(array, 0, nullptr)) return false;
  }
  out = std::move(caster.value);
  return true;
}

}  // namespace stiction::python

namespace nanobind::detail {

template <class T>
struct array_like_caster {
  NB_TYPE_CASTER(T, const_name("numpy.typing.ArrayLike"))

  bool from_python(handle source, std::uint32_t, cleanup_list*) noexcept {
    return !source.is_none() && stiction::python::read_array(source, value.value);
  }
};

template <>
struct type_caster<stiction::python::Vector> : array_like_caster<stiction::python::Vector> {};
template <>
struct type_caster<stiction::python::Matrix> : array_like_caster<stiction::python::Matrix> {};

}  // namespace nanobind::detail
