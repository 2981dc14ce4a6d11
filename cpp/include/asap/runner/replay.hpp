// Replay: a recording in real time. A producer thread of its own pushes the events when the steady
// clock reaches their stamps (divided by `speed`); the algorithm runs on the caller's thread and is
// timed. The producer is never delayed by the algorithm: a full ring overflows and counts.
//
//   Replay replay{scheme, {.speed = 1.0}, {.latency_us = 10'000}};
//   SpanSource source{events};
//   replay.run(source, [&](EventSpan events) { tracker.process(events); });
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <stop_token>

#include "asap/packager/packager.hpp"
#include "asap/runner/clock.hpp"
#include "asap/runner/consumer.hpp"
#include "asap/runner/consumer_loop.hpp"
#include "asap/runner/doorbell.hpp"
#include "asap/runner/event_source.hpp"
#include "asap/runner/recording_intake.hpp"
#include "asap/runner/run_config.hpp"
#include "asap/telemetry/ledger.hpp"

namespace asap {

struct ReplayConfig {
  double speed = 1.0;        // 2 = twice as fast as recorded
  double pacing_us = 200.0;  // the producer pushes at most this often
};

class Replay {
 public:
  using Poll = ConsumerLoop::Poll;

  // The scheme outlives the replay.
  Replay(Scheme& scheme, ReplayConfig replay = {}, RunConfig config = {});

  // Runs to the end of the source; once, then std::logic_error. `poll` is called on the caller's
  // thread every 20 ms or, while the algorithm works, between two packages; it may throw to stop
  // the run. An exception of the algorithm, of poll or of the source comes out unchanged, with the
  // producer stopped and the ledger balanced.
  void run(EventSource& source, const Consumer& consumer, const Poll& poll = {});

  // After run() has returned or thrown; from poll: a snapshot, of the events pushed so far.
  Ledger ledger() const noexcept;
  const Rejections& rejected() const noexcept { return validator_.rejected(); }
  const Validator& validator() const noexcept { return validator_; }
  const Telemetry& telemetry() const noexcept { return telemetry_; }
  // Which events were delivered, if config.keep_mask; else null. Read it after run().
  const KeptMask* kept_mask() const noexcept { return kept_mask_.get(); }
  // How late the producer pushed: its own and the machine's jitter, per push.
  const LatencyHistogram& lateness() const noexcept { return lateness_; }

 private:
  void produce(EventSource& source, const std::stop_token& stop);
  void start(const Event& first) noexcept;
  void pace(const std::stop_token& stop);
  void push_arrived();

  const ReplayConfig replay_;
  const std::unique_ptr<KeptMask> kept_mask_;
  Validator validator_;  // the producer's, like arriving_ and lateness_
  Telemetry telemetry_;  // the consumer's
  EventBuffer buffer_;
  RecordingIntake intake_;
  Packager packager_;
  Doorbell doorbell_;
  RunClock clock_;
  ConsumerLoop loop_;

  EventSpan arriving_;  // of the chunk being replayed: events that have not arrived yet
  bool started_ = false;
  std::atomic<std::uint64_t> rejected_so_far_{0};
  std::int64_t next_push_ns_ = kLongAgo;
  LatencyHistogram lateness_;
};

}  // namespace asap
