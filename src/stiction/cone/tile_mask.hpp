#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "stiction/cone/layout.hpp"

namespace stiction::cone::detail {

/// A set of tiles.
class TileMask {
 public:
  void set(int i) { words_[word(i)] |= std::uint64_t{1} << (i % 64); }
  void reset(int i) { words_[word(i)] &= ~(std::uint64_t{1} << (i % 64)); }
  bool empty() const { return words_ == std::array<std::uint64_t, kWords>{}; }
  /// Smallest member; −1 for the empty set.
  int first() const {
    for (int w = 0; w < kWords; ++w) {
      if (words_[static_cast<std::size_t>(w)] != 0) return 64 * w + std::countr_zero(words_[static_cast<std::size_t>(w)]);
    }
    return -1;
  }
  int count() const {
    int n = 0;
    for (const auto w : words_) n += std::popcount(w);
    return n;
  }
  /// Calls f(i) for the members in ascending order.
  template <class F>
  void for_each(F&& f) const {
    for (int w = 0; w < kWords; ++w) {
      for (std::uint64_t m = words_[static_cast<std::size_t>(w)]; m != 0; m &= m - 1) f(64 * w + std::countr_zero(m));
    }
  }
  TileMask& operator|=(const TileMask& other) {
    for (std::size_t w = 0; w < kWords; ++w) words_[w] |= other.words_[w];
    return *this;
  }
  friend TileMask operator&(TileMask a, const TileMask& b) {
    for (std::size_t w = 0; w < kWords; ++w) a.words_[w] &= b.words_[w];
    return a;
  }
  bool operator==(const TileMask&) const = default;

 private:
  static constexpr int kWords = kMaxTiles / 64;
  static std::size_t word(int i) { return static_cast<std::size_t>(i / 64); }
  std::array<std::uint64_t, kWords> words_{};
};

}  // namespace stiction::cone::detail
