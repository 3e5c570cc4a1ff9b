#pragma once

#include <exception>

#include "bindings.hpp"
#include "stiction/execution/closed_loop/driver.hpp"

namespace stiction::python {

/// A robot behind an object of Python's with read() and command(u, period); an error in them ends the run and is that of the call.
class OwnPlant final : public execution::Driver {
 public:
  /// @throws core::InvalidInput: no calls, or a real_time that is not a bool
  explicit OwnPlant(nb::object driver);
  bool read(execution::Measurement& out) override;
  bool command(execution::VectorRef u, double period) override;
  bool real_time() const override { return real_time_; }
  std::string message() const override { return message_; }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  template <class Call>
  bool ask(const Call& call);

  nb::object driver_;
  bool real_time_ = false;
  std::string message_;
  std::exception_ptr error_;
};

void bind_plants(nb::module_& m);

}  // namespace stiction::python
