#pragma once

#include "bindings.hpp"

namespace stiction::python {

void bind_run(nb::module_& m);

}  // namespace stiction::python
