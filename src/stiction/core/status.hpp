#pragma once

#include <string_view>

namespace stiction::core {

/// Outcome of a numerical procedure. Caller mistakes are InvalidInput, never a Status.
enum class [[nodiscard]] Status{
    Solved,            ///< the stated tolerance holds
    MaxIterations,     ///< stopped at the iteration, node or time budget; the best result so far is returned
    Infeasible,        ///< proved by a certificate
    NumericalFailure,  ///< arithmetic broke down; results are not to be used
    Cancelled,         ///< the caller asked to stop; the best result so far is returned
};

std::string_view to_string(Status status) noexcept;

}  // namespace stiction::core
