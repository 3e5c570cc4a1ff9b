#pragma once

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "stiction/core/invalid_input.hpp"

// Arguments that NumPy can turn into an array of real numbers: arrays of any type and layout, lists, tuples.
// Series over time have the time first, (time, n): rows here, columns in C++.

namespace stiction::python {

/// An array of a number of dimensions. One of another number is taken too, so that the message about it can name the argument.
template <class Value, int dimensions>
class ArrayOf {
 public:
  /// @throws core::InvalidInput "NAME: got an array of shape …, expected …"
  const Value& named(std::string_view name) const {
    if (!shape.empty())
      core::throw_invalid(name, "an array of shape " + shape,
                          dimensions == 1   ? "one dimension, a number each"
                          : dimensions == 2 ? "two dimensions, a row each"
                                            : "three dimensions, a series each");
    return value;
  }

  Value value;        ///< for the caster; others call named()
  std::string shape;  ///< of an array with another number of dimensions
};

using Vector = ArrayOf<Eigen::VectorXd, 1>;
using Matrix = ArrayOf<Eigen::MatrixXd, 2>;

/// The same in a variant, where another alternative takes arrays of other dimensions.
struct VectorAlone {
  Eigen::VectorXd value;
};
struct MatrixAlone {
  Eigen::MatrixXd value;
};

/// N series of T vectors of n numbers, an array (N, T, n): a series is a column, its vectors one after the other.
struct SeriesColumns {
  Eigen::MatrixXd columns;  ///< (n·T × N)
  long steps = 0;           ///< T
  long size = 0;            ///< n
};
using Series = ArrayOf<SeriesColumns, 3>;

/// Python's bool, or NumPy's, which is another type; nothing else that could stand for one.
struct Flag {
  bool value = false;
  operator bool() const { return value; }
};

/// Whether NumPy's type of this name is the type of the value, and not one that it is a base of.
inline bool is_numpy(nanobind::handle value, const char* name) noexcept {
  PyObject* const type = reinterpret_cast<PyObject*>(Py_TYPE(value.ptr()));
  const auto is = [type](const char* attribute, const char* expected) {
    PyObject* const text = PyObject_GetAttrString(type, attribute);
    if (text == nullptr) PyErr_Clear();
    const bool same = text != nullptr && PyUnicode_Check(text) && PyUnicode_CompareWithASCIIString(text, expected) == 0;
    Py_XDECREF(text);
    return same;
  };
  return is("__name__", name) && is("__module__", "numpy");
}

inline bool is_bool(nanobind::handle value) noexcept {
  return PyBool_Check(value.ptr()) || is_numpy(value, "bool") || is_numpy(value, "bool_");
}

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// (n × time) as (time, n).
inline Rows rows(const Eigen::MatrixXd& columns) { return columns.transpose(); }

/// A number of each, as an array.
template <class Range, class Get>
Eigen::VectorXd vector_of(const Range& range, Get get) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(std::size(range)));
  Eigen::Index at = 0;
  for (const auto& item : range) out[at++] = get(item);
  return out;
}
inline Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// Vectors of one size, one a row. @param size  of each, for the shape without any
template <class Range, class Get>
Rows rows(const Range& range, Eigen::Index size, Get get) {
  Rows out(static_cast<Eigen::Index>(std::size(range)), size);
  Eigen::Index at = 0;
  for (const auto& item : range) out.row(at++) = get(item);
  return out;
}

/// The array as NumPy reads it, or an empty object (and no Python error) where it cannot, or where numbers are complex or words.
inline nanobind::object as_array(nanobind::handle source) noexcept {
  try {
    nanobind::module_ numpy = nanobind::module_::import_("numpy");
    if (nanobind::cast<bool>(numpy.attr("ma").attr("is_masked")(source))) return {};  // numbers that are not there
    const nanobind::object array = numpy.attr("asarray")(source);
    const auto kind = nanobind::cast<std::string_view>(array.attr("dtype").attr("kind"));
    if (std::string_view("biufO").find(kind) == std::string_view::npos) return {};
    return numpy.attr("asarray")(array, nanobind::arg("dtype") = numpy.attr("float64"), nanobind::arg("order") = "F");
  } catch (nanobind::python_error& error) {
    // A caster cannot raise: what a signal raised meanwhile is raised again where Python goes on.
    const auto raise = [](void*) {
      PyErr_SetNone(PyExc_KeyboardInterrupt);
      return -1;
    };
    if (error.matches(PyExc_KeyboardInterrupt)) Py_AddPendingCall(raise, nullptr);
    return {};
  } catch (...) {
    PyErr_Clear();
    return {};
  }
}

/// Copies an array of `T` into `out`, by way of NumPy unless it already has the right layout.
template <class T>
bool read_array(nanobind::handle source, T& out) noexcept {
  nanobind::detail::make_caster<T> caster;
  const bool plain = is_numpy(source, "ndarray");  // a masked array is another type, of the same layout
  if (!plain || !caster.from_python(source, 0, nullptr)) {
    const nanobind::object array = as_array(source);
    if (!array.is_valid() || !caster.from_python(array, 0, nullptr)) return false;
  }
  out = std::move(caster.value);
  return true;
}

inline bool read_array(nanobind::handle source, SeriesColumns& out) noexcept {
  nanobind::detail::make_caster<nanobind::ndarray<const double, nanobind::ndim<3>, nanobind::device::cpu>> caster;
  const nanobind::object array = as_array(source);
  if (!array.is_valid() || !caster.from_python(array, 0, nullptr)) return false;
  const auto& a = caster.value;
  out.steps = static_cast<long>(a.shape(1));
  out.size = static_cast<long>(a.shape(2));
  out.columns.resize(out.steps * out.size, static_cast<Eigen::Index>(a.shape(0)));
  for (Eigen::Index i = 0; i < out.columns.cols(); ++i) {
    for (long t = 0; t < out.steps; ++t) {
      for (long k = 0; k < out.size; ++k) out.columns(t * out.size + k, i) = a.data()[i * a.stride(0) + t * a.stride(1) + k * a.stride(2)];
    }
  }
  return true;
}

/// Shape of what NumPy reads as an array of real numbers, as text; nothing where it has `dimensions`, or is no such array.
inline std::optional<std::string> find_other_shape(nanobind::handle source, int dimensions) noexcept {
  try {
    const nanobind::object array = as_array(source);
    if (!array.is_valid() || nanobind::cast<int>(array.attr("ndim")) == dimensions) return std::nullopt;
    const nanobind::object shape = array.attr("shape");
    return std::string(nanobind::repr(shape).c_str());
  } catch (...) {
    PyErr_Clear();
    return std::nullopt;
  }
}

/// False, and not what merely counts as false.
inline bool is_false(nanobind::handle value) noexcept { return is_bool(value) && PyObject_IsTrue(value.ptr()) == 0; }

}  // namespace stiction::python

namespace nanobind::detail {

template <class T>
struct array_like_caster {
  NB_TYPE_CASTER(T, const_name("numpy.typing.ArrayLike"))

  bool from_python(handle source, std::uint32_t, cleanup_list*) noexcept {
    return !source.is_none() && stiction::python::read_array(source, value.value);
  }
};

template <class Numbers, int dimensions>
struct type_caster<stiction::python::ArrayOf<Numbers, dimensions>> {
  using Array = stiction::python::ArrayOf<Numbers, dimensions>;
  NB_TYPE_CASTER(Array, const_name("numpy.typing.ArrayLike"))

  bool from_python(handle source, std::uint32_t, cleanup_list*) noexcept {
    if (source.is_none()) return false;
    if (stiction::python::read_array(source, value.value)) return true;
    const auto shape = stiction::python::find_other_shape(source, dimensions);
    if (shape) value.shape = *shape;
    return shape.has_value();
  }
};

template <>
struct type_caster<stiction::python::Flag> {
  NB_TYPE_CASTER(stiction::python::Flag, const_name("bool | numpy.bool_"))

  bool from_python(handle source, std::uint32_t, cleanup_list*) noexcept {
    if (!stiction::python::is_bool(source)) return false;
    const int truth = PyObject_IsTrue(source.ptr());
    if (truth < 0) PyErr_Clear();
    value.value = truth == 1;
    return truth >= 0;
  }
};

template <>
struct type_caster<stiction::python::VectorAlone> : array_like_caster<stiction::python::VectorAlone> {};
template <>
struct type_caster<stiction::python::MatrixAlone> : array_like_caster<stiction::python::MatrixAlone> {};

}  // namespace nanobind::detail
