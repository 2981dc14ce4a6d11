// KeySet: a set of the numbers 0 .. 127 in two machine words. O(1), no allocation.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

namespace asap::inline v0_1 {

class KeySet {
 public:
  using Key = std::int16_t;
  static constexpr std::size_t kKeys = 128;

  static constexpr KeySet all() noexcept {
    KeySet set;
    for (std::uint64_t& word : set.words_) word = ~std::uint64_t{0};
    return set;
  }

  bool empty() const noexcept { return (words_[0] | words_[1]) == 0; }

  // Precondition: the set is not empty.
  Key lowest() const noexcept {
    return static_cast<Key>(words_[0] != 0 ? std::countr_zero(words_[0])
                                           : 64 + std::countr_zero(words_[1]));
  }

  void insert(Key key) noexcept { word(key) |= bit(key); }
  void erase(Key key) noexcept { word(key) &= ~bit(key); }

  KeySet& operator|=(const KeySet& other) noexcept {
    words_[0] |= other.words_[0];
    words_[1] |= other.words_[1];
    return *this;
  }

  // Calls visit(key) in ascending order.
  template <class Visit>
  void for_each(Visit&& visit) const noexcept {
    for (int i = 0; i < 2; ++i) {
      for (std::uint64_t rest = words_[i]; rest != 0; rest &= rest - 1) {
        visit(static_cast<Key>(64 * i + std::countr_zero(rest)));
      }
    }
  }

 private:
  static std::uint64_t bit(Key key) noexcept { return std::uint64_t{1} << (key & 63); }
  std::uint64_t& word(Key key) noexcept { return words_[key >> 6]; }

  std::uint64_t words_[2] = {0, 0};
};

}  // namespace asap::inline v0_1
