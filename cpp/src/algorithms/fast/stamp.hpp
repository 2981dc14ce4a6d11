// Stamp: event time modulo 2^32 us, four bytes in the maps of the fast engine. Only differences
// have a meaning. Scrubber keeps them unambiguous: it visits every entry of a map once per 2^29 us,
// so that entries older than kLongAgo_us, set to that age, never come close to 2^31 us. O(1) per
// entry, as many as the elapsed time asks for. Pure arithmetic; one thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace asap::fast {

using Stamp = std::uint32_t;

inline constexpr std::int32_t kLongAgo_us = 1 << 30;  // older than any window

// Signed: negative where `then` is the later one.
constexpr std::int32_t age_us(Stamp now, Stamp then) noexcept {
  return static_cast<std::int32_t>(now - then);
}

constexpr Stamp long_before(Stamp now) noexcept { return now - static_cast<Stamp>(kLongAgo_us); }

class Scrubber {
 public:
  static constexpr std::uint64_t kRound_us = std::uint64_t{1} << 29;

  explicit Scrubber(std::size_t entries) noexcept : entries_(entries) {}

  // Calls visit(first, count) for the entries that are due after elapsed_us more.
  template <class Visit>
  void advance(std::uint64_t elapsed_us, Visit&& visit) noexcept {
    credit_ += entries_ * std::min(elapsed_us, kRound_us);
    auto due = static_cast<std::size_t>(std::min<std::uint64_t>(credit_ / kRound_us, entries_));
    credit_ %= kRound_us;
    while (due > 0) {
      const std::size_t count = std::min(due, entries_ - next_);
      visit(next_, count);
      next_ = (next_ + count) % entries_;
      due -= count;
    }
  }

 private:
  std::size_t entries_;
  std::size_t next_ = 0;
  std::uint64_t credit_ = 0;
};

// Ages the stamps that `stamp_of(entry)` refers to.
template <class Entry, class StampOf>
void scrub(Entry* entries, std::size_t count, Stamp now, StampOf&& stamp_of) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    Stamp& stamp = stamp_of(entries[i]);
    if (age_us(now, stamp) > kLongAgo_us) stamp = long_before(now);
  }
}

}  // namespace asap::fast
