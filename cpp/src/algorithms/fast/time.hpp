// Time in the fast tracker. Stamp: event time modulo 2^32 us, four bytes in the maps; only
// differences have a meaning. Scrubber: visits every entry of a map once per 2^29 us, so that an
// entry older than kLongAgo_us is set back to that age and never comes near 2^31 us. EventClock:
// the tracker's time, which never goes back. decay() and logarithm(): from + - * / alone, for the
// same bits on every platform. One thread. O(1), but for Scrubber, which visits as many entries as
// the elapsed time asks for. No allocation.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace asap::fast {

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

// Silence after which all tracks are deleted, whatever the parameters: stamps become ambiguous.
inline constexpr std::uint64_t kSilence_us = std::uint64_t{1} << 28;

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

// Limits the age of the stamps that stamp_of(entry) refers to.
template <class Entry, class StampOf>
void scrub(Entry* entries, std::size_t count, Stamp now, StampOf&& stamp_of) noexcept {
  for (std::size_t i = 0; i < count; ++i) {
    Stamp& stamp = stamp_of(entries[i]);
    if (age_us(now, stamp) > kLongAgo_us) stamp = long_before(now);
  }
}

// ---- the clock ----

// A timestamp that goes back by at most a second counts as the latest one. A larger step back
// begins a new epoch (the sensor was reset or its counter wrapped): time stands still for that
// event and goes on from there. Any int64 is a valid timestamp.
class EventClock {
 public:
  static constexpr std::uint64_t kBackStep_us = 1'000'000;
  // The time of the first event: a second before Stamp wraps, so that every run sees it wrap.
  static constexpr std::uint64_t kOrigin_us = (std::uint64_t{1} << 32) - 1'000'000;

  void advance(std::int64_t t_us) noexcept {
    if (t_us >= latest_us_) [[likely]] {
      if (started_) now_us_ += distance(latest_us_, t_us);
    } else if (started_ && distance(t_us, latest_us_) <= kBackStep_us) {
      return;
    }
    started_ = true;
    latest_us_ = t_us;
  }

  // Advances without an event. A time of the past is ignored.
  void advance_to(std::int64_t t_us) noexcept {
    if (t_us > latest_us_) advance(t_us);
  }

  // us; only differences have a meaning.
  std::uint64_t now_us() const noexcept { return now_us_; }
  Stamp now() const noexcept { return static_cast<Stamp>(now_us_); }
  bool started() const noexcept { return started_; }

  // The latest timestamp.
  std::int64_t latest_us() const noexcept { return latest_us_; }
  // The timestamp of what is age_us old, negative for the future; clamped to int64.
  std::int64_t stamp_us(std::int32_t age_us) const noexcept {
    using Stamps = std::numeric_limits<std::int64_t>;
    if (age_us < 0) return std::min(latest_us_, Stamps::max() + age_us) - age_us;
    return std::max(latest_us_, Stamps::min() + age_us) - age_us;
  }

 private:
  static std::uint64_t distance(std::int64_t earlier, std::int64_t later) noexcept {
    return static_cast<std::uint64_t>(later) - static_cast<std::uint64_t>(earlier);
  }

  bool started_ = false;
  std::int64_t latest_us_ = 0;
  std::uint64_t now_us_ = kOrigin_us;
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

}  // namespace asap::fast
