// Shadow: what must be true of a run, kept beside it as directly as possible: a list of the events
// that entered the ring, what has been said about each of them, and sums. It is told of every step
// of the two sides, and holds the real buffer, packager and telemetry to it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "asap/telemetry/ledger.hpp"
#include "buffer/event_buffer.hpp"
#include "journal.hpp"
#include "packager/anytime_plan.hpp"
#include "packager/packager.hpp"
#include "reference_filter.hpp"
#include "reference_rate.hpp"
#include "setup.hpp"
#include "sha256.hpp"
#include "telemetry/telemetry.hpp"

namespace asap::simulation {

inline constexpr std::uint64_t kNoPackage = std::numeric_limits<std::uint64_t>::max();
inline constexpr std::size_t kExactTable = 4000;  // as many waiting events have a step each

// What a run came to, over all its lives.
struct Tally {
  std::uint64_t received = 0;
  std::uint64_t packages = 0;
  // Of the events from setup.judged_from() on:
  std::uint64_t judged = 0;  // entered the ring or overflowed
  std::uint64_t judged_rejected = 0;
  std::uint64_t judged_kept = 0;
  std::int64_t judged_latency_ns = 0;     // the largest
  std::int64_t judged_start_ns = kNever;  // when the first of them came
  std::uint64_t judged_package = 0;
  std::int64_t calm_ns = kNever;  // when the last fault was over, and what it had left to do
  std::uint64_t calm_package = 0;
  std::uint64_t odd_package = kNoPackage;  // the last whose cost was at fault
  std::uint64_t odd_packages = 0;          // how many
  Sha256* fingerprint = nullptr;           // of package boundaries and kept events; if wanted
};

class Shadow {
 public:
  Shadow(const Setup& setup, Journal& journal, Tally& tally);

  void set_axis(TimeAxis axis) noexcept { axis_ = axis; }
  std::int64_t time_of(const Event& event, std::int64_t arrival_ns) const noexcept {
    return setup_.by_arrival ? arrival_ns : axis_.to_ns(event.t);
  }

  // ---- producer: returns how many the ring has to take
  std::size_t pushed(EventSpan events, const std::uint32_t* numbers, std::int64_t arrival_ns);
  void observed_ages() noexcept { slots_until_ = held_.size(); }
  void closed() noexcept { closed_ = true; }

  // ---- consumer, in the order of the calls
  void flush(std::uint64_t until) noexcept { flush_until_ = until; }
  void asking(std::int64_t now_ns) noexcept;
  void asked(const Backlog& backlog, std::uint64_t random) noexcept;
  void decided(const Backlog& backlog, Decision decision) noexcept;
  void answered(const Packager::Next& next, const EventBuffer& buffer);
  void part(const Package& package, EventSpan part, std::int64_t now_ns);
  void completing(const Package& package, std::int64_t end_ns);
  void told(const Outcome& outcome) noexcept;
  void completed(const RunLog& log);

  // ---- between two steps
  void hold_ledger(const Ledger& ledger, const EventBuffer& buffer, const Telemetry& telemetry);
  void finish(const Telemetry& telemetry);

  std::uint64_t packages() const noexcept { return packages_; }
  std::size_t waiting() const noexcept { return held_.size() - head_; }
  std::int64_t longest_wait_ns(std::int64_t now_ns) const noexcept {
    return waiting() == 0 ? 0 : now_ns - held_[head_].time_ns;
  }

 private:
  struct Held {
    Event event;
    std::uint32_t number;
    std::int64_t time_ns;
  };
  // Latencies of the delivered events; by arrival only to the step of the table.
  struct Latencies {
    std::uint64_t count = 0;
    std::uint64_t within = 0;
    std::uint64_t within_for_sure = 0;
    std::int64_t max_ns = 0;
    double sum_ns = 0;
  };

  std::int64_t step_ns() const noexcept;  // by which a time may be too early
  std::size_t count_before(std::int64_t time_ns) const noexcept;
  void hold_counts(const Backlog& backlog, std::uint64_t random) noexcept;
  void keep_whole(std::uint64_t head) noexcept;
  void drop_stale() noexcept;
  void leave(std::size_t count) noexcept;  // the ring
  AnytimePlan::Stratum next_stratum(std::int64_t now_ns);
  void hold_content(EventSpan events, std::size_t first, Law law);
  void hold_gamma(const Package& package, std::size_t kept);
  void book_latencies(std::int64_t end_ns);
  void hold_row(const PackageRow& row);

  const Setup& setup_;
  Journal& journal_;
  Tally& tally_;
  TimeAxis axis_;

  std::vector<Held> held_;  // by ring index
  std::size_t head_ = 0;
  std::size_t slots_until_ = 0;  // the age slots know the events before
  std::size_t max_waiting_ = 0;
  std::uint64_t flush_until_ = 0;
  bool closed_ = false;

  // The question and its answer.
  std::int64_t now_ns_ = 0;
  std::uint64_t tail_asked_ = 0;
  Decision decision_{};
  std::size_t stale_due_ = 0;  // decided, not yet dropped
  bool is_open_ = false;       // a package is

  // The package.
  bool is_anytime_ = false;
  bool is_completing_ = false;
  AnytimePlan plan_;
  bool is_planned_out_ = false;  // the last stratum of the plan was handed out
  ReferenceFilter filter_;
  std::vector<std::uint64_t> kept_;  // ring indices
  std::size_t raw_ = 0;
  std::size_t handed_out_ = 0;
  std::int64_t start_ns_ = 0;
  std::int64_t end_ns_ = 0;
  std::uint64_t overflow_before_ = 0;
  ReferenceRate rate_;

  std::int64_t previous_start_ns_ = kLongAgo;
  std::int64_t last_t_;
  std::size_t told_ = 0;    // events that thinning has seen for the parts of the package
  std::size_t untold_ = 0;  // ... and since then
  std::uint64_t packages_ = 0;
  std::uint64_t offered_without_ = 0;
  std::uint64_t stale_since_ = 0;
  std::uint64_t overflow_ = 0;
  std::uint64_t overflow_reported_ = 0;
  std::uint64_t stale_ = 0;
  std::uint64_t discarded_ = 0;
  std::uint64_t delivered_ = 0;
  Latencies latencies_;
};

}  // namespace asap::simulation
