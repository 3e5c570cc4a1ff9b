#pragma once

#include <array>
#include <boost/pfr.hpp>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "bindings.hpp"
#include "stiction/core/version.hpp"
#include "stiction/dynamics/local_model.hpp"
#include "stiction/tasks/lint.hpp"
#include "stiction/world/robot_tree.hpp"
#include "stiction/world/yaml.hpp"

// Values are pickled and copied as the bytes of all their fields. boost::pfr lists the fields, so that a new one cannot be forgotten. Models, sensors,
// plans and tasks that a value shares with others are Python objects beside the bytes: pickle writes each of them once.

namespace stiction::sensing {
class FrictionCone;
class Sensor;
}  // namespace stiction::sensing
namespace stiction::tasks {
struct Task;
}

namespace stiction::python {

class Sensor;
struct Plan;

namespace pickles {

template <class T, template <class...> class Template>
inline constexpr bool is_a = false;
template <class... Arguments, template <class...> class Template>
inline constexpr bool is_a<Template<Arguments...>, Template> = true;

template <class T>
inline constexpr bool is_array = false;
template <class T, std::size_t n>
inline constexpr bool is_array<std::array<T, n>> = true;

/// Held by Python, where pickle knows what it has written already.
template <class T>
inline constexpr bool is_shared_with_python = std::is_same_v<T, world::Model> || std::is_same_v<T, sensing::Sensor> ||
                                              std::is_same_v<T, Sensor> || std::is_same_v<T, Plan> || std::is_same_v<T, tasks::Task>;

template <class T>
inline constexpr bool is_plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Equal values have equal bytes: −0.0 is written as 0.0.
template <class T>
T without_minus_zero(T value) {
  if constexpr (std::is_floating_point_v<T>) return value + T{0};
  return value;
}

class Writer {
 public:
  template <class T>
  void put(const T& value) {
    if constexpr (is_plain<T>) {
      const T number = without_minus_zero(value);
      put_bytes(&number, sizeof number);
    } else if constexpr (std::is_same_v<T, std::string>) {
      put(value.size());
      put_bytes(value.data(), value.size());
    } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
      put(value.string());
    } else if constexpr (std::is_base_of_v<Eigen::EigenBase<T>, T>) {
      put(value.rows());
      put(value.cols());
      const T numbers = value.unaryExpr([](auto number) { return without_minus_zero(number); });
      put_bytes(numbers.data(), static_cast<std::size_t>(numbers.size()) * sizeof(typename T::Scalar));
    } else if constexpr (is_a<T, std::vector>) {
      put(value.size());
      for (const auto& item : value) put<typename T::value_type>(item);
    } else if constexpr (is_array<T>) {
      for (const auto& item : value) put(item);
    } else if constexpr (is_a<T, std::pair>) {
      put(value.first);
      put(value.second);
    } else if constexpr (is_a<T, std::optional>) {
      put(value.has_value());
      if (value) put(*value);
    } else if constexpr (is_a<T, std::variant>) {
      put(value.index());
      std::visit([this](const auto& which) { put(which); }, value);
    } else if constexpr (is_a<T, std::shared_ptr>) {
      put_shared(value);
    } else if constexpr (std::is_same_v<T, world::YamlNode>) {
      // What lint reads of a file stays with the file.
    } else if constexpr (std::is_same_v<T, tasks::Finding>) {
      put_all(value.kind, value.message, value.where, value.names, value.p_W, value.amount);  // boost::pfr takes no optional vector
    } else if constexpr (std::is_same_v<T, dynamics::ImpulseDerivatives>) {
      put(value.size());
      for (std::size_t i = 0; i < value.size(); ++i) put(Eigen::MatrixXd(value[i]));
    } else if constexpr (std::is_same_v<T, sensing::FrictionCone>) {
      put(value.friction());
      put(value.is_lorentz() ? 0 : value.rays());
    } else if constexpr (std::is_base_of_v<dynamics::Sampling, T> && !std::is_same_v<dynamics::Sampling, T>) {
      put<dynamics::Sampling>(value);
    } else {
      static_assert(std::is_aggregate_v<T>, "no value: its fields cannot be listed");
      boost::pfr::for_each_field(value, [this](const auto& field) { put(field); });
    }
  }

  template <class... Fields>
  void put_all(const Fields&... fields) {
    (put(fields), ...);
  }

  nb::tuple state() const {
    nb::list objects;
    for (const nb::object& object : objects_) objects.append(object);
    return nb::make_tuple(std::string(core::version()), nb::bytes(bytes_.data(), bytes_.size()), objects);
  }

 private:
  void put_bytes(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }

  /// What values share is written once.
  template <class T>
  void put_shared(const std::shared_ptr<T>& pointer) {
    if (!pointer) return put(std::size_t{0});
    const auto [at, is_new] = numbers_.try_emplace(pointer.get(), numbers_.size() + 1);
    put(at->second);
    if (!is_new) return;
    if constexpr (is_shared_with_python<std::remove_const_t<T>>) {
      objects_.push_back(nb::cast(pointer));
    } else {
      put(*pointer);
    }
  }

  std::string bytes_;
  std::map<const void*, std::size_t> numbers_;  ///< of what pointers point to, from 1
  std::vector<nb::object> objects_;
};

class Reader {
 public:
  /// @throws core::InvalidInput: of another version
  explicit Reader(const nb::tuple& state) {
    if (state.size() != 3) core::throw_invalid("pickle", "another state", "one that was written by pickle");
    const auto version = nb::cast<std::string>(state[0]);
    if (version != core::version())
      core::throw_invalid("pickle", "a value of stiction " + version, "one of this version, " + std::string(core::version()));
    bytes_ = nb::cast<nb::bytes>(state[1]);
    objects_ = nb::cast<nb::list>(state[2]);
  }

  template <class T>
  T get() {
    T value{};
    get_into(value);
    return value;
  }

  template <class T>
  void get_into(T& value) {
    if constexpr (is_plain<T>) {
      get_bytes(&value, sizeof value);
    } else if constexpr (std::is_same_v<T, std::string>) {
      value.resize(get_size());
      get_bytes(value.data(), value.size());
    } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
      value = get<std::string>();
    } else if constexpr (std::is_base_of_v<Eigen::EigenBase<T>, T>) {
      const auto rows = get<Eigen::Index>(), cols = get<Eigen::Index>();
      value.resize(rows, cols);
      get_bytes(value.data(), static_cast<std::size_t>(value.size()) * sizeof(typename T::Scalar));
    } else if constexpr (is_a<T, std::vector>) {
      const std::size_t size = get_size();
      value.clear();
      value.reserve(size);
      for (std::size_t i = 0; i < size; ++i) value.push_back(get<typename T::value_type>());
    } else if constexpr (is_array<T>) {
      for (auto& item : value) get_into(item);
    } else if constexpr (is_a<T, std::pair>) {
      get_into(value.first);
      get_into(value.second);
    } else if constexpr (is_a<T, std::optional>) {
      value.reset();
      if (get<bool>()) value = get<typename T::value_type>();
    } else if constexpr (is_a<T, std::variant>) {
      get_alternative(value, get_size(), std::make_index_sequence<std::variant_size_v<T>>());
    } else if constexpr (is_a<T, std::shared_ptr>) {
      get_shared(value);
    } else if constexpr (std::is_same_v<T, world::YamlNode>) {
      value = {};
    } else if constexpr (std::is_same_v<T, tasks::Finding>) {
      get_all(value.kind, value.message, value.where, value.names, value.p_W, value.amount);
    } else if constexpr (std::is_same_v<T, dynamics::ImpulseDerivatives>) {
      const std::size_t size = get_size();
      for (std::size_t i = 0; i < size; ++i) {
        const auto block = get<Eigen::MatrixXd>();
        if (i == 0) value.resize(size, block.cols());
        value[i] = block;
      }
    } else if constexpr (std::is_same_v<T, sensing::FrictionCone>) {
      const auto friction = get<double>();
      value = T(friction, get<int>());
    } else if constexpr (std::is_base_of_v<dynamics::Sampling, T> && !std::is_same_v<dynamics::Sampling, T>) {
      get_into<dynamics::Sampling>(value);
    } else {
      boost::pfr::for_each_field(value, [this](auto& field) { get_into(field); });
    }
  }

  template <class... Fields>
  void get_all(Fields&... fields) {
    (get_into(fields), ...);
  }

 private:
  void get_bytes(void* out, std::size_t size) {
    if (size > bytes_.size() - at_) core::throw_invalid("pickle", "a state that is cut off", "one that was written by pickle");
    std::memcpy(out, static_cast<const char*>(bytes_.data()) + at_, size);
    at_ += size;
  }

  std::size_t get_size() {
    const auto size = get<std::size_t>();
    if (size > bytes_.size()) core::throw_invalid("pickle", "a state that is cut off", "one that was written by pickle");
    return size;
  }

  template <class... Alternatives, std::size_t... index>
  void get_alternative(std::variant<Alternatives...>& value, std::size_t which, std::index_sequence<index...>) {
    ((index == which ? void(value = get<Alternatives>()) : void()), ...);
  }

  template <class T>
  void get_shared(std::shared_ptr<T>& pointer) {
    const std::size_t number = get_size();
    if (number == 0) return pointer.reset();
    if (number <= pointers_.size()) {
      pointer = std::static_pointer_cast<T>(std::const_pointer_cast<void>(pointers_[number - 1]));
      return;
    }
    if constexpr (is_shared_with_python<std::remove_const_t<T>>) {
      pointer = nb::cast<std::shared_ptr<T>>(objects_[next_object_++]);
      pointers_.push_back(pointer);
    } else {
      const std::size_t own = pointers_.size();
      pointers_.push_back(nullptr);
      pointer = std::make_shared<std::remove_const_t<T>>(get<std::remove_const_t<T>>());
      pointers_[own] = pointer;
    }
  }

  nb::bytes bytes_;
  nb::list objects_;
  std::size_t at_ = 0, next_object_ = 0;
  std::vector<std::shared_ptr<const void>> pointers_;
};

}  // namespace pickles

/// Adds a method to a class that is bound already.
template <class T, class Function, class... Extra>
void add_method(const char* name, Function function, const Extra&... extra) {
  const nb::handle type = nb::type<T>();
  nb::cpp_function_def<T>(std::move(function), nb::scope(type), nb::name(name), nb::is_method(), extra...);
}

/// pickle and copy take values of these classes.
template <class... Types>
void def_pickle() {
  const auto def = []<class T>(std::type_identity<T>) {
    add_method<T>(
        "__getstate__",
        [](const T& self) {
          pickles::Writer writer;
          writer.put(self);
          return writer.state();
        },
        nb::sig("def __getstate__(self) -> tuple"));
    add_method<T>(
        "__setstate__", [](T& self, const nb::tuple& state) { new (&self) T(pickles::Reader(state).get<T>()); },
        nb::sig("def __setstate__(self, state: tuple, /) -> None"));
  };
  (def(std::type_identity<Types>()), ...);
}

/// Of what many values share and nothing changes: a copy is the object itself.
template <class T>
void def_shared_copy() {
  add_method<T>(
      "__copy__", [](nb::handle self) { return nb::borrow(self); }, nb::sig("def __copy__(self) -> typing.Self"));
  add_method<T>(
      "__deepcopy__", [](nb::handle self, nb::handle) { return nb::borrow(self); }, nb::arg("memo"),
      nb::sig("def __deepcopy__(self, memo: object, /) -> typing.Self"));
}

/// Of what is at work: pickle and copy are refused, and the message names what to pass in its place.
template <class T>
void def_no_pickle(const char* name, const char* instead) {
  add_method<T>(
      "__reduce__",
      [name, instead](const T&) -> nb::object {
        throw nb::type_error((std::string(name) + ": got pickle or copy, expected " + instead).c_str());
      },
      nb::sig("def __reduce__(self) -> tuple"));
}

}  // namespace stiction::python
