// BitLog: one bit per event, in order, in memory that grows. One thread; O(1) amortised per bit,
// per 64 of them where they are equal.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/core/nonblocking.hpp"

namespace asap::inline v0_1 {

class BitLog {
 public:
  // The next `count` appended bits need no allocation.
  void make_room(std::size_t count) {
    const std::size_t words = (size_ + count + 63) / 64;
    if (words <= words_.capacity()) return;
    exempt([&] { words_.reserve(std::max(words, 2 * words_.capacity())); });  // of recordings only
  }

  void append(bool bit) { append(1, bit); }
  void append(std::size_t count, bool bit) {
    while (count > 0) {
      const std::size_t at = size_ % 64;
      if (at == 0) exempt([&] { words_.push_back(0); });  // of recordings only
      const std::size_t here = std::min(count, 64 - at);
      if (bit) words_.back() |= (~std::uint64_t{0} >> (64 - here)) << at;
      size_ += here;
      count -= here;
    }
  }

  std::size_t size() const noexcept { return size_; }
  bool operator[](std::size_t i) const noexcept { return (words_[i / 64] >> (i % 64) & 1) != 0; }

 private:
  std::vector<std::uint64_t> words_;
  std::size_t size_ = 0;
};

}  // namespace asap::inline v0_1
