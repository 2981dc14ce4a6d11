#include "asap/telemetry/package_totals.hpp"

#include <gtest/gtest.h>

namespace asap::package_totals_test {
namespace {

TEST(PackageTotals, OfNothing) {
  const PackageTotals totals;
  EXPECT_EQ(totals.count, 0u);
  EXPECT_EQ(totals.gamma_min, 1.0);
}

TEST(PackageTotals, AddUp) {
  PackageTotals totals;
  totals.add(10, 10, 500);
  totals.add(40, 10, 300);
  totals.add(30, 20, 200);
  const PackageTotals copy = totals;
  EXPECT_EQ(copy.count, 3u);
  EXPECT_EQ(copy.thinned, 80u);
  EXPECT_EQ(copy.size, 40u);
  EXPECT_EQ(copy.size_max, 20u);
  EXPECT_EQ(copy.processing_ns, 1000);
  EXPECT_EQ(copy.gamma_min, 0.25);
}

}  // namespace
}  // namespace asap::package_totals_test
