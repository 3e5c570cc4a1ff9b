#include "stiction/cone/state.hpp"
#include "stiction/core/invalid_input.hpp"

namespace stiction::cone {
namespace detail {

template <int R>
void Bank<R>::resize(int rows) {
  n = rows;
  groups = (rows + 3) / 4;
  if (groups <= static_cast<int>(group.size())) return;
  order.resize(static_cast<std::size_t>(4 * groups));
  group.resize(static_cast<std::size_t>(groups));
}
template struct Bank<1>;
template struct Bank<3>;

int Memory::Rows::find(std::uint64_t wanted, int hint) const {
  for (int i = hint; i < n; ++i) {
    if (id[static_cast<std::size_t>(i)] == wanted) return i;
  }
  for (int i = 0; i < hint && i < n; ++i) {
    if (id[static_cast<std::size_t>(i)] == wanted) return i;
  }
  return -1;
}

State::State(std::shared_ptr<const Layout> l)
    : layout(std::move(l)), factor(layout->tiles()), below(static_cast<std::size_t>(layout->tiles())) {
  const auto padded = static_cast<std::size_t>(layout->padded_size());
  for (AlignedVector* a : {&x, &dx, &gradient, &scratch, &scale, &x_memory}) a->resize(padded);
  q_of.reserve(static_cast<std::size_t>(layout->tiles() * (layout->tiles() + 1) / 2));
}

}  // namespace detail

namespace {
std::shared_ptr<const Layout> require_layout(std::shared_ptr<const Layout> layout) {
  if (!layout) core::throw_invalid("layout", "none", "a layout");
  return layout;
}
}  // namespace

Workspace::Workspace(std::shared_ptr<const Layout> layout) : state_(std::make_unique<detail::State>(require_layout(std::move(layout)))) {}
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;
void Workspace::forget() { state_->memory.valid = false; }
const Layout& Workspace::layout() const { return *state_->layout; }

}  // namespace stiction::cone
