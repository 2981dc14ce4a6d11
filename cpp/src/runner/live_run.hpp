// LiveRun: a run of a live pipeline, from its first event to its end. The producer pushes, the
// consumer loops, any thread may look at the counters. The event's time is its arrival on the
// steady clock; a wall clock that steps has no effect. Memory is bounded at construction: see
// Pipeline::memory(). A package that is thinned or lies across the ring's end has at most
// RunConfig::max_copied events; what the scheme has taken beyond follows as the next.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "asap/core/atomics.hpp"
#include "asap/runner/run_config.hpp"
#include "runner/clock.hpp"
#include "runner/consumer_loop.hpp"
#include "runner/doorbell.hpp"
#include "runner/intake.hpp"
#include "runner/run.hpp"
#include "runner/sensor_delay.hpp"

namespace asap {

class LiveRun {
 public:
  using Steady = RunClock::Steady;

  // The scheme outlives the run.
  LiveRun(Scheme& scheme, const RunConfig& config);

  // Producer. Wait-free, unless config.when_full is block: see Intake::take for `poll`. A stamp
  // that shows that the sensor's clock was set back makes what waits due.
  void push(EventSpan events, std::optional<Steady::time_point> arrival = {});
  void push(EventSpan events, std::optional<Steady::time_point> arrival, const Intake::Poll& poll);

  // Any thread. A producer that waits for room gives up.
  void leave() noexcept { intake_.leave(); }

  // Any thread. Another latency bound, from the consumer's next look on.
  void set_latency_bound(std::int64_t bound_ns) noexcept;

  // Once the producer has gone: nothing follows.
  void close() noexcept;

  // Consumer; flush() and abandon() from any thread.
  ConsumerLoop& loop() noexcept { return loop_; }

  // Consumer: no package will be taken or booked any more.
  void finish() noexcept { finished_.store(true, std::memory_order_release); }

  // Any thread. A snapshot, see Run::ledger; exact after close() and finish().
  Ledger ledger() const noexcept;
  Rejections rejected() const noexcept { return run_.rejected(); }
  std::uint64_t clock_resets() const noexcept { return clock_resets_; }
  const SensorDelay& sensor_delay() const noexcept { return sensor_delay_; }
  std::int64_t gap_us() const noexcept { return run_.gap_us(&intake_.gap()); }
  // The consumer has been away for too long.
  bool stalled() const noexcept { return loop_.stalled(run_.buffer().size()); }
  // The most events that have waited at once.
  std::uint64_t max_waiting() const noexcept { return intake_.max_waiting(); }
  // Time since the first arrival, until close().
  std::int64_t elapsed_ns() const noexcept;
  // Latencies and totals from any thread; rows once the run is over.
  const Telemetry& telemetry() const noexcept { return run_.telemetry(); }

 private:
  template <class Take>
  void push_by(const Take& take, EventSpan events, std::optional<Steady::time_point> arrival);
  void begin(const Event& first, Steady::time_point arrival) noexcept;
  void heed_clock() noexcept;

  Run run_;
  Doorbell doorbell_;
  Intake intake_;
  RunClock clock_;
  ConsumerLoop loop_;

  std::atomic<bool> finished_{false};
  bool begun_ = false;           // the producer's, like the next two
  std::int64_t arrival_ns_ = 0;  // of the newest push
  std::int64_t first_arrival_ns_ = 0;
  std::int64_t closed_ns_ = 0;
  Relaxed<std::uint64_t> clock_resets_;
  SensorDelay sensor_delay_;
};

}  // namespace asap
