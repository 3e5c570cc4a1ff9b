#include "stiction/core/status.hpp"

namespace stiction::core {

std::string_view to_string(Status status) noexcept {
  switch (status) {
    case Status::Solved:
      return "Solved";
    case Status::MaxIterations:
      return "MaxIterations";
    case Status::Infeasible:
      return "Infeasible";
    case Status::NumericalFailure:
      return "NumericalFailure";
    case Status::Cancelled:
      return "Cancelled";
  }
  return "?";
}

}  // namespace stiction::core
