// Pipeline: live events to the algorithm, in packages, within the latency bound. The producer, any
// one thread at a time, pushes and is never blocked; the consumer works on its own thread; any
// thread may look, flush and stop. No polling, no allocation after construction.
//
//   Pipeline pipeline{{.latency = 10ms}, [&](EventSpan events) { tracker.process(events); }};
//   driver.on_events([&](EventSpan events) { pipeline.push(events); });   // any one thread
//
// works on a thread of its own; `Pipeline{scheme, config, algorithm}` does so with a scheme of your
// choice. Or, on your thread:
//
//   Pipeline pipeline{scheme, {.latency = 10ms}};
//   pipeline.run([&](EventSpan events) { tracker.process(events); });     // until stop()
//
// An event's age counts from its push (or the arrival time given with it), not from its timestamp.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "asap/core/nonblocking.hpp"
#include "asap/core/result.hpp"
#include "asap/packager/package.hpp"
#include "asap/runner/run_config.hpp"

namespace asap::inline v0_1 {

// The counts are those of the run since the last start(). An event's latency counts from its
// arrival.
struct PipelineStats : RunStats {
  std::uint64_t run = 0;  // 1 for the constructor's, one more after each start()
  std::chrono::steady_clock::time_point begun{};  // when the first event arrived; 0: none has
  std::int64_t elapsed_ns = 0;                    // since then
  // Said by the driver; beside the ledger, not in it.
  std::uint64_t upstream_marks = 0;    // "events are missing here"
  std::uint64_t upstream_packets = 0;  // packets known to be lost
  bool open = true;                    // pushes are taken
  bool stalled = false;                // events wait, and the consumer has been away for too long
  std::uint64_t max_waiting = 0;       // events that have been in the ring at once
  std::int64_t latency_bound_ns = 0;   // the consumer applies it when it looks next
  std::int64_t sensor_delay_ns = 0;    // delay of the last push beyond the smallest recent one
  std::int64_t sensor_delay_max_ns = 0;
};

class Pipeline {
 public:
  using Next = asap::Next;
  using Arrival = std::optional<std::chrono::steady_clock::time_point>;
  using Poll = std::function<void()>;

  // Takes pushes at once. The scheme outlives the pipeline and serves one run at a time, from the
  // consumer's first call until the consumer has seen the end. Meanwhile another run with it throws
  // std::logic_error from its constructor, its start() or its consumer's first call.
  explicit Pipeline(Scheme& scheme, RunConfig config = {});
  // With a worker: a thread that runs the algorithm until stop(), see join(). Without a scheme
  // under Deadline. A process that forks has no worker: make the pipeline there. join() and start()
  // throw std::logic_error in it.
  Pipeline(RunConfig config, Consumer algorithm);
  Pipeline(Scheme& scheme, RunConfig config, Consumer algorithm);
  // Drops what still waits. Blocks until a push under way has returned and the consumer, worker or
  // not, has ended its package, so the algorithm must not call it.
  ~Pipeline();

  // The heap that Pipeline{config, algorithm} takes for a valid configuration, without what the
  // algorithm holds and without the worker's stack.
  static PipelineMemory memory(const RunConfig& config) noexcept;

  // ---- producer: any thread, one at a time; wait-free, no allocation

  // Returns false and counts nothing after stop() or while another thread pushes. If the ring is
  // full, config.when_full decides. `arrival` is clamped to [previous arrival, now]. With
  // OnBad::raise throws std::invalid_argument.
  bool push(EventSpan events, Arrival arrival = {}) ASAP_NONBLOCKING;

  // For WhenFull::block: `poll` is called every 20 ms while push waits for room; it may throw.
  bool push(EventSpan events, Arrival arrival, const Poll& poll);

  // The camera's clock begins anew with this timestamp, whatever it is, as after a restart of its
  // driver: time continues 1 us after the last event. Ignored after stop() and before an event.
  void begin_epoch(std::int64_t first_us) noexcept;

  // The offset that is added to the camera's timestamps after the last push or begin_epoch(), us.
  // Any thread.
  std::int64_t clock_offset_us() const noexcept;

  // The driver has lost events before they came here.
  void upstream_lost(std::uint64_t marks, std::uint64_t packets = 0) noexcept;

  // ---- consumer: one thread at a time, else std::logic_error; with a worker the worker alone

  // Completes the package before and waits for one, at most for `patience`: package, idle, or ended
  // after stop(). Calls `poll` every 20 ms meanwhile; it may throw. Throws std::logic_error unless
  // config.execution is `whole`.
  Next next(Package& package, std::chrono::nanoseconds patience, const Poll& poll = {});

  // The algorithm has finished the package: its cost is measured up to here.
  void complete();

  // Stops without draining; the package in work is given up and stays pending. Any thread may call
  // it; a consumer that is inside on another thread ends as after stop(false).
  void abandon();

  // Runs the algorithm until stop(), after completing the package of next(), if one is in work.
  // Calls `poll` every 20 ms or, while the algorithm works, between two packages; it may throw. An
  // exception of either comes out unchanged, the pipeline stopped and the package in work pending.
  // Throws std::invalid_argument for a consumer that is none.
  void run(const Consumer& consumer, const Poll& poll = {});

  // ---- the worker, if there is one

  // Waits until the worker has ended, after stop() or because the algorithm has thrown, and
  // rethrows that exception. Throws std::logic_error if the algorithm calls it.
  void join();
  // The same, for this long at most. Returns whether the worker has ended.
  bool join_for(std::chrono::nanoseconds timeout);

  // ---- any thread

  // Makes all events that wait now due, whatever the scheme waits for.
  void flush();

  // Refuses all later pushes. With drain the consumer gets what waits, as the scheme decides:
  // Deadline still drops stale events. Without, the consumer ends after the package in work and the
  // rest stays pending. Returns at once: a push under way that waits for room gives up, and the run
  // ends with it. A second call matters only if it sets drain = false.
  void stop(bool drain = true);

  // Begins a new run after stop(), with an empty ring and all counts at 0, in the memory of the one
  // before; a worker begins anew too. No event of the run before may be in use. Throws
  // std::logic_error while a consumer is inside or a package in work. Blocks until a push under way
  // has returned and a worker has drained, so a push's poll must not call it.
  void start();

  // Sets the latency bound, also of a scheme that has one, from the consumer's next look on and for
  // later runs. The ring keeps its capacity. Throws std::invalid_argument for one out of range.
  void set_latency(std::chrono::nanoseconds latency);

  bool is_open() const noexcept;
  Ledger ledger() const;
  // All figures are of one moment: stats.latency.count() == stats.ledger.delivered.
  PipelineStats stats() const;
  // Overwrites `stats`, an object that is used again and again: allocates nothing.
  void stats(PipelineStats& stats) const;

  // The newest rows. After stop(), when the consumer has come to the end. start() empties it; it
  // lives as long as the pipeline.
  const RunLog& log() const noexcept;

 private:
  struct Impl;
  const std::unique_ptr<Impl> impl_;
};

// Pipeline::memory(config).total()
std::size_t memory_bytes(const RunConfig& config) noexcept;

// The constructors of Pipeline, for a program without exceptions.
Result<Pipeline> make_pipeline(Scheme& scheme, RunConfig config = {}) noexcept;
Result<Pipeline> make_pipeline(RunConfig config, Consumer algorithm) noexcept;
Result<Pipeline> make_pipeline(Scheme& scheme, RunConfig config, Consumer algorithm) noexcept;

}  // namespace asap::inline v0_1
