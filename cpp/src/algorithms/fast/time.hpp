// Time in the fast tracker. Stamp: event time modulo 2^32 us, four bytes in the maps; only
// differences have a meaning. Scrubber: visits every entry of a map once per 2^29 us, so that an
// entry older than kLongAgo_us is set back to that age and never comes near 2^31 us. decay() and
// logarithm(): from + - * / alone, for the same bits on every platform. One thread. O(1), but for
// Scrubber, which visits as many entries as the elapsed time asks for. No allocation.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace asap::inline v0_1::fast {

// ---- stamps ----

using Stamp = std::uint32_t;

inline constexpr std::int32_t kLongAgo_us = 1 << 30;  // older than any window

// Negative if `then` is the later one.
constexpr std::int32_t age_us(Stamp now, Stamp then) noexcept {
  return static_cast<std::int32_t>(now - then);
}

// The age in seconds, negative if `then` is the later one.
constexpr float age_s(Stamp now, Stamp then) noexcept {
  return 1e-6F * static_cast<float>(age_us(now, then));
}

constexpr float seconds(std::uint64_t us) noexcept { return 1e-6F * static_cast<float>(us); }

// Silence after which the tracker begins anew, whatever the parameters: stamps become ambiguous.
inline constexpr std::uint64_t kSilence_us = std::uint64_t{1} << 28;

constexpr Stamp long_before(Stamp now) noexcept { return now - static_cast<Stamp>(kLongAgo_us); }

class Scrubber {
 public:
  static constexpr std::uint64_t kRound_us = std::uint64_t{1} << 29;

  explicit Scrubber(std::size_t entries) noexcept : entries_(entries) {}

  // Limits the age of stamp_of(entry) for the entries that are due after elapsed_us more.
  template <class Entry, class StampOf>
  void scrub(Entry* entries, Stamp now, std::uint64_t elapsed_us, StampOf&& stamp_of) noexcept {
    credit_ += entries_ * std::min(elapsed_us, kRound_us);
    auto due = static_cast<std::size_t>(std::min<std::uint64_t>(credit_ / kRound_us, entries_));
    credit_ %= kRound_us;
    for (; due > 0; --due) {
      auto& stamp = stamp_of(entries[next_]);
      if (age_us(now, static_cast<Stamp>(stamp)) > kLongAgo_us) {
        stamp = static_cast<std::remove_reference_t<decltype(stamp)>>(long_before(now));
      }
      next_ = next_ + 1 < entries_ ? next_ + 1 : 0;
    }
  }

 private:
  std::size_t entries_;
  std::size_t next_ = 0;
  std::uint64_t credit_ = 0;
};

// ---- exponential decay ----

// exp(-u), u >= 0. Relative error below 2e-5 up to u = 12, 1e-3 up to 30.
constexpr float decay(float u) noexcept {
  constexpr float kHalvings = 64;
  const float x = std::min(u, 80.0F) / kHalvings;
  float growth = 1 + x * (1 + x * (0.5F + x * (1.0F / 6 + x * (1.0F / 24 + x / 120))));
  for (int doubling = 0; doubling < 6; ++doubling) growth *= growth;
  return 1 / growth;
}

// ln(y), y >= 0.5. Absolute error below 1e-5 up to 1000.
constexpr float logarithm(float y) noexcept {
  constexpr float kLn2 = 0.69314718F;
  float sum = 0;
  for (; y > 1.5F && sum < 90; y /= 2) sum += kLn2;
  const float z = (y - 1) / (y + 1);
  const float z2 = z * z;
  return sum + 2 * z * (1 + z2 * (1.0F / 3 + z2 * (1.0F / 5 + z2 * (1.0F / 7 + z2 / 9))));
}

// The weight of the newest value in a low pass that has run for age_s, its last step of dt_s
// included; `decayed` is exp(-dt_s / time constant). Until the filter has settled, its output is
// the mean over the age.
constexpr float low_pass_weight(float decayed, float dt_s, float age_s) noexcept {
  return std::max(1 - decayed, dt_s < age_s ? dt_s / age_s : 1.0F);
}

}  // namespace asap::inline v0_1::fast
