// A simulated run beside the same run of the NaiveSimulator: ledger, rows, gap, slots, working
// time.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>

#include "asap/runner/simulator.hpp"
#include "runner/naive_simulator.hpp"
#include "support/gap.hpp"

namespace asap::test {

inline void expect_same(const PackageRow& row, const PackageRow& expected) {
  ASSERT_EQ(row.index, expected.index);
  ASSERT_DOUBLE_EQ(row.start_us, expected.start_us);
  ASSERT_DOUBLE_EQ(row.processing_us, expected.processing_us);
  ASSERT_EQ(row.t_first, expected.t_first);
  ASSERT_EQ(row.t_last, expected.t_last);
  ASSERT_EQ(row.offered, expected.offered);
  ASSERT_EQ(row.size, expected.size);
  ASSERT_DOUBLE_EQ(row.gamma, expected.gamma);
  ASSERT_DOUBLE_EQ(row.event_rate, expected.event_rate);
  ASSERT_DOUBLE_EQ(row.rate, expected.rate);
  ASSERT_DOUBLE_EQ(row.margin_us, expected.margin_us);
  ASSERT_DOUBLE_EQ(row.latency_max_us, expected.latency_max_us);
  ASSERT_EQ(row.stale, expected.stale);
  ASSERT_EQ(row.overflow, expected.overflow);
}

inline void expect_agreement(const Simulator& simulator, const NaiveSimulator& naive) {
  const RunLog& log = simulator.log();
  for (std::size_t i = 0; i < std::min(log.size(), naive.rows.size()); ++i) {
    SCOPED_TRACE(testing::Message() << "package " << i);
    expect_same(log[i], naive.rows[i]);
    if (testing::Test::HasFailure()) return;
  }
  ASSERT_EQ(log.size(), naive.rows.size());
  ASSERT_EQ(simulator.ledger(), naive.ledger);
  ASSERT_EQ(simulator.stats().gap_us, gap_us(naive.received, naive.delivered));
  ASSERT_EQ(simulator.busy_ns(), naive.busy_ns);
  ASSERT_EQ(simulator.slots().size(), naive.slots.size());
  for (const Slot& slot : simulator.slots()) {
    SCOPED_TRACE(testing::Message() << "slot " << slot.slot);
    ASSERT_TRUE(naive.slots.contains(slot.slot));
    const Slot& expected = naive.slots.at(slot.slot);
    ASSERT_EQ(slot.received, expected.received);
    ASSERT_EQ(slot.delivered, expected.delivered);
    ASSERT_EQ(slot.latency_max_ns, expected.latency_max_ns);
  }
}

}  // namespace asap::test
