// Oracle: OB(L), the largest number of events that a policy that does not know the random part of
// the cost can finish within L of their timestamps, whatever it discards and however well it knows
// the arrivals. All events enter a fluid FIFO queue that is served at (1 - alpha/L)/beta, never in
// an outage: no package of an in-time event lasts longer than L. An event is admitted as far as
// what is served by its deadline allows; deadlines are in the order of arrival, so admitting as
// much as possible, event by event, is the most there is. With beta constant a true bound, for a
// drifting beta up to what a package saves that starts before a rise, with noise in expectation.
// One thread; a few ns per event, memory flat. Source: notebooks/theory.md, T7 and section 9.
#pragma once

#include <cstddef>
#include <cstdint>

#include "asap/core/event.hpp"
#include "asap/core/time.hpp"
#include "asap/runner/simulator.hpp"
#include "asap/schemes/scheme.hpp"

namespace asap::inline v0_1 {

class Oracle {
 public:
  // Anytime execution can let cheap packages run on: with noise it counts beta / E[1/X]; `whole`
  // counts the mean.
  Oracle(LinearCost cost, double latency_us, Execution execution);

  // Events in arrival order; a timestamp that goes back counts as the one before it.
  void feed(EventSpan events) noexcept;

  // Counts the events so far and supposes that none follow.
  double bound() const noexcept { return bound_; }

 private:
  // Events served up to a moment, and how long they cost nothing.
  struct Service {
    double events = 0.0;
    std::int64_t free_ns = 0;
  };

  // The service curve S(t), walked forwards over the steps of the drift and the outages' edges.
  struct Cursor {
    Service before{};  // state before the stretch [begin_ns, end_ns) of constant speed
    std::int64_t begin_ns = 0;
    std::int64_t end_ns = 0;
    double events_per_ns = 0.0;
    bool is_free = false;
    std::size_t outage = 0;  // the first one that ends after begin_ns

    Service at(std::int64_t time_ns) const noexcept;
  };

  void arrive(std::int64_t time_ns) noexcept;
  Service served_by(Cursor& cursor, std::int64_t time_ns) const noexcept;
  void enter_next_stretch(Cursor& cursor) const noexcept;

  LinearCost cost_;
  std::int64_t latency_ns_;
  double share_;         // share of the time that goes into events: 1 - alpha/L, at least 0
  double noise_factor_;  // on beta

  bool started_ = false;
  TimeAxis axis_;
  std::int64_t now_ns_ = 0;
  Cursor now_;
  Cursor deadline_;
  Service served_;      // S(now)
  double room_ = 0.0;   // events that may wait now: S(now + L) - S(now)
  double queue_ = 0.0;  // events that wait
  double bound_ = 0.0;
};

}  // namespace asap::inline v0_1
