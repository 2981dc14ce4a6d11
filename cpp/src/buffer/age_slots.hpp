// AgeSlots: which events of the ring came before a given time, in O(1). Time is cut into slots of
// fixed width; for each of the last 128 the producer notes the ring index of its first event, with
// one compare per event or less. The consumer interpolates inside a slot, so a count is right to
// the share of one slot. One producer thread, one consumer thread; no allocation. What for:
// notebooks/theory.md, section 6.
//
// Memory order. Entries are relaxed: they steer, they decide about no event. newest_ is stored with
// release after the entries of its slot, so a reader of newest_ sees them. A reader that is held up
// for more than 128 slots may meet entries of later slots: counts are then too high, but stay
// within what waits, because they are clipped.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "asap/core/event.hpp"
#include "asap/core/time.hpp"
#include "core/check.hpp"

namespace asap::inline v0_1 {

class AgeSlots {
 public:
  static constexpr std::int64_t kSlots = 128;

  explicit AgeSlots(std::int64_t width_ns) : width_ns_(width_ns) {
    require(width_ns >= 1, "width_ns", width_ns, "must be at least 1 ns");
  }

  // Producer. Events in time order, the first of which lies at this ring index; to_ns gives the
  // time of a stamp.
  template <class ToNs>
  void observe(EventSpan events, std::uint64_t first_index, const ToNs& to_ns) noexcept {
    while (!events.empty() && to_ns(events.back().t) >= next_ns_) {
      const auto begin = std::partition_point(
          events.begin(), events.end(), [&](const Event& e) { return to_ns(e.t) < next_ns_; });
      const auto passed = static_cast<std::size_t>(begin - events.begin());
      first_index += passed;
      events = events.subspan(passed);
      open(slot_of(to_ns(events.front().t)), first_index);
    }
  }

  // Consumer. Of the `count` events from ring index `head` on, those before time_ns; now_ns ends
  // the newest slot.
  std::size_t before(std::int64_t time_ns, std::int64_t now_ns, std::uint64_t head,
                     std::size_t count) const noexcept {
    return before(place_of(time_ns), now_ns, head, count);
  }

  // The same for newest_ns, newest_ns - step_ns, ...: as many as there are counts.
  void before_each(std::int64_t newest_ns, std::int64_t step_ns, std::int64_t now_ns,
                   std::uint64_t head, std::size_t count,
                   std::span<std::size_t> counts) const noexcept {
    const Place step = place_of(step_ns);
    Place place = place_of(newest_ns);
    for (std::size_t& older : counts) {
      older = before(place, now_ns, head, count);
      place.slot -= step.slot;
      place.into_ns -= step.into_ns;
      if (place.into_ns < 0) {
        place.into_ns += width_ns_;
        --place.slot;
      }
    }
  }

 private:
  struct Place {
    std::int64_t slot;
    std::int64_t into_ns;  // since its beginning
  };

  Place place_of(std::int64_t time_ns) const noexcept {
    const std::int64_t rest_ns = time_ns % width_ns_;
    return {slot_of(time_ns), rest_ns < 0 ? rest_ns + width_ns_ : rest_ns};
  }

  std::size_t before(Place place, std::int64_t now_ns, std::uint64_t head,
                     std::size_t count) const noexcept {
    const std::int64_t newest = newest_.load(std::memory_order_acquire);
    if (place.slot > newest) return count;
    if (place.slot <= newest - kSlots) return 0;
    const std::size_t begin = waiting_before(place.slot, head, count);
    const bool is_newest = place.slot == newest;
    const std::size_t end = is_newest ? count : waiting_before(place.slot + 1, head, count);
    const std::int64_t length_ns =
        is_newest ? std::clamp<std::int64_t>(now_ns - place.slot * width_ns_, 1, width_ns_)
                  : width_ns_;
    if (place.into_ns >= length_ns || end <= begin) return std::max(end, begin);
    const double share = static_cast<double>(place.into_ns) / static_cast<double>(length_ns);
    return begin + static_cast<std::size_t>(share * static_cast<double>(end - begin));
  }

  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::min() / 2;
  static constexpr std::size_t kEntries = 2 * kSlots;  // old ones are overwritten late

  std::int64_t slot_of(std::int64_t time_ns) const noexcept {
    return floor_div(time_ns, width_ns_);
  }
  static std::size_t entry_of(std::int64_t slot) noexcept {
    return static_cast<std::size_t>(slot) % kEntries;
  }

  // Producer. This slot, and the empty ones since the newest, begin at this index.
  void open(std::int64_t slot, std::uint64_t index) noexcept {
    const std::int64_t newest = newest_.load(std::memory_order_relaxed);
    for (std::int64_t s = std::max(newest + 1, slot - kSlots); s <= slot; ++s) {
      first_[entry_of(s)].store(index, std::memory_order_relaxed);
    }
    newest_.store(slot, std::memory_order_release);
    next_ns_ = (slot + 1) * width_ns_;
  }

  std::size_t waiting_before(std::int64_t slot, std::uint64_t head,
                             std::size_t count) const noexcept {
    const std::uint64_t index = first_[entry_of(slot)].load(std::memory_order_relaxed);
    const auto ahead = static_cast<std::int64_t>(index - head);
    return static_cast<std::size_t>(
        std::clamp<std::int64_t>(ahead, 0, static_cast<std::int64_t>(count)));
  }

  const std::int64_t width_ns_;
  std::array<std::atomic<std::uint64_t>, kEntries> first_{};
  std::atomic<std::int64_t> newest_{kNone};
  std::int64_t next_ns_ = std::numeric_limits<std::int64_t>::min();  // the producer's own
};

}  // namespace asap::inline v0_1
