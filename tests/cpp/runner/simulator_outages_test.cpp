// R4 on a busy machine: an algorithm five times too slow that is taken off the processor
// again and again, under Deadline, in virtual time.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "asap/runner/simulator.hpp"
#include "asap/schemes/deadline.hpp"
#include "core/random.hpp"
#include "support/streams.hpp"

namespace asap::simulator_outages_test {
namespace {

using namespace std::chrono_literals;

constexpr double kAlphaUs = 100;
constexpr double kBetaNs = 5000;
constexpr std::int64_t kSecondUs = 1'000'000;

// So many ms off the processor in every on + off, give or take 30 %.
std::vector<Outage> time_slices(double on_ms, double off_ms, std::uint64_t seed) {
  const CounterRandom random(seed);
  std::vector<Outage> outages;
  double now_ms = on_ms * random.uniform(0);
  for (std::uint64_t i = 1; now_ms < 2100; i += 2) {
    const double end_ms = now_ms + off_ms * (0.7 + 0.6 * random.uniform(i));
    outages.push_back({std::llround(now_ms * 1e6), std::llround(end_ms * 1e6)});
    now_ms = end_ms + on_ms * (0.7 + 0.6 * random.uniform(i + 1));
  }
  return outages;
}

struct Result {
  double p99, max;  // of the latency, in bounds
  double kept, in_time;
  double alpha_us, beta_ns;  // as learnt
};

Result overloaded(std::chrono::nanoseconds bound, std::vector<Outage> outages) {
  Deadline scheme({.latency = bound});
  Simulator simulator(
      scheme, LinearCost({.alpha_us = kAlphaUs, .beta_ns = kBetaNs, .outages = std::move(outages)}),
      {.execution = Execution::anytime});
  simulator.feed(test::evenly_spaced(2 * kSecondUs, 1));
  simulator.finish();
  const LatencyHistogram& latency = simulator.stats().latency;
  const auto received = static_cast<double>(simulator.ledger().received);
  const auto bound_ns = static_cast<double>(bound.count());
  return {.p99 = latency.quantile_ns(0.99) / bound_ns,
          .max = static_cast<double>(latency.max_ns()) / bound_ns,
          .kept = static_cast<double>(latency.count()) / received,
          .in_time = static_cast<double>(latency.within_bound()) / received,
          .alpha_us = scheme.alpha_ns() * 1e-3,
          .beta_ns = scheme.beta_ns()};
}

TEST(SimulatorOutages, WithoutThemTheBoundHolds) {
  const Result alone = overloaded(10ms, {});
  EXPECT_LE(alone.max, 1.001);
  EXPECT_GT(alone.kept, 0.195);
  EXPECT_NEAR(alone.alpha_us, kAlphaUs, 1);
}

TEST(SimulatorOutages, HalfTheProcessorInSlices) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Result busy = overloaded(10ms, time_slices(4, 4, seed));
    EXPECT_LT(busy.p99, 1.25) << seed;
    EXPECT_GT(busy.kept, 0.093) << seed;
    EXPECT_GT(busy.in_time, 0.088) << seed;
    EXPECT_NEAR(busy.alpha_us, kAlphaUs, 0.6 * kAlphaUs) << seed;
    EXPECT_NEAR(busy.beta_ns, kBetaNs, 0.05 * kBetaNs) << seed;

    const Result patient = overloaded(20ms, time_slices(4, 4, seed));
    EXPECT_LT(patient.p99, 1.12) << seed;  // of twenty seeds 1.12, median 1.05
    EXPECT_GT(patient.in_time, 0.093) << seed;
  }
}

TEST(SimulatorOutages, ASliceNowAndThen) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Result busy = overloaded(10ms, time_slices(20, 4, seed));
    EXPECT_LT(busy.p99, 1.15) << seed;
    EXPECT_GT(busy.in_time, 0.155) << seed;
    EXPECT_NEAR(busy.alpha_us, kAlphaUs, 0.3 * kAlphaUs) << seed;
  }
}

}  // namespace
}  // namespace asap::simulator_outages_test
