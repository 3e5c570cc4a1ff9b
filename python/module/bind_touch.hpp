#pragma once

#include "bindings.hpp"

namespace stiction::python {

void bind_touch(nb::module_& m);
void bind_guarded(nb::module_& m);

}  // namespace stiction::python
