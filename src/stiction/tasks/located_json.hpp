#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "stiction/core/invalid_input.hpp"

namespace stiction::tasks {

/// A JSON value that knows its place in the file, for messages "FILE: field: got …, expected …". The place is put into words only for a
/// message, because a plan has a million values.
class LocatedJson {
 public:
  LocatedJson(const nlohmann::ordered_json& node, const std::string& file, const LocatedJson* parent, std::string_view key, long index)
      : node_(&node), file_(&file), parent_(parent), key_(key), index_(index) {}

  [[noreturn]] void fail(std::string_view got, std::string_view expected) const {
    core::throw_invalid(fmt::format("{}: {}", *file_, path()), got, expected);
  }
  [[noreturn]] void fail(std::string_view expected) const { fail(describe(), expected); }

  bool is_null() const { return node_->is_null(); }
  const nlohmann::ordered_json& node() const { return *node_; }

  /// Requires an object with these keys and no others except the optional ones.
  void require_keys(std::initializer_list<std::string_view> keys, std::initializer_list<std::string_view> optional = {}) const {
    if (!node_->is_object()) fail("an object");
    for (const auto key : keys) {
      if (!node_->contains(key)) fail(fmt::format("no '{}'", key), "this key");
    }
    if (node_->size() == keys.size()) return;
    for (const auto& [key, unused] : node_->items()) {
      const auto is_in = [&](std::initializer_list<std::string_view> names) {
        return std::find(names.begin(), names.end(), key) != names.end();
      };
      if (!is_in(keys) && !is_in(optional)) fail(fmt::format("unknown key '{}'", key), fmt::format("only {}", fmt::join(keys, ", ")));
    }
  }
  bool has(std::string_view key) const { return node_->is_object() && node_->contains(key); }
  LocatedJson at(std::string_view key) const {
    if (!has(key)) fail(fmt::format("no '{}'", key), "this key");
    return {(*node_)[std::string(key)], *file_, this, key, -1};
  }
  std::size_t size() const {
    if (!node_->is_array()) fail("a list");
    return node_->size();
  }
  LocatedJson operator[](std::size_t i) const { return {(*node_)[i], *file_, this, {}, static_cast<long>(i)}; }
  template <class Each>
  void each(Each&& body) const {
    for (std::size_t i = 0, n = size(); i < n; ++i) body((*this)[i]);
  }

  double number() const {
    if (!node_->is_number()) fail("a number");
    const double value = node_->get<double>();
    if (!std::isfinite(value)) fail("a finite number");
    return value;
  }
  double positive() const {
    const double value = number();
    if (!(value > 0)) fail("a number > 0");
    return value;
  }
  double nonnegative() const {
    const double value = number();
    if (!(value >= 0)) fail("a number ≥ 0");
    return value;
  }
  long integer(long low = 0, long high = std::numeric_limits<long>::max()) const {
    if (!node_->is_number_integer() || (node_->is_number_unsigned() && node_->get<std::uint64_t>() > static_cast<std::uint64_t>(high)) ||
        node_->get<long>() < low || node_->get<long>() > high) {
      fail(fmt::format("an integer in [{}, {}]", low, high));
    }
    return node_->get<long>();
  }
  std::uint64_t seed() const {
    if (!node_->is_number_unsigned()) fail("an integer ≥ 0");
    return node_->get<std::uint64_t>();
  }
  bool boolean() const {
    if (!node_->is_boolean()) fail("true or false");
    return node_->get<bool>();
  }
  const std::string& string() const {
    if (!node_->is_string()) fail("a string");
    return node_->get_ref<const std::string&>();
  }
  template <std::size_t N>
  std::size_t one_of(const std::array<std::string_view, N>& names) const {
    const std::string& value = string();
    for (std::size_t i = 0; i < N; ++i) {
      if (names[i] == value) return i;
    }
    fail(fmt::format("one of {}", fmt::join(names, ", ")));
  }
  void numbers(std::size_t n, double* out) const {
    if (!node_->is_array()) fail(fmt::format("a list of {} numbers", n));
    if (node_->size() != n) fail(fmt::format("{} numbers", node_->size()), fmt::format("{}", n));
    for (std::size_t i = 0; i < n; ++i) out[i] = (*this)[i].number();
  }
  Eigen::VectorXd vector(std::size_t n) const {
    Eigen::VectorXd out(static_cast<Eigen::Index>(n));
    numbers(n, out.data());
    return out;
  }
  Eigen::Vector3d vector3() const { return vector(3); }
  /// Reads n numbers; null stands for infinity with this sign.
  Eigen::VectorXd bounds(std::size_t n, double sign) const {
    if (size() != n) fail(fmt::format("{} numbers", size()), fmt::format("{}", n));
    Eigen::VectorXd out(static_cast<Eigen::Index>(n));
    for (std::size_t i = 0; i < n; ++i) {
      const LocatedJson value = (*this)[i];
      out[static_cast<Eigen::Index>(i)] = value.is_null() ? sign * std::numeric_limits<double>::infinity() : value.number();
    }
    return out;
  }

 private:
  std::string path() const {
    if (parent_ == nullptr) return "top level";
    std::string before = parent_->parent_ == nullptr ? "" : parent_->path();
    if (index_ >= 0) return fmt::format("{}[{}]", before, index_);
    return before.empty() ? std::string(key_) : fmt::format("{}.{}", before, key_);
  }
  std::string describe() const {
    if (node_->is_array()) return fmt::format("a list of {}", node_->size());
    if (node_->is_object()) return "an object";
    const std::string text = node_->dump();
    return text.size() > 60 ? text.substr(0, 57) + "…" : text;
  }

  const nlohmann::ordered_json* node_;
  const std::string* file_;
  const LocatedJson* parent_;
  std::string_view key_;
  long index_;
};

}  // namespace stiction::tasks
