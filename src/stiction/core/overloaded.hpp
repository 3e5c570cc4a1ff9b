#pragma once

namespace stiction::core {

/// Combines several functions, one for each type of a variant, into one visitor.
template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

}  // namespace stiction::core
