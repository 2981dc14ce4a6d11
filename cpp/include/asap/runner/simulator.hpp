// Simulator: a run in virtual time. Events arrive at their stamps, a package costs what the cost
// model says, and the algorithm, if there is one, gets the packages without being timed. One
// thread, no clock: the same seed and the same input give the same bytes, however the input is cut
// into chunks, faster than real time. Memory stays flat but for the log's rows.
//
//   Simulator simulator{scheme, LinearCost{{.alpha_us = 100, .beta_ns = 300}}, {.latency_us =
//   10'000}}; while (read(chunk)) simulator.feed(chunk); simulator.finish();
#pragma once

#include "asap/packager/packager.hpp"
#include "asap/runner/consumer.hpp"
#include "asap/runner/linear_cost.hpp"
#include "asap/runner/run_config.hpp"
#include "asap/telemetry/ledger.hpp"

namespace asap {

class Simulator {
 public:
  // The scheme outlives the simulator.
  Simulator(Scheme& scheme, LinearCost cost, RunConfig config = {}, Consumer consumer = {});

  // Events in arrival order. Runs as far as they allow. An exception of the consumer or of the
  // validator passes through unchanged: the ledger is balanced, the run is over.
  void feed(EventSpan events);
  // No event follows: what waits is delivered.
  void finish();

  Ledger ledger() const noexcept;
  const Rejections& rejected() const noexcept { return validator_.rejected(); }
  const Validator& validator() const noexcept { return validator_; }
  const Telemetry& telemetry() const noexcept { return telemetry_; }

 private:
  void run_while_known();
  // Pass time until the package is finished, or the wait is over; false: the known arrivals end
  // before that. Meanwhile events arrive, and the package still holds its place in the ring.
  bool work() noexcept;
  bool wait(const Packager::Next& next) noexcept;
  void begin(const Package& package);
  void complete() noexcept;
  void admit(std::size_t count) noexcept;
  std::size_t arrivals_by(std::int64_t time_ns) const noexcept;

  LinearCost cost_;
  Consumer consumer_;
  Validator validator_;
  Telemetry telemetry_;
  EventBuffer buffer_;
  Packager packager_;

  EventSpan arriving_;  // of the chunk being fed: events that have not arrived yet
  bool started_ = false;
  std::int64_t now_ns_ = kLongAgo;
  bool is_working_ = false;
  Package working_{};  // the package in work, if is_working_
  std::int64_t busy_until_ns_ = kLongAgo;
  bool is_waiting_ = false;
  Packager::Next waiting_{};  // the wait in force, if is_waiting_
};

}  // namespace asap
