#include "packager/books.hpp"

namespace asap::inline v0_1 {

void Books::stale(const Left& left) noexcept {
  rate_meter_.observe(left.count, left.oldest_ns, left.newest_ns);
  telemetry_.book([&] { telemetry_.stale += left.count; });
  gap_.lost(left.events);
  stale_ += left.count;
}

void Books::overflow(const Left& left) noexcept {
  rate_meter_.observe(left.count, left.oldest_ns, left.newest_ns);
  telemetry_.book([&] { telemetry_.overflow += left.count; });
  gap_.lost(left.events);
}

// Those that were thinned out in front of the ring have entered, too.
void Books::entered(const Package& package, const Left& left) noexcept {
  const std::size_t came = package.offered - offered_;
  rate_meter_.observe(came, left.oldest_ns, left.newest_ns);
  thinned_reported_ += came - package.raw;
}

// An event that the filter in front removed is not lost. In a package that gamma has thinned, too,
// it counts as lost: the two cannot be told apart.
void Books::count(const Package& package, const Left& left) noexcept {
  const std::size_t filtered = package.filtered - filtered_;
  if (filtered > 0) telemetry_.filtered += filtered;
  const std::size_t discarded = package.raw - filtered - package.events.size();
  if (discarded == 0) return gap_.kept(package.events);
  telemetry_.discarded += discarded;
  gap_.thinned(left.events, package.events);
}

void Books::discarded(const Package& package, const Left& left) noexcept {
  entered(package, left);
  telemetry_.book([&] { count(package, left); });
  offered_ = package.offered;
  filtered_ = package.filtered;
}

void Books::delivered(const Package& package, const Left& left, std::int64_t end_ns,
                      const KeptTimes& kept_times) noexcept {
  entered(package, left);
  const RateMeter::Window window = rate_meter_.window();
  telemetry_.book([&] {
    count(package, left);
    const std::int64_t oldest_ns = record_latencies(package.events, end_ns, kept_times);
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

// Returns the time of the oldest event.
std::int64_t Books::record_latencies(EventSpan events, std::int64_t end_ns,
                                     const KeptTimes& kept_times) noexcept {
  if (!times_.by_arrival()) {
    const TimeAxis axis = times_.axis();  // in registers
    const std::int64_t oldest_ns = axis.to_ns(events.front().t);
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

}  // namespace asap::inline v0_1
