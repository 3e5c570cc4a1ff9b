#pragma once

#include <Eigen/Core>
#include <new>
#include <vector>

namespace stiction::cone {

/// A matrix of Rows × n numbers whose n can change without heap use up to the largest n so far.
/// Reads like any Eigen matrix (it is a Map onto its own memory).
template <int Rows>
class Columns : public Eigen::Map<Eigen::Matrix<double, Rows, Eigen::Dynamic>> {
 public:
  using Map = Eigen::Map<Eigen::Matrix<double, Rows, Eigen::Dynamic>>;
  Columns() : Map(nullptr, Rows, 0) {}
  Columns(const Columns& other) : Map(nullptr, Rows, 0), storage_(other.storage_) { seat(other.cols()); }
  Columns& operator=(const Columns& other) {
    storage_ = other.storage_;
    seat(other.cols());
    return *this;
  }
  void resize_columns(Eigen::Index n) {
    if (static_cast<std::size_t>(n * Rows) > storage_.size()) storage_.resize(static_cast<std::size_t>(n * Rows));
    seat(n);
  }

 private:
  void seat(Eigen::Index n) { new (static_cast<Map*>(this)) Map(storage_.data(), Rows, n); }
  std::vector<double> storage_;
};

/// The same for a vector of n numbers.
class Numbers : public Eigen::Map<Eigen::VectorXd> {
 public:
  using Map = Eigen::Map<Eigen::VectorXd>;
  Numbers() : Map(nullptr, 0) {}
  Numbers(const Numbers& other) : Map(nullptr, 0), storage_(other.storage_) { seat(other.size()); }
  Numbers& operator=(const Numbers& other) {
    storage_ = other.storage_;
    seat(other.size());
    return *this;
  }
  void resize_numbers(Eigen::Index n) {
    if (static_cast<std::size_t>(n) > storage_.size()) storage_.resize(static_cast<std::size_t>(n));
    seat(n);
  }

 private:
  void seat(Eigen::Index n) { new (static_cast<Map*>(this)) Map(storage_.data(), n); }
  std::vector<double> storage_;
};

}  // namespace stiction::cone
