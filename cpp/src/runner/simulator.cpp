#include "asap/runner/simulator.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "asap/core/check.hpp"

namespace asap {
namespace {

constexpr std::uint64_t kNoTail = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kAdmissionSeed = 0x61646d6974;  // not the gamma filter's numbers

}  // namespace

Simulator::Simulator(Scheme& scheme, LinearCost cost, RunConfig config, Consumer consumer)
    : cost_(std::move(cost)),
      consumer_(std::move(consumer)),
      kept_mask_(config.keep_mask ? std::make_unique<KeptMask>() : nullptr),
      validator_(config.validator, kept_mask_ ? &kept_mask_->passed() : nullptr),
      telemetry_(latency_bound_ns(config, scheme)),
      buffer_(ring_capacity(config, telemetry_.latency.bound_ns())),
      intake_(buffer_, telemetry_.latency.bound_ns(), kept_mask_.get()),
      packager_(buffer_, intake_.ages(), scheme, telemetry_,
                packager_config(config, kept_mask_.get())) {
  if (Admission* admission = scheme.admission()) {
    require(!config.keep_mask, "keep_mask", 1, "not with a scheme that filters on arrival");
    gate_.emplace(*admission, config.seed ^ kAdmissionSeed);
  }
}

void Simulator::feed(EventSpan events) {
  validator_.check(events, [this](EventSpan good) { receive(good); });
}

void Simulator::finish() {
  buffer_.close();
  now_ns_ = std::max(now_ns_, known_until_ns_);
  for (;;) {
    while (is_working_) {
      now_ns_ = busy_until_ns_;
      go_on();
    }
    now_ns_ = cost_.start_ns(now_ns_);
    telemetry_.log.make_room();
    const Packager::Next next = packager_.next(now_ns_);
    if (next.step != Packager::Step::package) return;  // a closed source is never waited for
    begin(next.package);
  }
}

Ledger Simulator::ledger() const noexcept {
  const std::uint64_t at_the_gate = gate_ ? good_ - gate_->seen() : 0;
  return {.received = validator_.received(),
          .rejected = validator_.rejected().total(),
          .filtered = telemetry_.filtered,
          .discarded = telemetry_.discarded + (gate_ ? gate_->discarded() : 0),
          .stale = telemetry_.stale,
          .overflow = buffer_.overflow(),
          .delivered = telemetry_.delivered,
          .pending = buffer_.size() + arriving_.size() + at_the_gate};
}

void Simulator::receive(EventSpan good) {
  if (good.empty()) return;
  if (!started_) start(good.front());
  good_ += good.size();
  slots_.received(good);
  if (!gate_) {
    arriving_ = good;
    return run_while_known();
  }
  gate_->pass(
      good, packager_.axis(), [this](Arrivals& arrivals) { look(arrivals); },
      [this](EventSpan admitted) {
        arriving_ = admitted;
        run_while_known();
      });
  run_until(packager_.axis().to_ns(good.back().t));
}

void Simulator::start(const Event& first) {
  packager_.set_axis(TimeAxis(first.t, 1.0));
  now_ns_ = packager_.axis().to_ns(first.t);
  started_ = true;
}

void Simulator::run_until(std::int64_t time_ns) {
  known_until_ns_ = time_ns;
  run_while_known();
}

void Simulator::look(Arrivals& arrivals) {
  run_until(arrivals.now_ns);
  const EventPieces in_ring = buffer_.peek();
  const std::size_t in_work = is_working_ ? working_.raw : 0;
  arrivals.waiting = in_ring.size() - in_work;
  arrivals.oldest_ns =
      arrivals.waiting > 0 ? packager_.axis().to_ns(in_ring[in_work].t) : arrivals.now_ns;
}

bool Simulator::knows(std::int64_t time_ns) const noexcept {
  return !arriving_.empty() || time_ns < known_until_ns_;
}

void Simulator::run_while_known() {
  for (;;) {
    if (is_working_ && !work()) return;
    if (is_working_) continue;
    if (is_waiting_ && !wait(waiting_)) return;
    admit(arrivals_by(now_ns_));
    if (!knows(now_ns_)) return;  // the next chunk may hold more for this moment
    const std::int64_t free_ns = cost_.start_ns(now_ns_);
    if (free_ns > now_ns_) {
      waiting_ = {.step = Packager::Step::wait, .until_ns = free_ns, .until_tail = kNoTail};
      is_waiting_ = true;
      continue;
    }
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

bool Simulator::work() {
  admit(arrivals_by(busy_until_ns_));
  if (!knows(busy_until_ns_)) return false;  // the next chunk may hold more for this time
  now_ns_ = busy_until_ns_;
  go_on();
  return true;
}

bool Simulator::wait(const Packager::Next& next) {
  const std::uint64_t missing = next.until_tail - buffer_.tail();
  const std::size_t by_time = arrivals_by(next.until_ns);
  if (missing > by_time && by_time == arriving_.size() && next.until_ns >= known_until_ns_) {
    if (!arriving_.empty()) now_ns_ = packager_.axis().to_ns(arriving_.back().t);
    admit(arriving_.size());
    return false;
  }
  now_ns_ = missing <= by_time ? packager_.axis().to_ns(arriving_[missing - 1].t) : next.until_ns;
  is_waiting_ = false;
  return true;
}

void Simulator::begin(const Package& package) {
  working_ = package;
  is_working_ = true;
  working_cost_ = cost_.package(begun_++, package.start_ns);
  // An anytime package shows its events later, stratum by stratum.
  const bool is_whole = !package.events.empty();
  const std::size_t size = is_whole ? packager_.stratum(working_, now_ns_).size() : 0;
  busy_until_ns_ = cost_.done_ns(now_ns_, working_cost_.of(size));
}

void Simulator::go_on() {
  const EventSpan part = packager_.stratum(working_, now_ns_);
  if (!part.empty()) {
    const double work_ns = working_cost_.event_ns * static_cast<double>(part.size());
    busy_until_ns_ = cost_.done_ns(now_ns_, work_ns);
    return;
  }
  is_working_ = false;
  if (consumer_ && !working_.events.empty()) consumer_(working_);
  slots_.delivered(working_.events, now_ns_, packager_.axis());
  busy_ns_ += now_ns_ - working_.start_ns;
  packager_.complete(working_, now_ns_);
}

void Simulator::admit(std::size_t count) {
  intake_.push(arriving_.first(count), packager_.axis());
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
