#include "yaml_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "stiction/world/scene.hpp"

namespace stiction::python {
namespace {

std::string number_text(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  return fmt::format("{}", value);
}

/// The text of a str. Names of files in another encoding have no UTF-8.
std::string utf8(nb::handle text, const std::string& path) {
  Py_ssize_t size = 0;
  const char* bytes = PyUnicode_AsUTF8AndSize(text.ptr(), &size);
  if (bytes != nullptr) return {bytes, static_cast<std::size_t>(size)};
  PyErr_Clear();
  core::throw_invalid(path.empty() ? "top level" : path, fmt::format("{}, which has no UTF-8", nb::repr(text).c_str()),
                      "text in UTF-8; a file beside it may name it by a relative path");
}

/// A JSON string is a YAML one.
std::string quoted(nb::handle text, const std::string& path) {
  return utf8(nb::module_::import_("json").attr("dumps")(text, nb::arg("ensure_ascii") = false), path);
}

std::string pose_text(const world::Pose& X) {
  const Eigen::Quaterniond r(X.R);
  return fmt::format("{{\"position\": [{}, {}, {}], \"quaternion_wxyz\": [{}, {}, {}, {}]}}", X.p[0], X.p[1], X.p[2], r.w(), r.x(), r.y(),
                     r.z());
}

std::string list_text(nb::handle items, const std::string& path) {
  std::string out = "[";
  std::size_t i = 0;
  for (const nb::handle item : items) {
    if (i > 0) out += ", ";
    out += yaml_text(item, fmt::format("{}[{}]", path, i++));
  }
  return out + "]";
}

std::string dict_text(const nb::dict& entries, const std::string& path) {
  std::string out = "{";
  for (const auto& [key, value] : entries) {
    if (!nb::isinstance<nb::str>(key)) {
      core::throw_invalid(path.empty() ? "top level" : path, fmt::format("a key {}", nb::repr(key).c_str()), "words as keys");
    }
    const std::string name = utf8(key, path);
    if (out.size() > 1) out += ", ";
    out += quoted(key, path) + ": " + yaml_text(value, path.empty() ? name : path + "." + name);
  }
  return out + "}";
}

}  // namespace

std::string yaml_text(nb::handle value, const std::string& path) {
  constexpr std::size_t kLongestPath = 4096;  // a list that holds itself has no end
  if (path.size() > kLongestPath) core::throw_invalid(path.substr(0, 32) + "…", "nested values without end", "fewer levels");
  if (value.is_none()) return "null";
  if (nb::isinstance<nb::bool_>(value)) return nb::cast<bool>(value) ? "true" : "false";
  if (nb::isinstance<nb::str>(value)) return quoted(value, path);
  if (nb::isinstance<nb::int_>(value)) return nb::cast<std::string>(nb::str(value));
  if (nb::isinstance<nb::float_>(value)) return number_text(nb::cast<double>(value));
  if (nb::isinstance<nb::dict>(value)) return dict_text(nb::borrow<nb::dict>(value), path);
  if (nb::isinstance<nb::list>(value) || nb::isinstance<nb::tuple>(value)) return list_text(value, path);
  if (nb::isinstance<world::Pose>(value)) return pose_text(nb::cast<const world::Pose&>(value));
  if (nb::hasattr(value, "__fspath__")) return quoted(value.attr("__fspath__")(), path);
  if (nb::hasattr(value, "tolist")) return yaml_text(value.attr("tolist")(), path);  // of NumPy
  core::throw_invalid(path.empty() ? "top level" : path, fmt::format("a value of type {}", nb::type_name(value.type()).c_str()),
                      "None, bool, int, float, str, a path, a Pose, an array, a list or a dict");
}

std::filesystem::path folder_of(const std::optional<std::filesystem::path>& base) {
  return base ? std::filesystem::absolute(*base) : std::filesystem::current_path();
}

}  // namespace stiction::python
