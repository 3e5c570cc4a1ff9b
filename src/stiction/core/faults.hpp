#pragma once

#include <string>

#include "stiction/core/invalid_input.hpp"

namespace stiction::core {

/// Mistakes of the caller that are told together: what reads a file goes on behind each of them.
class Faults {
 public:
  /// Keeps what `read` complains about. @returns false if it does
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

  void add(const std::string& message) { text_ += (text_.empty() ? "" : "\n") + message; }

  bool none() const { return text_.empty(); }

  /// @throws InvalidInput with a line for each fault, if there is one
  void raise() const {
    if (!none()) throw InvalidInput(text_);
  }

 private:
  std::string text_;
};

}  // namespace stiction::core
