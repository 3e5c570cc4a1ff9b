#pragma once

#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::core {

/// Collects mistakes of the caller so that they are reported together: the reader of a file continues after each of them.
class Faults {
 public:
  /// Calls `read` and keeps the message of an InvalidInput that it throws. @returns false if it throws one
  template <class Read>
  bool collect(Read&& read) {
    try {
      read();
      return true;
    } catch (const InvalidInput& e) {
      add(e.what());
      return false;
    }
  }

  /// Keeps a message, once.
  void add(const std::string& message) {
    if (("\n" + text_ + "\n").find("\n" + message + "\n") == std::string::npos) text_ += (text_.empty() ? "" : "\n") + message;
  }

  bool none() const { return text_.empty(); }

  /// @throws InvalidInput with a line for each fault, if there is one
  void raise() const {
    if (!none()) throw InvalidInput(text_);
  }

 private:
  std::string text_;
};

}  // namespace stiction::core
