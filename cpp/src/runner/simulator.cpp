#include "asap/runner/simulator.hpp"

#include <algorithm>
#include <utility>

namespace asap {
namespace {

constexpr std::int64_t kEndOfTimeNs = 9'200'000'000'000'000'000;  // absurd costs end here

}  // namespace

Simulator::Simulator(Scheme& scheme, LinearCost cost, RunConfig config, Consumer consumer)
    : cost_(cost),
      consumer_(std::move(consumer)),
      validator_(config.validator),
      telemetry_(latency_bound_ns(config, scheme)),
      buffer_(ring_capacity(config, telemetry_.latency.bound_ns())),
      packager_(buffer_, scheme, telemetry_, config.seed) {}

void Simulator::feed(EventSpan events) {
  validator_.check(events, [this](EventSpan good) {
    arriving_ = good;
    run_while_known();
  });
}

void Simulator::finish() {
  buffer_.close();
  if (is_working_) complete();
  for (;;) {
    telemetry_.log.make_room();
    const Packager::Next next = packager_.next(now_ns_);
    if (next.step != Packager::Step::package) return;  // a closed source is never waited for
    begin(next.package);
    complete();
  }
}

Ledger Simulator::ledger() const noexcept {
  return {.received = validator_.received(),
          .rejected = validator_.rejected().total(),
          .discarded = telemetry_.discarded,
          .stale = telemetry_.stale,
          .overflow = buffer_.overflow(),
          .delivered = telemetry_.delivered,
          .pending = buffer_.size() + arriving_.size()};
}

void Simulator::run_while_known() {
  if (arriving_.empty()) return;
  if (!started_) {
    packager_.set_axis(TimeAxis(arriving_.front().t, 1.0));
    now_ns_ = packager_.axis().to_ns(arriving_.front().t);
    started_ = true;
  }
  for (;;) {
    if (is_working_ && !work()) return;
    if (is_waiting_ && !wait(waiting_)) return;
    admit(arrivals_by(now_ns_));
    if (arriving_.empty()) return;  // the next chunk may hold more for this moment
    telemetry_.log.make_room();
    const Packager::Next next = packager_.next(now_ns_);
    if (next.step == Packager::Step::package) {
      begin(next.package);
    } else {
      waiting_ = next;
      is_waiting_ = true;
    }
  }
}

bool Simulator::work() noexcept {
  admit(arrivals_by(busy_until_ns_));
  if (arriving_.empty()) return false;  // the next chunk may hold more for this time
  complete();
  return true;
}

bool Simulator::wait(const Packager::Next& next) noexcept {
  const std::uint64_t missing = next.until_tail - buffer_.tail();
  const std::size_t by_time = arrivals_by(next.until_ns);
  if (missing > by_time && by_time == arriving_.size()) {
    if (!arriving_.empty()) now_ns_ = packager_.axis().to_ns(arriving_.back().t);
    admit(arriving_.size());
    return false;
  }
  now_ns_ = missing <= by_time ? packager_.axis().to_ns(arriving_[missing - 1].t) : next.until_ns;
  is_waiting_ = false;
  return true;
}

void Simulator::begin(const Package& package) {
  if (consumer_) consumer_(package);
  const std::int64_t cost_ns = cost_.processing_ns(package.index, package.events.size());
  busy_until_ns_ = package.start_ns + std::min(cost_ns, kEndOfTimeNs - package.start_ns);
  working_ = package;
  is_working_ = true;
}

void Simulator::complete() noexcept {
  now_ns_ = busy_until_ns_;
  packager_.complete(working_, now_ns_);
  is_working_ = false;
}

void Simulator::admit(std::size_t count) noexcept {
  buffer_.push(arriving_.first(count));
  arriving_ = arriving_.subspan(count);
}

std::size_t Simulator::arrivals_by(std::int64_t time_ns) const noexcept {
  const auto arrived = [&](const Event& event) {
    return packager_.axis().to_ns(event.t) <= time_ns;
  };
  // Gallop first: the answer is mostly near the front of a long chunk.
  std::size_t known = 0;
  std::size_t ahead = 1;
  while (ahead <= arriving_.size() && arrived(arriving_[ahead - 1])) {
    known = ahead;
    ahead *= 2;
  }
  const EventSpan rest = arriving_.subspan(known, std::min(ahead - 1, arriving_.size()) - known);
  const auto end = std::partition_point(rest.begin(), rest.end(), arrived);
  return known + static_cast<std::size_t>(end - rest.begin());
}

}  // namespace asap
