#include "asap/telemetry/slot_log.hpp"

#include <algorithm>

namespace asap {
namespace {

constexpr std::int64_t kSlotUs = 1000;

std::int64_t slot_of(std::int64_t stamp_us) noexcept { return floor_div(stamp_us, kSlotUs); }

// Cuts the events of the first one's slot off the front.
EventSpan next_slot(EventSpan& events) noexcept {
  const std::int64_t end_us = (slot_of(events.front().t) + 1) * kSlotUs;
  const auto end = std::partition_point(events.begin(), events.end(),
                                        [=](const Event& event) { return event.t < end_us; });
  const EventSpan slot(events.begin(), end);
  events = events.subspan(slot.size());
  return slot;
}

}  // namespace

void SlotLog::received(EventSpan events) {
  while (!events.empty()) {
    const std::int64_t slot = slot_of(events.front().t);
    const auto count = static_cast<std::int64_t>(next_slot(events).size());
    if (slots_.empty() || slots_.back().slot != slot) slots_.push_back({slot, 0, 0, 0});
    slots_.back().received += count;
  }
}

void SlotLog::delivered(EventSpan events, std::int64_t end_ns, const TimeAxis& axis) noexcept {
  while (!events.empty()) {
    const EventSpan together = next_slot(events);
    const std::int64_t slot = slot_of(together.front().t);
    while (slots_[delivering_].slot < slot) ++delivering_;  // it is there: it was received
    Slot& row = slots_[delivering_];
    row.delivered += static_cast<std::int64_t>(together.size());
    row.latency_max_ns = std::max(row.latency_max_ns, end_ns - axis.to_ns(together.front().t));
  }
}

}  // namespace asap
