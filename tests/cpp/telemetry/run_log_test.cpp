#include "asap/telemetry/run_log.hpp"

#include <gtest/gtest.h>

namespace asap {
namespace {

TEST(RunLog, KeepsItsRowsAcrossBlocks) {
  constexpr std::size_t kRows = 3 * RunLog::kBlockRows + 1;
  RunLog log;
  EXPECT_EQ(log.size(), 0u);
  for (std::size_t i = 0; i < kRows; ++i) {
    log.make_room();
    log.make_room();  // once more does nothing
    PackageRow row{};
    row.index = static_cast<std::int64_t>(i);
    row.start_us = static_cast<double>(i) + 0.5;
    row.overflow = static_cast<std::int64_t>(2 * i);
    log.append(row);
    ASSERT_EQ(log.size(), i + 1);
  }
  for (std::size_t i = 0; i < kRows; ++i) {
    ASSERT_EQ(log[i].index, static_cast<std::int64_t>(i));
    ASSERT_EQ(log[i].start_us, static_cast<double>(i) + 0.5);
    ASSERT_EQ(log[i].overflow, static_cast<std::int64_t>(2 * i));
  }
}

TEST(RunLog, RowsStayWhereTheyAre) {
  RunLog log;
  PackageRow row{};
  row.index = 7;
  log.append(row);
  const PackageRow* const first = &log[0];
  for (std::size_t i = 0; i < 2 * RunLog::kBlockRows; ++i) {
    log.make_room();
    log.append(PackageRow{});
  }
  EXPECT_EQ(first, &log[0]);
  EXPECT_EQ(first->index, 7);
}

}  // namespace
}  // namespace asap
