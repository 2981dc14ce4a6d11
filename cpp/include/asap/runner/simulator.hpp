// Simulator: a run in virtual time. Events arrive at their stamps, a package costs what the cost
// model says, and the algorithm, if there is one, gets each package as it ends, without being
// timed. One thread, no clock: the same seed and the same input give the same bytes, however the
// input is cut into chunks, faster than real time. Memory stays flat but for the rows of the logs.
//
//   Simulator simulator{scheme, LinearCost{{.alpha_us = 100, .beta_ns = 300}}, {.latency_us =
//   10'000}}; while (read(chunk)) simulator.feed(chunk); simulator.finish();
#pragma once

#include <memory>
#include <optional>

#include "asap/packager/packager.hpp"
#include "asap/runner/admission_gate.hpp"
#include "asap/runner/consumer.hpp"
#include "asap/runner/linear_cost.hpp"
#include "asap/runner/recording_intake.hpp"
#include "asap/runner/run_config.hpp"
#include "asap/telemetry/ledger.hpp"
#include "asap/telemetry/slot_log.hpp"

namespace asap {

class Simulator {
 public:
  // The scheme outlives the simulator. One with an admission also filters on arrival, and then
  // no mask is kept.
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
  // Which events were delivered, if config.keep_mask; else null. Read it after finish().
  const KeptMask* kept_mask() const noexcept { return kept_mask_.get(); }
  const SlotLog& slots() const noexcept { return slots_; }
  // Virtual time during which the algorithm worked, ns.
  std::int64_t busy_ns() const noexcept { return busy_ns_; }

 private:
  void receive(EventSpan good);
  void start(const Event& first);
  void look(Arrivals& arrivals);
  // Behind a gate: no event that arrives before this time is still to come.
  void run_until(std::int64_t time_ns);
  bool knows(std::int64_t time_ns) const noexcept;  // all that arrives up to then
  void run_while_known();
  // Pass time until this part of the package is done, or the wait is over; false: the known
  // arrivals end before that. Meanwhile events arrive, and the package still holds its place in the
  // ring.
  bool work();
  bool wait(const Packager::Next& next);
  void begin(const Package& package);
  void go_on();  // with the next part of the package, or complete it
  void admit(std::size_t count);
  std::size_t arrivals_by(std::int64_t time_ns) const noexcept;

  LinearCost cost_;
  Consumer consumer_;
  const std::unique_ptr<KeptMask> kept_mask_;
  Validator validator_;
  Telemetry telemetry_;
  SlotLog slots_;
  EventBuffer buffer_;
  RecordingIntake intake_;
  Packager packager_;
  std::optional<AdmissionGate> gate_;

  EventSpan arriving_;  // of the chunk being fed: events that have not arrived yet
  std::int64_t known_until_ns_ = kLongAgo;  // known beyond arriving_: silence until then
  std::uint64_t good_ = 0;                  // events that the validator let in
  bool started_ = false;
  std::int64_t now_ns_ = kLongAgo;
  bool is_working_ = false;
  Package working_{};  // the package in work, if is_working_
  PackageCost working_cost_{};
  std::uint64_t begun_ = 0;  // packages: each has a draw of its own
  std::int64_t busy_until_ns_ = kLongAgo;
  std::int64_t busy_ns_ = 0;
  bool is_waiting_ = false;
  Packager::Next waiting_{};  // the wait in force, if is_waiting_
};

}  // namespace asap
