#include "asap/telemetry/run_log.hpp"

#include <gtest/gtest.h>

#include <string>

#include "asap/core/result.hpp"
#include "support/allocation_counter.hpp"

namespace asap::run_log_test {
namespace {

// ---- RunLog ---------------------------------------------------------------------------------

PackageRecord record(std::int64_t start_ns) {
  return {.start_ns = start_ns,
          .processing_ns = 150'000,
          .oldest_ns = 100'000,
          .t_first = 1'000'100,
          .t_last = 1'000'300,
          .offered = 100,
          .filtered = 20,
          .size = 20,
          .stale = 3,
          .overflow = 5,
          .rate_events = 400,
          .rate_ns = 1'000'000};
}

TEST(RunLog, KeepsItsRowsAcrossBlocks) {
  constexpr std::size_t kRows = 3 * RunLog::kBlockRows + 1;
  RunLog log;
  EXPECT_EQ(log.size(), 0u);
  for (std::size_t i = 0; i < kRows; ++i) {
    log.make_room();
    log.make_room();  // once more does nothing
    PackageRecord one = record(static_cast<std::int64_t>(1000 * i + 500));
    one.overflow = 2 * i;
    log.append(one);
    ASSERT_EQ(log.size(), i + 1);
  }
  for (std::size_t i = 0; i < kRows; ++i) {
    ASSERT_EQ(log[i].index, static_cast<std::int64_t>(i));
    ASSERT_EQ(log[i].start_us, static_cast<double>(i) + 0.5);
    ASSERT_EQ(log[i].overflow, static_cast<std::int64_t>(2 * i));
  }
}

TEST(RunLog, MakesRowsOfRecords) {
  RunLog log;
  log.set_axis(TimeAxis(1'000'100, 1.0));  // run time 0 is 1 s
  log.append(record(320'000));
  const PackageRow row = log[0];
  EXPECT_EQ(row.start_us, 1'000'320.0);
  EXPECT_EQ(row.processing_us, 150.0);
  EXPECT_EQ(row.t_first, 1'000'100);
  EXPECT_EQ(row.t_last, 1'000'300);
  EXPECT_EQ(row.offered, 100);
  EXPECT_EQ(row.size, 20);
  EXPECT_EQ(row.gamma, 0.25) << "of what passed the filter in front";
  EXPECT_EQ(row.event_rate, 400e3);
  EXPECT_EQ(row.rate, 20 / 200e-6);
  EXPECT_EQ(row.margin_us, 150.0 - 200.0);
  EXPECT_EQ(row.latency_max_us, 320.0 + 150.0 - 100.0);
  EXPECT_EQ(row.stale, 3);
  EXPECT_EQ(row.overflow, 5);
}

TEST(RunLog, KeepsDurationsInWallTimeAtAnySpeed) {
  RunLog log;
  log.set_axis(TimeAxis(1'000'100, 2.0));
  log.append(record(320'000));
  EXPECT_EQ(log[0].start_us, 1'000'640.0) << "on the axis of the recording";
  EXPECT_EQ(log[0].margin_us, 150.0 - 100.0);
  EXPECT_EQ(log[0].rate, 20 / 100e-6);
}

TEST(RunLog, ABoundedOneKeepsTheNewestRowsAndExactTotals) {
  constexpr std::size_t kRows = RunLog::kBlockRows + 10;
  RunLog log(RunLog::kBlockRows);
  for (std::size_t i = 0; i < kRows; ++i) {
    log.make_room();
    PackageRecord one = record(static_cast<std::int64_t>(1000 * i));
    one.size = i == 3 ? 5 : 20;
    log.append(one);
  }
  EXPECT_EQ(log.size(), kRows);
  EXPECT_EQ(log.first(), 10u);
  EXPECT_EQ(log[10].start_us, 10.0);
  EXPECT_EQ(log[kRows - 1].start_us, static_cast<double>(kRows - 1));
  EXPECT_EQ(log.totals().count, kRows);
  EXPECT_EQ(log.totals().size, 20 * kRows - 15);
  EXPECT_EQ(log.totals().gamma_min, 5.0 / 80.0) << "of a row that has gone";
}

TEST(RunLog, ABoundThatMemoryCannotGiveIsRefusedByName) {
  try {
    RunLog log(RunLog::kAllRows - 1);
    FAIL();
  } catch (const NoMemory& error) {
    EXPECT_EQ(std::string(error.what()).rfind("log_rows = ", 0), 0u) << error.what();
  }
}

TEST(RunLog, TakesWhatItSays) {
  for (const std::size_t rows : {0U, 1U, 100U, 5000U}) {
    const std::size_t before = test::allocated_bytes();
    RunLog log(rows);
    log.prefault();
    EXPECT_EQ(test::allocated_bytes() - before, RunLog::memory_bytes(rows));
  }
}

TEST(RunLog, ASpanOfZeroCountsAsOneMicrosecond) {
  RunLog log;
  PackageRecord one = record(0);
  one.t_last = one.t_first;
  log.append(one);
  EXPECT_EQ(log[0].rate, 20e6);
}

}  // namespace
}  // namespace asap::run_log_test
