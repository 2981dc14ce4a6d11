#include "telemetry/slot_log.hpp"

#include <algorithm>

namespace asap::inline v0_1 {
namespace {

constexpr std::int64_t kSlotUs = 1000;

std::int64_t slot_of(std::int64_t stamp_us) noexcept { return floor_div(stamp_us, kSlotUs); }

// Cuts the events before this timestamp off the front.
EventSpan cut_before(std::int64_t end_us, EventSpan& events) noexcept {
  auto end = events.end();
  if (events.back().t >= end_us) {
    end = std::partition_point(events.begin(), events.end(),
                               [=](const Event& event) { return event.t < end_us; });
  }
  const EventSpan cut(events.begin(), end);
  events = events.subspan(cut.size());
  return cut;
}

}  // namespace

void SlotLog::received(EventSpan events) {
  while (!events.empty()) {
    const std::int64_t slot = slot_of(events.front().t);
    const EventSpan together = cut_before((slot + 1) * kSlotUs, events);
    if (slots_.empty() || slots_.back().slot != slot) slots_.push_back({slot, 0, 0, 0});
    slots_.back().received += static_cast<std::int64_t>(together.size());
  }
}

void SlotLog::delivered(EventSpan events, std::int64_t end_ns, const TimeAxis& axis) noexcept {
  while (!events.empty()) {
    // The slot is there: its events were received.
    while (events.front().t >= (slots_[delivering_].slot + 1) * kSlotUs) ++delivering_;
    Slot& row = slots_[delivering_];
    const EventSpan together = cut_before((row.slot + 1) * kSlotUs, events);
    row.delivered += static_cast<std::int64_t>(together.size());
    row.latency_max_ns = std::max(row.latency_max_ns, end_ns - axis.to_ns(together.front().t));
  }
}

}  // namespace asap::inline v0_1
