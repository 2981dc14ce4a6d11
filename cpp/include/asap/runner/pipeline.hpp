// Pipeline: live events to the algorithm, in packages, within the latency bound. The producer, any
// one thread at a time, pushes and is never blocked; the consumer works on its own thread; any
// thread may look, flush and stop. No polling.
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
// An event's age counts from its push (or the arrival time given with it), not from its stamp.
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

namespace asap {

// The counts are those of the run since the last start(). An event's latency counts from its
// arrival.
struct PipelineStats : RunStats {
  std::int64_t elapsed_ns = 0;  // since the first arrival
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

  // Takes pushes at once. The scheme outlives the pipeline. A live run uses it from the consumer's
  // first call until the consumer has seen the end: another one throws std::logic_error meanwhile,
  // in the constructor, in start() and from its consumer's first call.
  explicit Pipeline(Scheme& scheme, RunConfig config = {});
  // With a worker: a thread that runs the algorithm until stop(), see join(). Without a scheme
  // under Deadline.
  Pipeline(RunConfig config, Consumer algorithm);
  Pipeline(Scheme& scheme, RunConfig config, Consumer algorithm);
  // Gives up what still waits, and waits for a push that is inside and for the consumer, worker or
  // not, to end its package: so not from inside the algorithm, which cannot wait for itself.
  ~Pipeline();

  // The heap that Pipeline{config, algorithm} takes for a configuration that it accepts. What the
  // algorithm holds and the worker's stack are not included.
  static PipelineMemory memory(const RunConfig& config) noexcept;

  // ---- producer: any thread, one at a time; wait-free, no allocation

  // False, and nothing is counted: after stop(), or while another thread pushes. Where the ring is
  // full config.when_full decides. `arrival` is clamped to [previous arrival, now]. With
  // OnBad::raise throws std::invalid_argument.
  bool push(EventSpan events, Arrival arrival = {}) ASAP_NONBLOCKING;

  // For WhenFull::block: `poll` is called every 20 ms while push waits for room; it may throw.
  bool push(EventSpan events, Arrival arrival, const Poll& poll);

  // The camera's clock begins anew with this stamp, whatever it is, as after a restart of its
  // driver: time continues 1 us after the last event. Ignored after stop() and before an event.
  void begin_epoch(std::int64_t first_us) noexcept;

  // The offset that is now added to the camera's stamps, us. The producer's.
  std::int64_t clock_offset_us() const noexcept;

  // The driver has lost events before they came here.
  void upstream_lost(std::uint64_t marks, std::uint64_t packets = 0) noexcept;

  // ---- consumer: one thread at a time, else std::logic_error; with a worker the worker alone

  // Waits for a package, at most for `patience` (then idle), and completes the one before. ended:
  // stopped. Meanwhile `poll` is called every 20 ms; it may throw. For a pipeline whose execution
  // is `whole`, else std::logic_error.
  Next next(Package& package, std::chrono::nanoseconds patience, const Poll& poll = {});

  // The algorithm has finished the package: its cost is measured up to here.
  void complete();

  // Stops without draining; the package in work is given up and stays pending. From any thread: if
  // another one is inside, that one ends as after stop(false).
  void abandon();

  // Until stop(); completes the package of next(), if one is in work. `poll` is called every 20 ms
  // or, while the algorithm works, between two packages; it may throw. An exception of either comes
  // out unchanged, the pipeline stopped and the package in work pending.
  void run(const Consumer& consumer, const Poll& poll = {});

  // ---- the worker, if there is one

  // Waits until it has ended: after stop(), or because the algorithm has thrown; then throws that.
  // std::logic_error from inside the algorithm.
  void join();

  // ---- any thread

  // What waits now is due, whatever the scheme waits for.
  void flush();

  // No push is taken any more; the consumer gets what waits (drain) or, after the package in work,
  // nothing more: the rest stays pending. The scheme decides to the end: Deadline drops what has
  // become stale in the drain too. Waits neither for the consumer nor for a push that is inside:
  // that one waits for room no longer, and the run ends with it. Again: only drain = false makes a
  // difference.
  void stop(bool drain = true);

  // After stop(): a new run, with an empty ring and all counts at 0. std::logic_error while a
  // consumer is inside or a package in work; no event of the run before may be in use. Waits for a
  // push that is still inside, so not from its poll, and for a worker that still drains, and lets
  // it begin anew.
  void start();

  // Another latency bound, from the consumer's next look on and for later runs; for a scheme that
  // has one, too. The ring keeps its capacity. Throws std::invalid_argument for one out of range.
  void set_latency(std::chrono::nanoseconds latency);

  bool is_open() const noexcept;
  Ledger ledger() const;
  PipelineStats stats() const;

  // The newest rows. After stop(), when the consumer has come to the end.
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

}  // namespace asap
