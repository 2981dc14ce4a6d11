// GapMeter: the gap of a run, in us of the timestamps: the longest time between two events in a row
// that got through, where at least one event between them was lost. The first and the last event
// that came count as if they got through. A camera that was silent therefore makes no gap.
//
// One thread reports what came, in order; any thread may read meanwhile. O(1) where all or none of
// the events got through. No allocation.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "asap/core/event.hpp"
#include "asap/core/time.hpp"
#include "core/atomics.hpp"

namespace asap::inline v0_1 {

class GapMeter {
 public:
  // The stream begins at this stamp. Without this call: with the first event that is reported.
  void begin(std::int64_t first_us) noexcept { kept_until_us_ = first_us; }

  // These events came, none or more, and all got through.
  void kept(EventSpan events) noexcept {
    if (!events.empty()) keep(events.front().t, events.back().t);
  }

  // These events came, one or more, and none got through. Events: anything with size() and [].
  template <class Events>
  void lost(const Events& came) noexcept {
    begin_with(came);
    lose(came[came.size() - 1].t);
  }

  // These events came, one or more, and `kept` of them got through, in order. A lost event that
  // equals its kept neighbour does not count: the two cannot be told apart.
  template <class Events>
  void thinned(const Events& came, EventSpan kept) noexcept {
    if (kept.empty()) return lost(came);
    begin_with(came);
    if (came[0] != kept.front()) is_lost_ = true;
    keep(kept.front().t, kept.back().t);
    look_between(came, kept);
    const Event& newest = came[came.size() - 1];
    if (newest != kept.back()) lose(newest.t);
  }

  std::int64_t longest_us() const noexcept { return longest_us_; }

  // Stamps of the newest kept event, or of the first event while none was kept; and of the newest
  // lost event. kLongAgo: there is none.
  std::int64_t kept_until_us() const noexcept { return kept_until_us_; }
  std::int64_t lost_until_us() const noexcept { return lost_until_us_; }

 private:
  template <class Events>
  void begin_with(const Events& came) noexcept {
    if (kept_until_us_ == kLongAgo) begin(came[0].t);
  }
  void keep(std::int64_t first_us, std::int64_t last_us) noexcept {
    if (is_lost_) extend(first_us - kept_until_us_);
    kept_until_us_ = last_us;
    is_lost_ = false;
  }
  void lose(std::int64_t last_us) noexcept {
    extend(last_us - kept_until_us_);
    lost_until_us_ = last_us;
    is_lost_ = true;
  }
  void extend(std::int64_t gap_us) noexcept {
    if (gap_us > longest_us_) longest_us_ = gap_us;
  }

  // Kept events within the longest gap so far hold no longer one, so a stride of them is passed in
  // one step. The stride is such that at an even rate three quarters of the longest gap hold it.
  template <class Events>
  void look_between(const Events& came, EventSpan kept) noexcept {
    const std::int64_t span_us = kept.back().t - kept.front().t;
    std::int64_t longest_us = longest_us_;
    if (span_us <= longest_us) return;
    const double share = static_cast<double>(longest_us) / static_cast<double>(span_us);
    const auto fits = static_cast<std::size_t>(0.75 * share * static_cast<double>(kept.size()));
    const std::size_t stride = std::clamp<std::size_t>(fits, 1, kept.size() - 1);
    const auto look = [&](const Event* event, const Event* end) {
      for (; event != end; ++event) {
        const std::int64_t apart_us = event[1].t - event[0].t;
        if (apart_us > longest_us && is_any_between(came, event[0], event[1]))
          longest_us = apart_us;
      }
    };
    const Event* event = kept.data();
    const Event* const last = event + kept.size() - 1;
    for (const Event* const end = last - stride; event <= end; event += stride) {
      if (event[stride].t - event->t > longest_us) look(event, event + stride);
    }
    look(event, last);
    extend(longest_us);
  }

  // Whether an event came between two kept ones of different stamps.
  template <class Events>
  static bool is_any_between(const Events& came, const Event& before, const Event& after) noexcept {
    std::size_t at = 0;
    for (std::size_t end = came.size(); at < end;) {
      const std::size_t middle = at + (end - at) / 2;
      if (came[middle].t < after.t) {
        at = middle + 1;
      } else {
        end = middle;
      }
    }
    while (at < came.size() && came[at] != after) ++at;
    return at == 0 || at == came.size() || came[at - 1] != before;  // a filter may change events
  }

  Relaxed<std::int64_t> longest_us_;
  Relaxed<std::int64_t> kept_until_us_ = kLongAgo;
  Relaxed<std::int64_t> lost_until_us_ = kLongAgo;
  bool is_lost_ = false;  // an event, since the newest kept one
};

}  // namespace asap::inline v0_1
