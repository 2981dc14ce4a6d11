// Pipeline: live events from any thread to the algorithm, in packages, within the latency bound.
// The producer pushes and is never blocked; the consumer works on its own thread; any thread may
// look, flush and stop. No thread of its own, no polling.
//
//   Pipeline pipeline{scheme, {.latency_us = 10'000}};
//   driver.on_events([&](EventSpan events) { pipeline.push(events); });   // any thread
//   pipeline.run([&](EventSpan events) { tracker.process(events); });     // until stop()
//
// An event's age counts from its push (or the arrival time given with it), not from its stamp.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "asap/runner/consumer.hpp"
#include "asap/runner/live_run.hpp"
#include "asap/runner/push_door.hpp"
#include "asap/runner/run_config.hpp"

namespace asap {

// How a pipeline does; a snapshot of the run since the last start().
struct PipelineStats {
  Ledger ledger;
  Rejections rejected;
  LatencyHistogram latency;  // per delivered event, from its arrival to the end of its package
  PackageTotals packages;
  std::int64_t elapsed_ns = 0;  // since the first arrival
  std::uint64_t clock_resets = 0;
  // Said by the driver; beside the ledger, not in it.
  std::uint64_t upstream_marks = 0;    // "events are missing here"
  std::uint64_t upstream_packets = 0;  // packets known to be lost
  bool open = true;                    // pushes are taken
};

class Pipeline {
 public:
  using Next = ConsumerLoop::Next;
  using Arrival = std::optional<std::chrono::steady_clock::time_point>;
  using Poll = std::function<void()>;

  // Open from the start. The scheme outlives the pipeline.
  explicit Pipeline(Scheme& scheme, RunConfig config = {});
  ~Pipeline() { stop(false); }

  // ---- producer: any thread, one at a time; wait-free, no allocation

  // False, and nothing is counted: after stop(), or while another thread pushes. Events that do not
  // fit into the ring are dropped and counted. An arrival in the future counts as now, one before
  // that of the last push as that. With OnBad::raise throws std::invalid_argument.
  bool push(EventSpan events, Arrival arrival = {});

  // The driver has lost events before they came here.
  void upstream_lost(std::uint64_t marks, std::uint64_t packets = 0) noexcept;

  // ---- consumer: one thread at a time, else std::logic_error

  // Waits for a package, at most for `patience` (then idle), and completes the one before. ended:
  // stopped. For a pipeline whose execution is `whole`, else std::logic_error.
  Next next(Package& package, std::chrono::nanoseconds patience);

  // The algorithm has finished the package: its cost is measured up to here.
  void complete();

  // Stops without draining; the package in work is given up and stays pending. From any thread: if
  // another one is inside, that one ends as after stop(false).
  void abandon();

  // Until stop(). `poll` is called every 20 ms or, while the algorithm works, between two packages;
  // it may throw. An exception of either comes out unchanged, the pipeline stopped and the package
  // in work pending.
  void run(const Consumer& consumer, const Poll& poll = {});

  // ---- any thread

  // What waits now is due, whatever the scheme waits for.
  void flush();

  // No push is taken any more; the consumer gets what waits (drain) or, after the package in work,
  // nothing more: the rest stays pending. Does not wait for the consumer. Again: only drain = false
  // makes a difference.
  void stop(bool drain = true);

  // After stop(): a new run, with an empty ring and all counts at 0. std::logic_error while a
  // consumer is inside or a package in work; no event of the run before may be in use.
  void start();

  bool is_open() const noexcept { return door_.is_open(); }
  Ledger ledger() const;
  PipelineStats stats() const;

  // The newest rows of the log. After stop(), when the consumer has come to the end.
  const Telemetry& telemetry() const noexcept { return run_->telemetry(); }

 private:
  class Working;

  Scheme& scheme_;
  const RunConfig config_;
  mutable std::mutex control_;  // start, stop, flush and the snapshots; never push or next
  std::unique_ptr<LiveRun> run_;
  PushDoor door_;
  std::atomic<std::uint64_t> upstream_marks_{0};
  std::atomic<std::uint64_t> upstream_packets_{0};

  std::atomic<bool> consuming_{false};  // a consumer is inside
  Package package_;                     // in work, if has_package_
  bool has_package_ = false;
};

}  // namespace asap
