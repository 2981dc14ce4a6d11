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
  // So many raw events at the head of the ring, the oldest of these; they came from oldest_ns to
  // newest_ns.
  struct Left {
    std::size_t count;
    const EventPieces& waiting;
    std::int64_t oldest_ns;
    std::int64_t newest_ns;

    EventPieces events() const noexcept { return waiting.oldest(count); }
  };

  // The referenced objects outlive the books.
  Books(Telemetry& telemetry, GapMeter& gap, const EventTimes& times) noexcept
      : telemetry_(telemetry), gap_(gap), times_(times) {}

  // These have left undecided: too old, or dropped from a full ring.
  void stale(const Left& left) noexcept {
    rate_meter_.observe(left.count, left.oldest_ns, left.newest_ns);
    telemetry_.book([&] { telemetry_.stale += left.count; });
    gap_.lost(left.events());
    stale_ += left.count;
  }
  void overflow(const Left& left) noexcept {
    rate_meter_.observe(left.count, left.oldest_ns, left.newest_ns);
    telemetry_.book([&] { telemetry_.overflow += left.count; });
    gap_.lost(left.events());
  }

  // Begins a package taken at now_ns; `lost` is the overflow of the ring so far. add() updates it:
  // it has `raw` events, the last of which lies at ring index `last`, and the front filter has
  // dropped `filtered` of them.
  void open(Package& package, std::int64_t now_ns, std::uint64_t lost) const noexcept {
    package.raw = 0;
    package.index = packages_;
    package.offered = offered_;
    package.filtered = filtered_;
    package.stale_before = stale_;
    package.overflow_before = lost + telemetry_.overflow - overflow_reported_;
    package.start_ns = now_ns;
  }
  void add(Package& package, std::size_t raw, std::uint64_t last,
           std::size_t filtered) const noexcept {
    package.raw = raw;
    package.offered = offered_ + (times_.thinned(last) - thinned_reported_) + raw;
    package.filtered = filtered_ + filtered;
  }

  // The package ended at end_ns; `kept_times` are for events whose time is no stamp. Without
  // events it counts to the next package and delivered() is not called.
  void discarded(const Package& package, const Left& left) noexcept {
    entered(package, left);
    telemetry_.book([&] { count(package, left); });
    offered_ = package.offered;
    filtered_ = package.filtered;
  }
  void delivered(const Package& package, const Left& left, std::int64_t end_ns,
                 const KeptTimes& kept_times) noexcept {
    entered(package, left);
    const RateMeter::Window window = rate_meter_.window();
    telemetry_.book([&] {
      count(package, left);
      const std::int64_t oldest_ns = record_latencies(package.events, left, end_ns, kept_times);
      telemetry_.log.append({.start_ns = package.start_ns,
                             .processing_ns = end_ns - package.start_ns,
                             .oldest_ns = oldest_ns,
                             .t_first = package.t_first(),
                             .t_last = package.t_last(),
                             .offered = package.offered,
                             .filtered = package.filtered,
                             .size = package.events.size(),
                             .stale = package.stale_before,
                             .overflow = package.overflow_before,
                             .rate_events = window.events,
                             .rate_ns = window.ns});
      telemetry_.delivered += package.events.size();
    });
    ++packages_;
    offered_ = 0;
    filtered_ = 0;
    stale_ = 0;
    overflow_reported_ += package.overflow_before;
  }

 private:
  // Those that were thinned out in front of the ring have entered, too.
  void entered(const Package& package, const Left& left) noexcept {
    const std::size_t came = package.offered - offered_;
    rate_meter_.observe(came, left.oldest_ns, left.newest_ns);
    thinned_reported_ += came - package.raw;
  }
  // An event that the filter in front removed is not lost. In a package that gamma has thinned,
  // too, it counts as lost: the two cannot be told apart.
  void count(const Package& package, const Left& left) noexcept {
    const std::size_t filtered = package.filtered - filtered_;
    if (filtered > 0) telemetry_.filtered += filtered;
    const std::size_t discarded = package.raw - filtered - package.events.size();
    if (discarded == 0) return gap_.kept(package.events);
    telemetry_.discarded += discarded;
    gap_.thinned(left.events(), package.events);
  }
  // Returns the time of the oldest event.
  std::int64_t record_latencies(EventSpan events, const Left& left, std::int64_t end_ns,
                                const KeptTimes& kept_times) noexcept {
    if (!times_.by_arrival()) {
      const TimeAxis axis = times_.axis();  // in registers
      const bool is_oldest = events.data() == left.waiting.first.data();
      const std::int64_t oldest_ns = is_oldest ? left.oldest_ns : axis.to_ns(events.front().t);
      if (events.size() == 1) {
        telemetry_.latency.record(end_ns - oldest_ns);
        return oldest_ns;
      }
      LatencyHistogram::Batch latencies(telemetry_.latency);
      for (const Event& event : events) latencies.record(end_ns - axis.to_ns(event.t));
      return oldest_ns;
    }
    std::size_t at = 0;
    for (const KeptTimes::Run& run : kept_times.runs()) {
      telemetry_.latency.record(end_ns - run.time_ns, run.end - at);
      at = run.end;
    }
    return kept_times.runs().front().time_ns;
  }

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
