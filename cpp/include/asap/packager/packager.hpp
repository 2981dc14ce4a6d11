// Packager: carries out what a scheme decides. It asks the scheme, takes raw events from the head
// of the ring, has them thinned, hands out the package and, when the algorithm has finished, feeds
// the cost back and books every event. It reads no clock: the time is handed in, real or virtual.
//
// Called on the consumer's thread. O(1) per event, one virtual call per package, no allocation
// after construction. Flush: whatever the scheme answers, something is taken as soon as the oldest
// event has waited for the latency bound, the ring is full or the source has ended.
//
//   const auto next = packager.next(now);                       // a package, or how long to wait
//   while (!(part = packager.stratum(package, now)).empty()) {  // all of it, or a stratum at a
//   time
//     process(part);
//   }
//   packager.complete(package, now);
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "asap/buffer/event_buffer.hpp"
#include "asap/core/relaxed.hpp"
#include "asap/core/time.hpp"
#include "asap/filter/front_filter.hpp"
#include "asap/packager/anytime_plan.hpp"
#include "asap/packager/event_times.hpp"
#include "asap/packager/kept_mask.hpp"
#include "asap/packager/package.hpp"
#include "asap/packager/thinner.hpp"
#include "asap/schemes/rate_meter.hpp"
#include "asap/schemes/scheme.hpp"
#include "asap/telemetry/latency_histogram.hpp"
#include "asap/telemetry/run_log.hpp"

namespace asap {

// What the consumer's side writes down; its owner keeps it beyond the run.
struct Telemetry {
  // most_rows: see RunLog.
  explicit Telemetry(std::int64_t latency_bound_ns, std::size_t most_rows = 0)
      : log(most_rows), latency(latency_bound_ns) {}

  RunLog log;
  LatencyHistogram latency;
  Relaxed<std::uint64_t> filtered;
  Relaxed<std::uint64_t> discarded;
  Relaxed<std::uint64_t> stale;
  Relaxed<std::uint64_t> overflow;  // dropped from a full ring by the consumer's side
  Relaxed<std::uint64_t> delivered;
};

struct PackagerConfig {
  std::uint64_t seed = 0;                    // of the gamma filter
  Execution execution = Execution::anytime;  // of the algorithm
  bool flush = true;         // false: only a full ring or the end of the source forces a scheme
  FrontFilter before{};      // may be none
  bool drop_oldest = false;  // of a ring found full, the older half
  KeptMask* kept_mask = nullptr;  // to note what is kept; may be none, else outlives the packager
  // Kept events of a package that is no slice of the ring; what is more follows as the next one.
  std::size_t most_copied = std::numeric_limits<std::size_t>::max();
};

class Packager {
 public:
  enum class Step { package, wait, ended };

  // The answer to "what now?": a package, or how long to wait, or that nothing will come.
  struct Next {
    Step step = Step::wait;
    Package package{};
    std::int64_t until_ns = kNever;  // wait until this time ...
    std::uint64_t until_tail = 0;    // ... or until the ring's tail has reached this index
  };

  // The referenced objects outlive the packager. Events of one package: at most the ring's
  // capacity.
  Packager(EventBuffer& buffer, const EventTimes& times, Scheme& scheme, Telemetry& telemetry,
           PackagerConfig config = {});

  // Sets where stamps lie in run time; before the first event is pushed.
  void set_axis(TimeAxis axis) noexcept {
    times_.set_axis(axis);
    telemetry_.log.set_axis(axis);
  }
  const TimeAxis& axis() const noexcept { return times_.axis(); }

  // Another latency bound, between two packages.
  void set_latency_bound(std::int64_t bound_ns) noexcept {
    telemetry_.latency.set_bound_ns(bound_ns);
    scheme_.set_latency_bound_ns(bound_ns);
  }

  // The events before this ring index are due, whatever the scheme waits for.
  void flush(std::uint64_t until_index) noexcept { flush_until_ = until_index; }

  // Precondition: the package before is completed or given up, and telemetry.log has room. Throws,
  // like stratum(), what the filter in front throws: then the package is given up, its raw events
  // are still in the ring.
  Next next(std::int64_t now_ns);

  // The kept events to process next, at now_ns; empty: the package is finished. A whole package
  // comes at once, an anytime package stratum by stratum; package.events are those so far.
  EventSpan stratum(Package& package, std::int64_t now_ns);

  // The algorithm has finished the package at end_ns. Precondition: stratum() has been called.
  void complete(const Package& package, std::int64_t end_ns) noexcept;

 private:
  Decision ask(const EventPieces& waiting, std::int64_t oldest_ns, std::int64_t now_ns,
               bool ended) noexcept;
  void drop_stale(std::size_t count) noexcept;
  void pass_over(std::size_t count) noexcept;
  std::uint64_t overflow() const noexcept { return buffer_.overflow() + telemetry_.overflow; }
  Package open(const Decision& decision, std::int64_t now_ns) noexcept;
  EventSpan add(Package& package, std::size_t begin, std::size_t end, Share share);
  void discard_all(const Package& package, std::int64_t end_ns) noexcept;
  double smoothed_keep(double gamma, std::int64_t now_ns) const noexcept;
  std::int64_t record_latencies(EventSpan events, std::int64_t end_ns) noexcept;
  void consume(std::size_t count) noexcept;

  EventBuffer& buffer_;
  Scheme& scheme_;
  Telemetry& telemetry_;
  EventTimes times_;
  RateMeter rate_meter_;
  const PackagerConfig config_;
  Thinner thinner_;

  // The package in work.
  EventPieces raw_{};  // its raw events, and more if it ends early
  AnytimePlan plan_;
  bool is_anytime_ = false;
  std::size_t handed_out_ = 0;  // kept events

  std::uint64_t flush_until_ = 0;
  std::uint64_t packages_ = 0;
  std::int64_t previous_start_ns_ = kLongAgo;
  double keep_ = 1.0;
  std::size_t offered_without_package_ = 0;
  std::size_t filtered_without_package_ = 0;
  std::uint64_t stale_since_package_ = 0;
  std::uint64_t overflow_reported_ = 0;
  std::uint64_t thinned_reported_ = 0;  // events thinned out before they came to the ring
};

}  // namespace asap
