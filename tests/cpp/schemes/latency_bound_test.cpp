#include "schemes/latency_bound.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/errors.hpp"

namespace asap::latency_bound_test {
namespace {

using test::error_of;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(LatencyBound, IsReadInMilliseconds) {
  EXPECT_EQ(checked_latency_ns(10.0), 10'000'000);
  EXPECT_EQ(checked_latency_ns(0.01), 10'000);
  EXPECT_EQ(checked_latency_ns(0.0123456), 12'346);
  EXPECT_EQ(checked_latency_ns(1e7), 10'000'000'000'000);
}

TEST(LatencyBound, RefusesABoundOutOfRange) {
  const auto error = [](double value) { return error_of([=] { checked_latency_ns(value); }); };
  const std::string remedy = ": must be between 0.01 and 1e7 ms";
  EXPECT_EQ(error(0), "latency_ms = 0" + remedy);
  EXPECT_EQ(error(0.009), "latency_ms = 0.009" + remedy);
  EXPECT_EQ(error(-1), "latency_ms = -1" + remedy);
  EXPECT_EQ(error(2e7), "latency_ms = 20000000" + remedy);
  EXPECT_EQ(error(kNaN), "latency_ms = nan" + remedy);
  EXPECT_EQ(error(kInfinity), "latency_ms = inf" + remedy);
}

}  // namespace
}  // namespace asap::latency_bound_test
