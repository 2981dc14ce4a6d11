// Overload without randomness, for the laws alone: events come at a steady rate and are never
// stored, a package costs alpha + beta n exactly. An anytime package ends on its budget as if the
// clock were read after every event.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "asap/schemes/scheme.hpp"

namespace asap::test {

// Waiting events [head, tail) of a steady stream: number i has the time i * period.
class SteadyBacklog final : public BacklogCounts {
 public:
  explicit SteadyBacklog(double period_ns) : period_ns_(period_ns) {}

  std::size_t before(std::int64_t time_ns) const noexcept override {
    const double events = std::ceil(static_cast<double>(time_ns) / period_ns_);
    const auto end = static_cast<std::size_t>(std::max(events, 0.0));
    return std::clamp(end, head, tail) - head;
  }
  std::size_t about_before(std::int64_t time_ns) const noexcept override { return before(time_ns); }
  std::int64_t time_of(std::size_t i) const noexcept {
    return static_cast<std::int64_t>(static_cast<double>(i) * period_ns_);
  }
  void arrive_by(std::int64_t now_ns) noexcept {
    tail = std::max(tail, 1 + static_cast<std::size_t>(static_cast<double>(now_ns) / period_ns_));
  }

  std::size_t head = 0;
  std::size_t tail = 0;

 private:
  const double period_ns_;
};

struct Law {
  double alpha_ns;
  double beta_ns;
};

struct SteadyRun {
  double kept;        // of the events that have left, from a fifth of the run on
  double latency_ns;  // the longest
  double size;        // mean of a package
  std::size_t stale;
  std::size_t packages;
};

// Runs the scheme for duration_ns; cost(index) is the law of package `index`.
inline SteadyRun run_steady(Scheme& scheme, Execution execution, double events_per_us,
                            std::int64_t duration_ns, const std::function<Law(std::size_t)>& cost) {
  scheme.reset(execution);
  const double period_ns = 1000.0 / events_per_us;
  SteadyBacklog waiting(period_ns);
  SteadyRun run{};
  double kept = 0, left = 0;
  std::int64_t now_ns = 0, previous_ns = kLongAgo;
  while (now_ns < duration_ns) {
    waiting.arrive_by(now_ns);
    if (waiting.head == waiting.tail) {
      now_ns = waiting.time_of(waiting.tail) + 1;
      continue;
    }
    const std::int64_t oldest_ns = waiting.time_of(waiting.head);
    const Decision decision = scheme.decide({.count = waiting.tail - waiting.head,
                                             .now_ns = now_ns,
                                             .oldest_ns = oldest_ns,
                                             .previous_start_ns = previous_ns,
                                             .due = false,
                                             .counts = waiting});
    if (!decision.takes) {
      const auto ahead = std::min<std::size_t>(decision.until_count, std::size_t{1} << 40);
      now_ns = std::max(now_ns + 1,
                        std::min(decision.until_ns, waiting.time_of(waiting.head + ahead - 1) + 1));
      continue;
    }
    waiting.head += decision.stale;
    run.stale += decision.stale;
    if (decision.raw == 0) continue;
    const Law law = cost(run.packages);
    const auto raw = static_cast<double>(decision.raw);
    double size = decision.gamma * raw;
    if (execution == Execution::anytime) {
      const auto budget_ns = static_cast<double>(decision.budget_ns);
      size = std::min(raw, std::max(1.0, (budget_ns - law.alpha_ns) / law.beta_ns));
    }
    size = std::max(1.0, std::floor(size));
    const auto cost_ns = static_cast<std::int64_t>(law.alpha_ns + law.beta_ns * size);
    if (now_ns > duration_ns / 5) {
      kept += size;
      left += raw + static_cast<double>(decision.stale);
    }
    const auto latency_ns = static_cast<double>(now_ns + cost_ns - waiting.time_of(waiting.head));
    run.latency_ns = std::max(run.latency_ns, latency_ns);
    run.size += size;
    ++run.packages;
    scheme.observe({.size = static_cast<std::size_t>(size),
                    .raw = decision.raw,
                    .span_ns = 0,
                    .start_ns = now_ns,
                    .processing_ns = cost_ns});
    waiting.head += decision.raw;
    previous_ns = now_ns;
    now_ns += std::max<std::int64_t>(cost_ns, 1);
  }
  run.kept = kept / left;
  run.size /= static_cast<double>(run.packages);
  return run;
}

}  // namespace asap::test
