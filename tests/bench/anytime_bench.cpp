// Bars: anytime strata add at most 2 % to the time of a package of 1000 events and more; a decision
// of Deadline and its feed back take at most 1 us, whatever waits. The rival of an anytime package
// is the same package taken whole: passes over a stream in turn, and of each package the median.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "algorithms/cluster_streams.hpp"
#include "asap/algorithms/published_cluster_tracker.hpp"
#include "asap/schemes/deadline.hpp"
#include "core/random.hpp"
#include "packager/event_times.hpp"
#include "packager/packager.hpp"
#include "support/streams.hpp"

namespace {

using asap::Event;
using asap::EventSpan;
using Steady = std::chrono::steady_clock;

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Steady::now().time_since_epoch())
      .count();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// ---- strata

// Takes all that waits, with time for all of it.
class TakeAll final : public asap::Scheme {
 public:
  asap::Decision decide(const asap::Backlog& backlog) noexcept override {
    asap::Decision decision = asap::Decision::take(backlog.count);
    decision.budget_ns = 1'000'000'000'000;
    decision.event_ns = 50;
    return decision;
  }
  std::string_view name() const noexcept override { return "take_all"; }
};

// Ring, packager and algorithm, under the steady clock.
template <class Algorithm>
class Rig {
 public:
  Rig(asap::Execution execution, std::size_t size)
      : buffer_(size), packager_(buffer_, ages_, scheme_, telemetry_, {.execution = execution}) {
    packager_.begin(asap::TimeAxis(0, 1.0), 0);
  }

  // Time of one package, from the question to the booked row.
  double time(EventSpan events) {
    buffer_.push(events);
    telemetry_.log.make_room();
    const std::int64_t begin_ns = now_ns();
    asap::Package package = packager_.next(begin_ns).package;
    std::int64_t at_ns = begin_ns;
    for (EventSpan part; !(part = packager_.stratum(package, at_ns)).empty(); at_ns = now_ns()) {
      algorithm_(part);
    }
    packager_.complete(package, at_ns);
    return static_cast<double>(now_ns() - begin_ns);
  }

 private:
  asap::EventBuffer buffer_;
  asap::AgeSlots ages_{156'250};
  TakeAll scheme_;
  asap::Telemetry telemetry_{1'000'000'000'000};
  asap::Packager packager_;
  Algorithm algorithm_;
};

// A chain of dependent operations per event.
template <int kRounds>
class Chain {
 public:
  void operator()(EventSpan events) {
    for (const Event& event : events) {
      state_ ^= event.x;
      for (int i = 0; i < kRounds; ++i) state_ = asap::detail::mix(state_);
    }
    benchmark::DoNotOptimize(state_);
  }

 private:
  std::uint64_t state_ = 1;
};

class Clusters {
 public:
  void operator()(EventSpan events) { tracker_.process(events); }

 private:
  asap::PublishedClusterTracker tracker_{{.width = 346, .height = 260}};
};

// Times of one package in all passes.
using Times = std::vector<double>;

template <class Algorithm>
double pass(asap::Execution execution, EventSpan events, std::size_t size,
            std::vector<Times>& packages) {
  Rig<Algorithm> rig(execution, size);
  packages.resize(events.size() / size);
  double sum_ns = 0;
  for (std::size_t i = 0; i < packages.size(); ++i) {
    packages[i].push_back(rig.time(events.subspan(i * size, size)));
    sum_ns += packages[i].back();
  }
  return sum_ns;
}

double sum_of_medians(const std::vector<Times>& packages) {
  double sum = 0;
  for (const Times& times : packages) sum += median(times);
  return sum;
}

template <class Algorithm>
void BM_Strata(benchmark::State& state) {
  const auto size = static_cast<std::size_t>(state.range(0));
  const std::vector<Event> events = asap::test::golden_stream(60'000);
  std::vector<Times> whole;
  std::vector<Times> anytime;
  for (auto _ : state) {
    pass<Algorithm>(asap::Execution::whole, events, size, whole);
    state.SetIterationTime(1e-9 * pass<Algorithm>(asap::Execution::anytime, events, size, anytime));
  }
  const double whole_ns = sum_of_medians(whole);
  const double anytime_ns = sum_of_medians(anytime);
  state.counters["whole_ns_per_event"] = whole_ns / static_cast<double>(events.size());
  state.counters["anytime_ns_per_event"] = anytime_ns / static_cast<double>(events.size());
  state.counters["added_percent"] = 100 * (anytime_ns / whole_ns - 1);
}
BENCHMARK(BM_Strata<Chain<6>>)->ArgName("size")->Arg(1000)->Arg(10'000)->UseManualTime();
BENCHMARK(BM_Strata<Chain<16>>)->ArgName("size")->Arg(1000)->Arg(10'000)->UseManualTime();
BENCHMARK(BM_Strata<Clusters>)->ArgName("size")->Arg(1000)->Arg(10'000)->UseManualTime();

// ---- the scheme

// Waiting events, counted as the packager does.
class Waiting final : public asap::BacklogCounts {
 public:
  Waiting(std::size_t count, std::int64_t span_ns) : span_ns_(span_ns) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto share = static_cast<double>(i) / static_cast<double>(count);
      events_.push_back(asap::test::numbered(
          i, static_cast<std::int64_t>(share * static_cast<double>(span_ns) * 1e-3)));
    }
    ages_.observe(events_, 0, [](std::int64_t stamp) { return 1000 * stamp; });
  }

  std::size_t before(std::int64_t time_ns) const noexcept override {
    const auto end = std::partition_point(events_.begin(), events_.end(),
                                          [=](const Event& e) { return 1000 * e.t < time_ns; });
    return static_cast<std::size_t>(end - events_.begin());
  }
  std::size_t about_before(std::int64_t time_ns) const noexcept override {
    return ages_.before(time_ns, span_ns_, 0, events_.size());
  }

  asap::Backlog backlog() const noexcept {
    return {.count = events_.size(),
            .now_ns = span_ns_,
            .oldest_ns = 0,
            .previous_start_ns = span_ns_ - 2'000'000,
            .due = false,
            .counts = *this};
  }

 private:
  std::int64_t span_ns_;
  std::vector<Event> events_;
  asap::AgeSlots ages_{156'250};
};

// Costs of 100 us + 300 ns per event, a little noisy, at sizes that vary.
void BM_DeadlineDecideAndObserve(benchmark::State& state) {
  const Waiting waiting(static_cast<std::size_t>(state.range(0)), 8'000'000);
  asap::Deadline scheme;
  scheme.reset(state.range(1) == 0 ? asap::Execution::anytime : asap::Execution::whole);
  const asap::Backlog backlog = waiting.backlog();
  const asap::CounterRandom random(1);
  std::uint64_t packages = 0;
  std::uint64_t thinned = 0;
  std::uint64_t waits = 0;
  for (auto _ : state) {
    const asap::Decision decision = scheme.decide(backlog);
    if (!decision.takes) ++waits;
    if (decision.gamma < 1.0) ++thinned;
    const std::size_t size = 1000 + random(packages) % 8000;
    const double factor = 0.9 + 0.2 * random.uniform(packages++);
    const auto cost_ns =
        static_cast<std::int64_t>(factor * (1e5 + 300.0 * static_cast<double>(size)));
    scheme.observe({.size = size,
                    .raw = std::max(size, decision.raw),
                    .span_ns = 2'000'000,
                    .start_ns = backlog.now_ns,
                    .processing_ns = cost_ns});
  }
  const auto share = benchmark::Counter::kAvgIterations;
  state.counters["thinned"] = benchmark::Counter(static_cast<double>(thinned), share);
  state.counters["waits"] = benchmark::Counter(static_cast<double>(waits), share);
}
BENCHMARK(BM_DeadlineDecideAndObserve)
    ->ArgNames({"waiting", "whole"})
    ->ArgsProduct({{100, 10'000, 30'000, 1'000'000}, {0, 1}});

}  // namespace
