// Books: where every event that leaves the ring is written down: the counts of the ledger, the
// latencies, a row of the log per package, and what the next package reports of the time since the
// one before. The consumer's thread; O(1) per package and per event; no allocation.
#pragma once

#include <cstddef>
#include <cstdint>

#include "asap/core/time.hpp"
#include "asap/packager/package.hpp"
#include "buffer/event_buffer.hpp"
#include "packager/event_times.hpp"
#include "packager/rate_meter.hpp"
#include "telemetry/gap_meter.hpp"
#include "telemetry/telemetry.hpp"

namespace asap::inline v0_1 {

class Books {
 public:
  // So many raw events at the head of the ring, these, which came from oldest_ns to newest_ns.
  struct Left {
    std::size_t count;
    EventPieces events;
    std::int64_t oldest_ns;
    std::int64_t newest_ns;
  };

  // The referenced objects outlive the books.
  Books(Telemetry& telemetry, GapMeter& gap, const EventTimes& times) noexcept
      : telemetry_(telemetry), gap_(gap), times_(times) {}

  // These have left undecided: too old, or dropped from a full ring.
  void stale(const Left& left) noexcept;
  void overflow(const Left& left) noexcept;

  // Begins a package taken at now_ns; `lost` is the overflow of the ring so far. add() updates it:
  // it has `raw` events, the last of which lies at ring index `last`, and the front filter has
  // dropped `filtered` of them.
  void open(Package& package, std::int64_t now_ns, std::uint64_t lost) const noexcept {
    package = {.events = {},
               .index = packages_,
               .offered = offered_,
               .filtered = filtered_,
               .stale_before = stale_,
               .overflow_before = lost + telemetry_.overflow - overflow_reported_,
               .start_ns = now_ns};
  }
  void add(Package& package, std::size_t raw, std::uint64_t last,
           std::size_t filtered) const noexcept {
    package.raw = raw;
    package.offered = offered_ + (times_.thinned(last) - thinned_reported_) + raw;
    package.filtered = filtered_ + filtered;
  }

  // The package ended at end_ns; `kept_times` are for events whose time is no stamp. Without
  // events it counts to the next package and delivered() is not called.
  void discarded(const Package& package, const Left& left) noexcept;
  void delivered(const Package& package, const Left& left, std::int64_t end_ns,
                 const KeptTimes& kept_times) noexcept;

 private:
  void entered(const Package& package, const Left& left) noexcept;
  void count(const Package& package, const Left& left) noexcept;
  std::int64_t record_latencies(EventSpan events, std::int64_t end_ns,
                                const KeptTimes& kept_times) noexcept;

  Telemetry& telemetry_;
  GapMeter& gap_;
  const EventTimes& times_;
  RateMeter rate_meter_;
  std::uint64_t packages_ = 0;
  // Carried over from packages that kept nothing.
  std::size_t offered_ = 0;
  std::size_t filtered_ = 0;
  std::uint64_t stale_ = 0;              // since the package before
  std::uint64_t overflow_reported_ = 0;  // of the ring, by the packages before
  std::uint64_t thinned_reported_ = 0;   // events thinned out before they came to the ring
};

}  // namespace asap::inline v0_1
