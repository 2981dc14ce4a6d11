// Packager: carries out what a scheme decides. It asks the scheme, takes raw events from the head
// of the ring, has them thinned, hands out the package and, when the algorithm has finished, feeds
// the cost back and books every event. It reads no clock: the time is handed in, real or virtual.
//
// Called on the consumer's thread. O(1) per event, one virtual call per package, no allocation
// after construction. Flush: whatever the scheme answers, something is taken as soon as the oldest
// event has waited for the latency bound, the ring is full or the source has ended.
//
//   const auto next = packager.next(now);                       // a package, or how long to wait
//   while (!(part = packager.stratum(package, now)).empty()) {  // all of it, or a part at a time
//     process(part);
//   }
//   packager.complete(package, now);
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

#include "asap/core/nonblocking.hpp"
#include "asap/core/time.hpp"
#include "asap/packager/package.hpp"
#include "asap/schemes/scheme.hpp"
#include "buffer/event_buffer.hpp"
#include "packager/anytime_plan.hpp"
#include "packager/books.hpp"
#include "packager/event_times.hpp"
#include "packager/kept_mask.hpp"
#include "packager/thinner.hpp"
#include "telemetry/gap_meter.hpp"
#include "telemetry/telemetry.hpp"

namespace asap::inline v0_1 {

struct PackagerConfig {
  std::uint64_t seed = 0;                    // of the gamma filter
  Execution execution = Execution::anytime;  // of the algorithm
  bool flush = true;           // false: only a full ring or the end of the source forces a scheme
  FrontFilter front_filter{};  // may be none
  bool drop_oldest = false;    // of a ring found full, the older half
  KeptMask* kept_mask = nullptr;  // to note what is kept; may be none, else outlives the packager
  // Kept events of a package that is no slice of the ring; what is more follows as the next one.
  std::size_t max_copied = std::numeric_limits<std::size_t>::max();
  bool prefault = false;  // writes to all memory in the constructor
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
  // capacity. `times` says when the events of the ring came.
  Packager(EventBuffer& buffer, const EventTimes& times, Scheme& scheme, Telemetry& telemetry,
           PackagerConfig config = {});
  // The events came at their stamps.
  Packager(EventBuffer& buffer, Scheme& scheme, Telemetry& telemetry, PackagerConfig config = {});

  // What a packager of a live run takes, all of it in its constructor.
  static std::size_t memory_bytes(std::size_t capacity, std::size_t max_copied,
                                  bool is_filtered) noexcept;

  // Begins another run, in place and as constructed. Throws what a copy of the filter in front
  // does: then nothing has changed.
  void reset();

  // Sets where timestamps lie in run time, and the first of them; before the first event is pushed.
  void begin(TimeAxis axis, std::int64_t first_us) noexcept;

  // Another latency bound, between two packages.
  void set_latency_bound(std::int64_t bound_ns) noexcept;

  // The events before this ring index are due, whatever the scheme waits for.
  void flush(std::uint64_t until_index) noexcept { flush_until_ = until_index; }

  // Precondition: the package before is completed or given up, and telemetry.log has room. Throws,
  // like stratum(), what the filter in front throws: then the package is given up, its raw events
  // are still in the ring. Events from ring index `until` on are ignored: the producer may have
  // pushed them after the caller read the clock.
  Next next(std::int64_t now_ns,
            std::uint64_t until = std::numeric_limits<std::uint64_t>::max()) ASAP_NONBLOCKING;

  // The kept events to process next, at now_ns; empty: the package is finished. A whole package
  // comes at once, an anytime package stratum by stratum; package.events are those so far, and
  // package.gamma is that of the stratum. At the end it is that of the package.
  EventSpan stratum(Package& package, std::int64_t now_ns) ASAP_NONBLOCKING;

  // The algorithm has finished the package at end_ns. Precondition: stratum() has been called.
  void complete(const Package& package, std::int64_t end_ns) noexcept ASAP_NONBLOCKING;

  // Any thread. The gaps of the events that came to the ring.
  const GapMeter& gap() const noexcept { return gap_; }

 private:
  Decision ask(const EventPieces& waiting, std::int64_t oldest_ns, std::int64_t now_ns,
               bool ended) noexcept;
  void open(Package& package, const EventPieces& raw, const Decision& decision,
            std::int64_t now_ns) noexcept;
  EventSpan add(Package& package, std::size_t begin, std::size_t end, Share share);
  void add_planned(Package& package, const Decision& decision);
  double tell(std::size_t kept) noexcept;
  Books::Left leaving(const EventPieces& waiting, std::size_t count,
                      std::int64_t oldest_ns) const noexcept;
  void pass_over(std::size_t count) noexcept;
  void observe(const Package& package, std::int64_t end_ns) noexcept;
  void consume(std::size_t count) noexcept;

  EventBuffer& buffer_;
  Scheme& scheme_;
  Telemetry& telemetry_;
  GapMeter gap_;
  EventTimes times_;
  const PackagerConfig config_;
  Thinner thinner_;
  Books books_;

  // The package in work.
  std::int64_t oldest_ns_ = 0;  // time of its first raw event
  AnytimePlan plan_;
  bool is_anytime_ = false;
  std::size_t handed_out_ = 0;  // kept events
  std::size_t told_ = 0;        // events that thinning has seen for these

  std::uint64_t flush_until_ = 0;
  std::int64_t previous_start_ns_ = kLongAgo;
  std::size_t untold_ = 0;  // events that thinning has seen since the last part handed out
};

}  // namespace asap::inline v0_1
