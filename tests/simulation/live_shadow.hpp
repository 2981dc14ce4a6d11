// LiveShadow: what must be true of a live run, told from outside: the world says what it pushes and
// asks for, the scheme between packager and scheme what is said there, the algorithm what it gets.
// It holds the pipeline's ledger, order, sleep and wake-ups, stall, overflow and latency to it;
// what a package holds event by event is Shadow's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "asap/runner/pipeline.hpp"
#include "journal.hpp"
#include "live_setup.hpp"
#include "packager/packager.hpp"
#include "shadow.hpp"
#include "stall_reference.hpp"

namespace asap::simulation {

class LiveShadow {
 public:
  LiveShadow(const Setup& setup, const LiveSetup& live, std::int64_t bound_ns, Journal& journal,
             Tally& tally);

  // ---- the world. Times are those of the machine, unless they say run.
  struct Pushed {
    EventSpan events;  // that have passed the door
    const std::vector<std::uint32_t>& numbers;
    std::int64_t came_ns;
    bool is_reset;  // the sensor's clock was set back
  };
  void begins(const Event& first, std::int64_t came_ns, std::int64_t now_ns);
  bool has_begun() const noexcept { return has_begun_; }
  void pushed(const Pushed& pushed, const Ledger& before, const Ledger& after);
  void flushes() noexcept;
  void sets_bound(std::int64_t bound_ns) noexcept;
  void closes() noexcept { asked_.closed = true; }
  void abandons() noexcept { asked_.abandoned = true; }
  void unrest() noexcept;  // a fault: what comes next is not judged
  void hold_stalled(bool stalled, std::int64_t now_ns);
  void hold_ledger(const Ledger& ledger);

  // ---- the consumer
  void enters(std::int64_t patience_ns) noexcept;  // next()
  void looks() noexcept {                          // at the clock, before others may act
    looked_ = asked_;
    tail_seen_ = held_.size();
  }
  void saw(std::int64_t now_ns);  // this time
  void asked(const Backlog& backlog);
  void decided(const Backlog& backlog, const Decision& decision, const Belief& belief);
  void told(const Outcome& outcome);
  void filters(EventSpan events, std::size_t passed);
  void part(const Package& package, std::size_t position);
  void works() noexcept { is_working_ = true; }
  void idles();  // next() has come back without a package
  void ended();
  void finish(const LatencyHistogram& latency);

  // ---- sleep
  void sleeps(std::int64_t deadline_ns);
  bool is_asleep() const noexcept { return is_asleep_; }
  void woken();
  void hold_wake();  // after every action of the world: who has to be woken is
  void wakes_up() noexcept { is_asleep_ = false; }

  std::size_t waiting() const noexcept { return held_.size() - head_; }
  std::uint64_t packages() const noexcept { return packages_; }

 private:
  struct Held {
    std::uint64_t begin;  // it is one of the events sent with these numbers
    std::uint64_t end;
    std::int64_t time_ns;
  };
  // What other threads have asked for. A flush of a push with a reset is somewhere in that push.
  struct Asked {
    std::uint64_t flush_min = 0;
    std::uint64_t flush_max = 0;
    std::int64_t bound_ns = 0;
    bool closed = false;
    bool abandoned = false;

    friend bool operator==(const Asked&, const Asked&) = default;
  };

  std::int64_t run_ns(std::int64_t time_ns) const noexcept { return time_ns + offset_ns_; }
  // Waiting events that came before the consumer looked at the clock: those it knows of.
  std::size_t seen() const noexcept { return tail_seen_ - head_; }
  void hold_admission(std::size_t offered, std::uint64_t taken, std::uint64_t thinned,
                      std::uint64_t overflow);
  void hold_latency(std::int64_t latency_ns, const Outcome& outcome);
  bool is_calm() const noexcept;
  void drop_oldest() noexcept;

  const LiveSetup& live_;
  Setup setup_;  // its bound is the one in force
  Journal& journal_;
  Tally& tally_;

  // Producer
  bool has_begun_ = false;
  std::int64_t offset_ns_ = 0;
  std::int64_t arrival_ns_ = 0;  // run
  std::vector<Event> sent_;      // have passed the door
  std::vector<std::uint32_t> numbers_;
  std::vector<Held> held_;  // by ring index
  Asked asked_;
  Asked looked_;
  std::int64_t longest_bound_ns_;
  std::size_t max_waiting_ = 0;
  double let_in_ = 0;  // by the thinning
  double let_in_by_law_ = 0;

  // Consumer
  std::size_t head_ = 0;
  std::size_t tail_seen_ = 0;
  std::int64_t patience_ns_ = 0;
  std::int64_t entered_ns_ = 0;
  std::int64_t seen_ns_ = 0;  // the last look at the clock
  bool enters_ = false;
  bool has_slept_ = false;
  bool is_working_ = false;
  StallReference stall_;
  std::int64_t heeded_bound_ns_;  // in force since the last look, whatever came of it

  // The question and its answer.
  bool waits_ = false;
  std::uint64_t wanted_tail_ = 0;
  std::int64_t until_ns_ = kNever;  // run

  // Sleep
  bool is_asleep_ = false;
  bool was_woken_ = false;
  Asked slept_on_;
  bool may_be_woken_ = false;

  // The package.
  Belief belief_{};
  double keep_ = 1;  // as planned
  bool is_anytime_ = false;
  std::size_t raw_ = 0;
  std::size_t cursor_ = 0;         // ring index; the kept events before are known
  std::uint64_t next_sent_ = 0;    // likewise of those sent
  std::size_t filter_cursor_ = 0;  // ring index; the filter in front has seen those before
  std::size_t kept_ = 0;
  std::size_t filtered_ = 0;
  std::int64_t oldest_ns_ = 0;  // of the kept events
  std::size_t oldest_number_ = 0;

  std::uint64_t packages_ = 0;
  std::int64_t previous_start_ns_ = kLongAgo;
  std::uint64_t thinned_ = 0;
  std::uint64_t discarded_ = 0;
  std::uint64_t overflow_ = 0;
  std::uint64_t overflow_reported_ = 0;
  std::uint64_t stale_ = 0;
  std::uint64_t stale_since_ = 0;
  std::uint64_t filtered_all_ = 0;
  std::uint64_t delivered_ = 0;
  std::int64_t largest_latency_ns_ = 0;
  std::int64_t calm_since_ns_ = 0;
  std::uint64_t calm_since_package_ = 0;
};

}  // namespace asap::simulation
