// Replay: a recording in real time. A producer thread of its own pushes the events when the steady
// clock reaches their timestamps (divided by `speed`); the algorithm runs on the caller's thread
// and is timed. The producer never waits: a full ring overflows and counts. Only the log grows.
//
//   Replay replay{scheme, {.speed = 1.0}, {.latency = 10ms}};
//   SpanSource source{events};
//   replay.run(source, [&](EventSpan events) { tracker.process(events); });
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "asap/core/event.hpp"
#include "asap/filter/validator.hpp"
#include "asap/packager/package.hpp"
#include "asap/runner/run_config.hpp"

namespace asap::inline v0_1 {

struct ReplayConfig {
  double speed = 1.0;  // 2 = twice as fast as recorded
  // The producer pushes at most this often; half of it is part of the median latency.
  std::chrono::nanoseconds pacing = std::chrono::microseconds(50);
};

class Replay {
 public:
  using Poll = std::function<void()>;

  // The scheme outlives the replay.
  Replay(Scheme& scheme, ReplayConfig replay = {}, RunConfig config = {});
  ~Replay();

  // Runs to the end of the source; once, then std::logic_error. Throws std::invalid_argument for a
  // consumer that is none, before the run. `poll` is called on the caller's
  // thread every 20 ms or, while the algorithm works, between two packages; it may throw to stop
  // the run. An exception of the algorithm, of poll or of the source comes out unchanged, with the
  // producer stopped and the ledger balanced.
  void run(EventSource& source, const Consumer& consumer, const Poll& poll = {});

  // After run() has returned or thrown; from poll: a snapshot, of the events pushed so far. stats()
  // holds the same ledger, and 60 kB of latencies.
  Ledger ledger() const noexcept;
  const Validator& validator() const noexcept;
  RunStats stats() const;
  // A row per package. The caller's thread.
  const RunLog& log() const noexcept;
  // Which events were delivered, if config.keep_mask, and unless the filter in front has changed
  // them. After run().
  std::optional<KeptEvents> kept() const;
  // How late the producer pushed: its own and the machine's jitter, per push.
  const LatencyHistogram& lateness() const noexcept;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace asap::inline v0_1
