#include "asap/telemetry/latency_histogram.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "core/random.hpp"
#include "support/errors.hpp"

namespace asap::latency_histogram_test {
namespace {

constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();

// The smallest value that at least the fraction q does not exceed.
std::int64_t exact_quantile(const std::vector<std::int64_t>& sorted, double q) {
  const double wanted = std::ceil(q * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(wanted, 1.0)) - 1];
}

TEST(LatencyHistogram, RecordsManyAtOnceAsOneByOne) {
  LatencyHistogram together(1'000'000);
  LatencyHistogram singly(1'000'000);
  LatencyHistogram batched(1'000'000);
  const std::int64_t latencies[] = {-5, 0, 999'999, 1'000'000, 1'000'001, std::int64_t{1} << 62};
  std::size_t count = 1;
  for (const std::int64_t latency_ns : latencies) {
    together.record(latency_ns, count);
    LatencyHistogram::Batch batch(batched);
    for (std::size_t i = 0; i < count; ++i) {
      singly.record(latency_ns);
      batch.record(latency_ns);
    }
    count = 3 * count + 1;
  }
  const LatencyHistogram::State one = singly.state();
  EXPECT_GT(one.sum_high, 0u);
  for (const LatencyHistogram* each : {&together, &batched}) {
    const LatencyHistogram::State state = each->state();
    EXPECT_EQ(state.bins, one.bins);
    EXPECT_EQ(state.max_ns, one.max_ns);
    EXPECT_EQ(state.within_bound, one.within_bound);
    EXPECT_EQ(state.sum_low, one.sum_low);
    EXPECT_EQ(state.sum_high, one.sum_high);
    EXPECT_EQ(each->count(), singly.count());
  }
}

TEST(LatencyHistogram, QuantilesAreWithinHalfAPercent) {
  const std::vector<std::function<double(double)>> distributions{
      [](double u) { return 1e3 * u; },
      [](double u) { return 5e6 + 1e4 * u; },
      [](double u) { return -1e6 * std::log1p(-u); },
      [](double u) { return 1e4 * std::pow(1 - u, -1.2); },
      [](double u) { return u < 0.9 ? 1e5 + u : 9e9 + u; },
      [](double u) { return std::pow(2.0, 62 * u); },
      [](double u) { return std::floor(300 * u); },
      [](double) { return 12345.0; },
  };
  for (std::size_t d = 0; d < distributions.size(); ++d) {
    const CounterRandom random(d);
    LatencyHistogram histogram;
    std::vector<std::int64_t> values;
    for (std::uint64_t i = 0; i < 20'001; ++i) {
      values.push_back(static_cast<std::int64_t>(distributions[d](random.uniform(i))));
      histogram.record(values.back());
    }
    std::sort(values.begin(), values.end());
    double last = 0;
    for (const double q : {0.0, 1e-9, 0.001, 0.01, 0.25, 0.5, 0.75, 0.9, 0.99, 0.999, 1.0}) {
      const auto exact = static_cast<double>(exact_quantile(values, q));
      const double quantile = histogram.quantile_ns(q);
      EXPECT_NEAR(quantile, exact, 0.005 * exact) << "distribution " << d << ", q = " << q;
      EXPECT_LE(quantile, static_cast<double>(values.back()));
      EXPECT_GE(quantile, last) << "quantiles do not fall";
      last = quantile;
    }
    EXPECT_EQ(histogram.quantile_ns(1.0), static_cast<double>(values.back()));
    EXPECT_EQ(histogram.max_ns(), values.back());
  }
}

TEST(LatencyHistogram, MeanMaxAndCountsAreExact) {
  LatencyHistogram histogram(1000);
  for (const std::int64_t value : {0, 1, 999, 1000, 1001, 123'457}) histogram.record(value);
  EXPECT_EQ(histogram.count(), 6u);
  EXPECT_EQ(histogram.within_bound(), 4u);
  EXPECT_EQ(histogram.bound_ns(), 1000);
  EXPECT_EQ(histogram.max_ns(), 123'457);
  EXPECT_EQ(histogram.mean_ns(), (1 + 999 + 1000 + 1001 + 123'457) / 6.0);
}

TEST(LatencyHistogram, SumsBeyondSixtyFourBits) {
  LatencyHistogram histogram;
  for (int i = 0; i < 100; ++i) histogram.record(kMax);
  EXPECT_DOUBLE_EQ(histogram.mean_ns(), static_cast<double>(kMax));
  EXPECT_EQ(histogram.max_ns(), kMax);
  EXPECT_EQ(histogram.quantile_ns(1.0), static_cast<double>(kMax));
}

TEST(LatencyHistogram, ANegativeLatencyCountsAsZero) {
  LatencyHistogram histogram(0);
  histogram.record(-5);
  histogram.record(std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(histogram.count(), 2u);
  EXPECT_EQ(histogram.within_bound(), 2u);
  EXPECT_EQ(histogram.max_ns(), 0);
  EXPECT_EQ(histogram.mean_ns(), 0.0);
}

TEST(LatencyHistogram, OfNothingIsZero) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.mean_ns(), 0.0);
  EXPECT_EQ(histogram.max_ns(), 0);
  for (const double q : {0.0, 0.5, 1.0}) EXPECT_EQ(histogram.quantile_ns(q), 0.0);
}

TEST(LatencyHistogram, IsRestoredFromItsState) {
  LatencyHistogram histogram(1000);
  for (const std::int64_t latency : {0, 3, 1000, 1001, 5'000'000}) histogram.record(latency);
  histogram.record(kMax, 7);  // the sum has more than 64 bits
  LatencyHistogram::State state = histogram.state();
  const LatencyHistogram restored = LatencyHistogram::restored(state);
  EXPECT_EQ(restored.count(), 12u);
  EXPECT_EQ(restored.within_bound(), 3u);
  EXPECT_EQ(restored.bound_ns(), 1000);
  EXPECT_EQ(restored.max_ns(), kMax);
  EXPECT_EQ(restored.mean_ns(), histogram.mean_ns());
  for (const double q : {0.0, 0.2, 0.4, 1.0}) {
    EXPECT_EQ(restored.quantile_ns(q), histogram.quantile_ns(q));
  }
  state.bins.emplace_back(1 << 20, 1);
  EXPECT_EQ(test::error_of([&] { LatencyHistogram::restored(state); }),
            "bin = 1048576: does not exist; the file is damaged");
}

TEST(LatencyHistogram, RefusesAFractionThatIsNone) {
  const LatencyHistogram histogram;
  const auto error = [&](double q) {
    return test::error_of([&] { (void)histogram.quantile_ns(q); });
  };
  EXPECT_EQ(error(-0.1), "q = -0.1: must be a number between 0 and 1");
  EXPECT_EQ(error(1.1), "q = 1.1: must be a number between 0 and 1");
  EXPECT_EQ(error(std::numeric_limits<double>::quiet_NaN()),
            "q = nan: must be a number between 0 and 1");
}

TEST(LatencyHistogram, TellsWhatCameSinceACopy) {
  LatencyHistogram histogram(5000);
  LatencyHistogram expected(5000);
  for (std::int64_t value = 1; value < 1'000'000; value = value * 3 + 1) histogram.record(value);
  histogram.record(std::int64_t{1} << 62, 3);  // sums beyond 64 bits
  const LatencyHistogram earlier = histogram;
  for (std::int64_t value = 7; value < 100'000; value = value * 2 + 1) {
    histogram.record(value);
    expected.record(value);
  }
  histogram.record(std::int64_t{1} << 62, 2);
  expected.record(std::int64_t{1} << 62, 2);
  const LatencyHistogram since = histogram.since(earlier);
  EXPECT_EQ(since.count(), expected.count());
  EXPECT_EQ(since.within_bound(), expected.within_bound());
  EXPECT_DOUBLE_EQ(since.mean_ns(), expected.mean_ns());
  EXPECT_EQ(since.max_ns(), expected.max_ns());
  EXPECT_EQ(since.quantile_ns(0.5), expected.quantile_ns(0.5));
  EXPECT_EQ(histogram.since(histogram).max_ns(), 0);
}

}  // namespace
}  // namespace asap::latency_histogram_test
