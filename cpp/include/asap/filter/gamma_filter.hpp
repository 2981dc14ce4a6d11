// GammaFilter: keeps each event with probability gamma (the paper's random discard, section III of
// ASAP, 2020). Whether event number i is kept depends on (seed, i, gamma) alone: the result does
// not change with the way in which the stream is cut, and a smaller gamma keeps a subset. One
// thread; O(1) per event and branch-free; no allocation.
//
//   GammaFilter filter(/*seed=*/1);
//   std::vector<Event> kept(events.size());
//   kept.resize(filter.apply(events, KeepThreshold::checked(0.3), std::span(kept)));
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "asap/core/event.hpp"
#include "asap/core/nonblocking.hpp"

namespace asap::inline v0_1 {

// The 63-bit bar below which an event's random number must stay for the event to be kept.
class KeepThreshold {
 public:
  // Throws std::invalid_argument unless 0 <= gamma <= 1.
  static KeepThreshold checked(double gamma);

  // For the hot path: out of range is clamped, NaN keeps all.
  static constexpr KeepThreshold clamped(double gamma) noexcept {
    if (!(gamma < 1.0)) return KeepThreshold{kAll};
    if (gamma <= 0.0) return KeepThreshold{0};
    return KeepThreshold{static_cast<std::uint64_t>(gamma * static_cast<double>(kAll))};
  }

  static constexpr KeepThreshold all() noexcept { return KeepThreshold{kAll}; }

  constexpr std::uint64_t value() const noexcept { return value_; }
  constexpr bool keeps_all() const noexcept { return value_ == kAll; }

 private:
  friend class GammaFilter;
  static constexpr std::uint64_t kAll = std::uint64_t{1} << 63;
  explicit constexpr KeepThreshold(std::uint64_t value) noexcept : value_(value) {}
  std::uint64_t value_;
};

class GammaFilter {
 public:
  explicit GammaFilter(std::uint64_t seed = 0) noexcept : seed_(seed) {}

  // Writes the kept events to `out`, which holds at least events.size() (the tail beyond the kept
  // ones is scratch). Returns how many were kept. The position advances by events.size().
  std::size_t apply(EventSpan events, KeepThreshold threshold,
                    std::span<Event> out) noexcept ASAP_NONBLOCKING;

  // One byte per event: 1 = kept. The position advances like in apply.
  void mask(EventSpan events, KeepThreshold threshold,
            std::span<std::uint8_t> kept) noexcept ASAP_NONBLOCKING;

  // The threshold that keeps exactly `count` of the next `events` events; the position stays.
  // `numbers` is scratch for as many. O(events).
  KeepThreshold keeping(std::size_t count, std::size_t events,
                        std::span<std::uint64_t> numbers) const noexcept ASAP_NONBLOCKING;

  // Passes over events that leave the stream undecided (stale ones).
  void skip(std::size_t count) noexcept ASAP_NONBLOCKING { position_ += count; }

  // Events seen so far: the number of the next one.
  std::uint64_t position() const noexcept { return position_; }

 private:
  std::uint64_t seed_;
  std::uint64_t position_ = 0;
};

}  // namespace asap::inline v0_1
