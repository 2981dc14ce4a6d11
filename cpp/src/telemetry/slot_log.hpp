// SlotLog: what became of the events of each millisecond. One row per 1 ms slot of the timestamps
// that holds an event: how many came in, how many were delivered, and the largest latency. It
// answers what a row per package cannot: gaps, and how long a disturbance lasted
// (notebooks/theory.md, section 10). One thread; O(1) amortised per event or better; 32 bytes per
// slot that is not empty.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/core/time.hpp"
#include "asap/telemetry/ledger.hpp"

namespace asap::inline v0_1 {

class SlotLog {
 public:
  // Events in time order; every event is received before it is delivered.
  void received(EventSpan events);
  // Delivered at end_ns of the run's axis.
  void delivered(EventSpan events, std::int64_t end_ns, const TimeAxis& axis) noexcept;

  const std::vector<Slot>& slots() const noexcept { return slots_; }

 private:
  std::vector<Slot> slots_;
  std::size_t delivering_ = 0;  // the slot of the newest delivered event
};

}  // namespace asap::inline v0_1
