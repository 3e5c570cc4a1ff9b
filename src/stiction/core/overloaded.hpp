#pragma once

namespace stiction::core {

/// One visitor of a variant out of a function for each of its types.
template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

}  // namespace stiction::core
