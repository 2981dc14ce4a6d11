// Ledger: where every event went. Slot: what became of the events of one millisecond. Plain
// numbers: any thread, no allocation.
//
//   const Ledger ledger = pipeline.ledger();
//   if (ledger.delivered < ledger.received) fail("some events were lost");
#pragma once

#include <cstdint>

namespace asap::inline v0_1 {

// Where every event went. At every quiescent point
//   received = rejected + filtered + discarded + stale + overflow + delivered + pending
// All counts are events.
struct Ledger {
  std::uint64_t received = 0;   // handed to us
  std::uint64_t rejected = 0;   // bad data: back in time, outside the sensor, ...
  std::uint64_t filtered = 0;   // removed by the front filter
  std::uint64_t discarded = 0;  // thinned out by gamma
  std::uint64_t stale = 0;      // thrown away as too old
  std::uint64_t overflow = 0;   // did not fit into the ring: a failure
  std::uint64_t delivered = 0;  // processed by the algorithm
  std::uint64_t pending = 0;    // still in the ring, or in a package that was not finished

  constexpr bool balanced() const noexcept {
    return received == rejected + filtered + discarded + stale + overflow + delivered + pending;
  }

  friend bool operator==(const Ledger&, const Ledger&) = default;

  // What happened since an earlier snapshot of the same run. What was pending then counts as
  // received since, so the difference balances.
  friend constexpr Ledger operator-(const Ledger& later, const Ledger& earlier) noexcept {
    return {.received = later.received - earlier.received + earlier.pending,
            .rejected = later.rejected - earlier.rejected,
            .filtered = later.filtered - earlier.filtered,
            .discarded = later.discarded - earlier.discarded,
            .stale = later.stale - earlier.stale,
            .overflow = later.overflow - earlier.overflow,
            .delivered = later.delivered - earlier.delivered,
            .pending = later.pending};
  }
};

// What became of the events of 1 ms of timestamps (Simulator::slots).
struct Slot {
  std::int64_t slot;            // timestamps of [slot, slot + 1) ms
  std::int64_t received;        // events
  std::int64_t delivered;       // events
  std::int64_t latency_max_ns;  // of the delivered ones
};

}  // namespace asap::inline v0_1
