// A run in virtual time, written down as directly as possible: one event after the other, a deque
// for the ring, no chunks, no packager, anytime execution as in notebooks/theory.md, 7. What the
// Simulator must agree with, row by row.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "asap/filter/gamma_filter.hpp"
#include "asap/runner/simulator.hpp"
#include "asap/schemes/scheme.hpp"
#include "asap/telemetry/ledger.hpp"
#include "asap/telemetry/run_log.hpp"
#include "core/random.hpp"
#include "packager/rate_meter.hpp"
#include "runner/admission.hpp"
#include "telemetry/slot_log.hpp"
#include "telemetry/telemetry.hpp"

namespace asap::test {

struct NaiveConfig {
  std::int64_t bound_ns = 10'000'000;
  std::size_t capacity = std::size_t{1} << 20;
  std::uint64_t seed = 0;
  Execution execution = Execution::whole;
  bool flush = true;
  Admission* admission = nullptr;
};

class NaiveSimulator final : public BacklogCounts {
 public:
  NaiveSimulator(Scheme& scheme, LinearCost cost, NaiveConfig config)
      : scheme_(scheme),
        cost_(cost),
        config_(config),
        random_(config.seed),
        admission_random_(config.seed ^ 0x61646d6974) {
    scheme.reset(config.execution);
  }

  void run(EventSpan events) {
    if (events.empty()) return;
    zero_us_ = events[0].t - events[0].t % 1'000'000;
    future_.assign(events.begin(), events.end());
    received.assign(events.begin(), events.end());
    ledger.received = events.size();
    for (const Event& event : events) ++slot_of(event).received;
    now_ns_ = ns(future_.front());
    next_ask_ns_ = now_ns_;
    for (;;) {
      let_arrive_until(now_ns_);
      if (ring_.empty() && future_.empty()) return;
      if (ring_.empty()) {
        now_ns_ = ns(future_.front());
        continue;
      }
      if (cost_.start_ns(now_ns_) > now_ns_) {
        now_ns_ = cost_.start_ns(now_ns_);
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

  std::size_t about_before(std::int64_t time_ns) const noexcept override { return before(time_ns); }

  std::vector<PackageRow> rows;
  std::vector<Event> received;
  std::vector<Event> delivered;
  std::map<std::int64_t, Slot> slots;  // by their number
  Ledger ledger;
  std::int64_t busy_ns = 0;

 private:
  Slot& slot_of(const Event& event) {
    const std::int64_t slot = (event.t - (event.t % 1000 + 1000) % 1000) / 1000;
    return slots.insert({slot, {slot, 0, 0, 0}}).first->second;
  }

  std::int64_t ns(const Event& event) const noexcept { return (event.t - zero_us_) * 1000; }

  void let_arrive_until(std::int64_t time_ns) {
    while (!future_.empty() && ns(future_.front()) <= time_ns) {
      ask_admission_until(ns(future_.front()));
      arrive(future_.front());
      future_.pop_front();
    }
    if (!future_.empty()) ask_admission_until(time_ns);
  }

  void arrive(const Event& event) {
    ++arrived_;
    const std::uint64_t bar = KeepThreshold::clamped(admission_gamma_).value();
    if (config_.admission != nullptr && (admission_random_(admission_number_++) >> 1) >= bar) {
      ++ledger.discarded;
    } else if (ring_.size() == config_.capacity) {
      ++ledger.overflow;
    } else {
      ring_.push_back(event);
    }
  }

  void ask_admission_until(std::int64_t time_ns) {
    if (config_.admission == nullptr) return;
    for (; next_ask_ns_ <= time_ns; next_ask_ns_ += config_.admission->period_ns()) {
      const std::size_t waiting = ring_.size() - in_work_;
      admission_gamma_ =
          config_.admission->gamma({.now_ns = next_ask_ns_,
                                    .arrived = arrived_,
                                    .waiting = waiting,
                                    .oldest_ns = waiting > 0 ? ns(ring_[in_work_]) : next_ask_ns_});
      arrived_ = 0;
    }
  }

  std::int64_t flush_ns() const { return config_.flush ? ns(ring_[0]) + config_.bound_ns : kNever; }

  bool due() const {
    return future_.empty() || ring_.size() == config_.capacity || now_ns_ >= flush_ns();
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
    const std::int64_t deadline_ns = std::min(decision.until_ns, flush_ns());
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
    drop(std::min(decision.stale, ring_.size()));
    const std::size_t raw = std::min(decision.raw, ring_.size());
    if (raw == 0) return;
    const std::uint64_t overflow = ledger.overflow;
    const std::int64_t start_ns = now_ns_;
    std::vector<Event> kept;
    if (config_.execution == Execution::anytime && decision.budget_ns != kNever) {
      run_anytime(decision, raw, cost_.package(begun_++, start_ns), kept);
    } else {
      thin_whole(decision, raw, kept);
      if (!kept.empty()) pass(cost_.package(begun_++, start_ns).of(kept.size()));
    }
    meter_.observe(in_work_, ns(ring_[0]), ns(ring_[in_work_ - 1]));
    offered_ += in_work_;
    ledger.discarded += in_work_ - kept.size();
    busy_ns += now_ns_ - start_ns;
    std::int64_t span_ns = 0;
    if (!kept.empty()) {
      span_ns = ns(kept.back()) - ns(kept.front());
      book(kept, start_ns, overflow - overflow_reported_);
      overflow_reported_ = overflow;
    }
    scheme_.observe({.size = kept.size(),
                     .raw = in_work_,
                     .span_ns = span_ns,
                     .start_ns = start_ns,
                     .processing_ns = now_ns_ - start_ns});
    ring_.erase(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(in_work_));
    in_work_ = 0;
  }

  void drop(std::size_t stale) {
    if (stale == 0) return;
    meter_.observe(stale, ns(ring_[0]), ns(ring_[stale - 1]));
    ring_.erase(ring_.begin(), ring_.begin() + static_cast<std::ptrdiff_t>(stale));
    number_ += stale;
    ledger.stale += stale;
    stale_ += stale;
  }

  // The next `count` raw events of the package.
  std::size_t thin(std::size_t count, double keep, std::vector<Event>& kept) {
    std::size_t size = 0;
    for (std::size_t i = 0; i < count; ++i, ++in_work_) {
      if ((random_(number_++) >> 1) >= KeepThreshold::clamped(keep).value()) continue;
      kept.push_back(ring_[in_work_]);
      ++size;
    }
    return size;
  }

  // The same for the last stratum, which keeps a certain number: those of the smallest numbers.
  std::size_t thin_to(std::size_t count, double keep, std::vector<Event>& kept) {
    const auto size = static_cast<std::size_t>(keep * static_cast<double>(count) + 1e-6);
    std::vector<std::uint64_t> numbers;
    for (std::size_t i = 0; i < count; ++i) numbers.push_back(random_(number_ + i) >> 1);
    std::vector<std::uint64_t> sorted = numbers;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = 0; i < count; ++i, ++in_work_) {
      if (size == count || numbers[i] < sorted[size]) kept.push_back(ring_[in_work_]);
    }
    number_ += count;
    return size;
  }

  // Where the time is planned, the last raw / 16 + 128 make up for the chance in those before.
  void thin_whole(const Decision& decision, std::size_t raw, std::vector<Event>& kept) {
    const bool planned = decision.budget_ns != kNever && decision.keep < 1;
    const std::size_t last = planned ? std::min(raw / 16 + 128, raw) : 0;
    thin(raw - last, decision.keep, kept);
    if (last == 0) return;
    const double n = std::max(decision.keep, 0.0) * static_cast<double>(raw);
    const double left = std::max(n - static_cast<double>(kept.size()), 0.0);
    const double keep = left / static_cast<double>(last);
    thin_to(last, std::min(keep, 1.0), kept);
  }

  // Events arrive while the algorithm works.
  void pass(double work_ns) {
    now_ns_ = cost_.done_ns(now_ns_, work_ns);
    let_arrive_until(now_ns_);
  }

  // N raw events, M strata; `end`, k0, tau, m, b, q and f as in 6.2.
  void run_anytime(const Decision& decision, std::size_t raw, PackageCost cost,
                   std::vector<Event>& kept) {
    const double N = static_cast<double>(raw);
    const double n = decision.keep * N;
    const double H = static_cast<double>(decision.budget_ns);
    const double share = std::max(H / 16, 2000.0);
    std::size_t strata = raw / 64;
    for (std::size_t m = strata + 1; m <= 16; ++m) {
      const double m_ns = static_cast<double>(m) * share;
      if (n * std::max(decision.event_ns, decision.max_event_ns) >= m_ns && H >= m_ns) strata = m;
    }
    strata = std::clamp<std::size_t>(strata, 1, std::clamp<std::size_t>(raw, 1, 16));
    const double M = static_cast<double>(strata);
    constexpr std::int64_t kAges = 1'000'000'000'000'000;
    const std::int64_t end = now_ns_ + std::clamp<std::int64_t>(decision.budget_ns, 0, kAges);
    const bool doubted = decision.max_event_ns > decision.event_ns;
    const double trust = doubted ? decision.event_ns / decision.max_event_ns : 1.0;
    const double k0 = std::max(1.0, n / 32 * trust);
    double tau = 0;
    double m = 0;
    const std::int64_t begin = now_ns_;
    const std::int64_t fixed_end = begin + std::llround(std::floor(decision.fixed_ns));
    pass(cost.fixed_ns);
    const bool has_passed = fixed_end - now_ns_ < now_ns_ - begin;  // most of the fixed cost
    const double fixed = std::max(0.0, static_cast<double>(fixed_end - now_ns_));
    std::size_t probe = 0;
    if (strata > 1 && doubted && H > 0) {
      const double safe = std::max(1.0, H / M / decision.max_event_ns);
      if (safe < std::floor(N / M)) probe = static_cast<std::size_t>(safe);
    }
    std::vector<std::pair<std::size_t, std::size_t>> parts;  // of stratum j so many
    if (probe > 0) parts.emplace_back(0, probe);
    for (std::size_t j = 0; j < strata; ++j) {
      const std::size_t count = raw * (j + 1) / strata - raw * j / strata;
      parts.emplace_back(j, j == 0 ? count - probe : count);
    }
    for (const auto& [j, count] : parts) {
      const std::int64_t now = now_ns_;
      if (&j != &parts.front().first && now > end + config_.bound_ns / 100) return;  // an outage
      double left = static_cast<double>(end - now) / (M - static_cast<double>(j));
      if (strata == 1) left -= fixed;
      const double b = (decision.event_ns * k0 + tau) / (k0 + m);
      double q = b > 0 ? std::min(left / b, N / M) : (left >= 0 ? N / M : 0.0);
      const double f = std::max(0.02 * n / M, j == 0 ? 1.0 : 0.0);
      if (q < f) q = std::min(f, N / M);
      const double keep = std::max(q, 0.0) / (N / M);
      const std::size_t size =
          j + 1 < strata ? thin(count, keep, kept) : thin_to(count, std::min(keep, 1.0), kept);
      if (size > 0) pass(cost.event_ns * static_cast<double>(size));
      double events_ns = static_cast<double>(now_ns_ - now);
      if (&j == &parts.front().first && !has_passed) {
        const double beyond = events_ns - static_cast<double>(fixed_end - now);
        const double expected = static_cast<double>(size) * (decision.event_ns * k0) / k0;
        events_ns = std::min(events_ns, std::max(beyond, expected));
      }
      tau += events_ns;
      m += static_cast<double>(size);
    }
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
    row.stale = static_cast<std::int64_t>(stale_);
    row.overflow = static_cast<std::int64_t>(overflow);
    rows.push_back(row);
    delivered.insert(delivered.end(), kept.begin(), kept.end());
    for (const Event& event : kept) {
      Slot& slot = slot_of(event);
      ++slot.delivered;
      slot.latency_max_ns = std::max(slot.latency_max_ns, now_ns_ - ns(event));
    }
    ledger.delivered += kept.size();
    offered_ = 0;
    stale_ = 0;
    previous_start_ns_ = start_ns;
  }

  Scheme& scheme_;
  LinearCost cost_;
  NaiveConfig config_;
  CounterRandom random_;
  CounterRandom admission_random_;
  RateMeter meter_;

  std::int64_t zero_us_ = 0;
  std::int64_t now_ns_ = 0;
  std::deque<Event> future_;
  std::deque<Event> ring_;    // the package in work included
  std::size_t in_work_ = 0;   // raw events of it
  std::uint64_t begun_ = 0;   // packages: each has a draw of its own
  std::uint64_t number_ = 0;  // of the next raw event to be thinned
  std::size_t offered_ = 0;
  std::uint64_t stale_ = 0;
  std::uint64_t overflow_reported_ = 0;
  std::int64_t previous_start_ns_ = kLongAgo;

  std::int64_t next_ask_ns_ = 0;
  double admission_gamma_ = 1.0;
  std::size_t arrived_ = 0;
  std::uint64_t admission_number_ = 0;
};

}  // namespace asap::test
