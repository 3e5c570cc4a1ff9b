#pragma once

namespace stiction::execution {

/// An object has fallen if it is this far below every place in which it was or is planned to be [L of the object].
inline constexpr double kFall = 1;

}  // namespace stiction::execution
