#include "asap/schemes/outage_reserve.hpp"

#include <gtest/gtest.h>

namespace asap::outage_reserve_test {
namespace {

constexpr double kBound = 1000.0;
constexpr double kSpan = 400.0;
constexpr double kAlpha = 10.0;

TEST(OutageReserve, GrowsWithTheShareOfLateEvents) {
  OutageReserve reserve;
  EXPECT_EQ(reserve.ns(kBound, kAlpha), 0.0);
  reserve.observe(1100, kSpan, kBound);  // a quarter of the span is late
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), 0.05 * (0.25 - 0.005) * kBound, 1e-9);
  EXPECT_NEAR(reserve.ns(2 * kBound, kAlpha), 0.1 * (0.25 - 0.005) * kBound, 1e-9);
  reserve.observe(5000, kSpan, kBound);  // all of it
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), 0.05 * (1.25 - 0.01) * kBound, 1e-9);
  reserve.observe(1011, 0, kBound);  // one event
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), 0.05 * (2.25 - 0.015) * kBound, 1e-9);
}

TEST(OutageReserve, ShrinksWhileNothingIsLate) {
  OutageReserve reserve;
  for (int k = 0; k < 4; ++k) reserve.observe(5000, kSpan, kBound);
  const double before = reserve.ns(kBound, kAlpha);
  for (int k = 0; k < 100; ++k) reserve.observe(1000, kSpan, kBound);
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), before - 100 * 0.05 * 0.005 * kBound, 1e-9);
  for (int k = 0; k < 1000; ++k) reserve.observe(10, kSpan, kBound);
  EXPECT_EQ(reserve.ns(kBound, kAlpha), 0.0);
  reserve.observe(1400, kSpan, kBound);  // there is no debt
  EXPECT_NEAR(reserve.ns(kBound, kAlpha), 0.05 * 0.995 * kBound, 1e-9);
}

TEST(OutageReserve, AHundredthOfTheBoundIsNoOutage) {
  OutageReserve reserve;
  for (int k = 0; k < 100; ++k) reserve.observe(1010, 10, kBound);
  EXPECT_EQ(reserve.ns(kBound, kAlpha), 0.0);
}

TEST(OutageReserve, IsHalfTheBoundAtMost) {
  OutageReserve reserve;
  for (int k = 0; k < 1000; ++k) reserve.observe(1e18, kSpan, kBound);
  EXPECT_EQ(reserve.ns(kBound, kAlpha), 500);
  EXPECT_EQ(reserve.ns(kBound, 200), 200);  // four fixed costs have to fit
  EXPECT_EQ(reserve.ns(kBound, 250), 0);
  EXPECT_EQ(reserve.ns(kBound, 1e6), 0);
}

// One late package in a thousand leaves no reserve behind, one in ten does.
TEST(OutageReserve, RareOutagesCostNothing) {
  OutageReserve rare;
  OutageReserve frequent;
  for (int k = 0; k < 5000; ++k) {
    rare.observe(k % 1000 == 0 ? 5000 : 900, kSpan, kBound);
    frequent.observe(k % 10 == 0 ? 5000 : 900, kSpan, kBound);
  }
  EXPECT_EQ(rare.ns(kBound, kAlpha), 0.0);
  EXPECT_GT(frequent.ns(kBound, kAlpha), 490);
}

}  // namespace
}  // namespace asap::outage_reserve_test
