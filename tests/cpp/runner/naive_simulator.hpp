// A run in virtual time, written down as directly as possible: one event after the other, a deque
// for the ring, no chunks, no packager. What the Simulator must agree with, row by row.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <vector>

#include "asap/core/random.hpp"
#include "asap/filter/gamma_filter.hpp"
#include "asap/runner/linear_cost.hpp"
#include "asap/schemes/rate_meter.hpp"
#include "asap/schemes/scheme.hpp"
#include "asap/telemetry/ledger.hpp"
#include "asap/telemetry/run_log.hpp"

namespace asap::test {

class NaiveSimulator final : public BacklogCounts {
 public:
  NaiveSimulator(Scheme& scheme, LinearCost cost, std::int64_t bound_ns, std::size_t capacity,
                 std::uint64_t seed)
      : scheme_(scheme), cost_(cost), bound_ns_(bound_ns), capacity_(capacity), random_(seed) {
    scheme.reset();
  }

  void run(EventSpan events) {
    if (events.empty()) return;
    zero_us_ = events[0].t - events[0].t % 1'000'000;
    future_.assign(events.begin(), events.end());
    ledger.received = events.size();
    now_ns_ = ns(future_.front());
    for (;;) {
      let_arrive_until(now_ns_);
      if (ring_.empty() && future_.empty()) return;
      if (ring_.empty()) {
        now_ns_ = ns(future_.front());
        continue;
      }
      const Decision decision = decide();
      if (decision.takes) {
        take(decision);
      } else {
        wait(decision);
      }
    }
  }

  std::size_t before(std::int64_t time_ns) const noexcept override {
    std::size_t count = 0;
    while (count < ring_.size() && ns(ring_[count]) < time_ns) ++count;
    return count;
  }

  std::vector<PackageRow> rows;
  Ledger ledger;

 private:
  std::int64_t ns(const Event& event) const noexcept { return (event.t - zero_us_) * 1000; }

  void let_arrive_until(std::int64_t time_ns) {
    while (!future_.empty() && ns(future_.front()) <= time_ns) {
      if (ring_.size() + in_work_ < capacity_) {
        ring_.push_back(future_.front());
      } else {
        ++ledger.overflow;
      }
      future_.pop_front();
    }
  }

  bool due() const {
    return future_.empty() || ring_.size() == capacity_ || now_ns_ - ns(ring_[0]) >= bound_ns_;
  }

  Decision decide() {
    Decision decision = scheme_.decide({.count = ring_.size(),
                                        .now_ns = now_ns_,
                                        .oldest_ns = ns(ring_[0]),
                                        .previous_start_ns = previous_start_ns_,
                                        .due = due(),
                                        .counts = *this});
    if (!decision.takes && due()) decision = Decision::take(ring_.size());
    return decision;
  }

  // One arrival, or the deadline, at a time.
  void wait(const Decision& decision) {
    const std::int64_t deadline_ns = std::min(decision.until_ns, ns(ring_[0]) + bound_ns_);
    while (ring_.size() < decision.until_count && !due()) {
      if (ns(future_.front()) > deadline_ns) {
        now_ns_ = deadline_ns;
        return;
      }
      now_ns_ = ns(future_.front());
      let_arrive_until(now_ns_);
    }
  }

  void take(const Decision& decision) {
    std::vector<Event> kept;
    const std::size_t raw = std::min(decision.raw, ring_.size());
    meter_.observe(raw, ns(ring_[0]), ns(ring_[raw - 1]));
    for (std::size_t i = 0; i < raw; ++i) {
      const bool keeps = (random_(number_++) >> 1) < KeepThreshold::clamped(decision.keep).value();
      if (keeps) kept.push_back(ring_.front());
      ring_.pop_front();
    }
    ledger.discarded += raw - kept.size();
    offered_ += raw;
    const std::int64_t start_ns = now_ns_;
    std::int64_t span_ns = 0;
    if (!kept.empty()) {
      const std::uint64_t overflow = ledger.overflow;
      in_work_ = raw;
      now_ns_ += cost_.processing_ns(rows.size(), kept.size());
      let_arrive_until(now_ns_);
      in_work_ = 0;
      span_ns = ns(kept.back()) - ns(kept.front());
      book(kept, start_ns, overflow - overflow_reported_);
      overflow_reported_ = overflow;
    }
    scheme_.observe({.size = kept.size(),
                     .raw = raw,
                     .span_ns = span_ns,
                     .start_ns = start_ns,
                     .processing_ns = now_ns_ - start_ns});
  }

  void book(const std::vector<Event>& kept, std::int64_t start_ns, std::uint64_t overflow) {
    const auto size = static_cast<double>(kept.size());
    const std::int64_t span_ns = ns(kept.back()) - ns(kept.front());
    PackageRow row{};
    row.index = static_cast<std::int64_t>(rows.size());
    row.start_us = static_cast<double>(zero_us_) + static_cast<double>(start_ns) / 1000;
    row.processing_us = static_cast<double>(now_ns_ - start_ns) * 1e-3;
    row.t_first = kept.front().t;
    row.t_last = kept.back().t;
    row.offered = static_cast<std::int64_t>(offered_);
    row.size = static_cast<std::int64_t>(kept.size());
    row.gamma = size / static_cast<double>(offered_);
    row.event_rate = meter_.per_second();
    row.rate = size / (static_cast<double>(std::max<std::int64_t>(span_ns, 1000)) * 1e-9);
    row.margin_us = static_cast<double>(now_ns_ - start_ns - span_ns) * 1e-3;
    row.latency_max_us = static_cast<double>(now_ns_ - ns(kept.front())) * 1e-3;
    row.overflow = static_cast<std::int64_t>(overflow);
    rows.push_back(row);
    ledger.delivered += kept.size();
    offered_ = 0;
    previous_start_ns_ = start_ns;
  }

  Scheme& scheme_;
  LinearCost cost_;
  std::int64_t bound_ns_;
  std::size_t capacity_;
  CounterRandom random_;
  RateMeter meter_;

  std::int64_t zero_us_ = 0;
  std::int64_t now_ns_ = 0;
  std::deque<Event> future_;
  std::deque<Event> ring_;
  std::size_t in_work_ = 0;  // raw events of the package in work: they keep their places
  std::uint64_t number_ = 0;
  std::size_t offered_ = 0;
  std::uint64_t overflow_reported_ = 0;
  std::int64_t previous_start_ns_ = kLongAgo;
};

}  // namespace asap::test
