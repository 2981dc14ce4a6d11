#include "filter/stray_stamps.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace asap::stray_stamps_test {
namespace {

using Indices = std::vector<std::size_t>;

constexpr std::int64_t kSecond_us = 1'000'000;

std::vector<Event> at_times(const std::vector<std::int64_t>& times) {
  std::vector<Event> events;
  for (const std::int64_t t : times) events.push_back({1, 2, 1, t});
  return events;
}

Indices stray(const std::vector<std::int64_t>& times, ValidatorConfig config = {}) {
  return stray_stamps(Validator(config), at_times(times));
}

TEST(StrayStamps, AheadOfManyIsStray) {
  EXPECT_EQ(stray({10, 20, 900'000, 30, 40, 50}), Indices{2});
  EXPECT_EQ(stray({10, 20, 9 * kSecond_us, 30, 40}), Indices{2});
  EXPECT_EQ(stray({10, 900, 901, 20, 30, 40}), (Indices{1, 2}));
  EXPECT_EQ(stray({900'000, 10, 20, 30}), Indices{0}) << "the first";
  EXPECT_EQ(stray({10, 20, 9 * kSecond_us, 30}), Indices{2}) << "the last but one";
}

TEST(StrayStamps, FarBehindIsStrayAndNoResetOfTheClock) {
  EXPECT_EQ(stray({9 * kSecond_us, 9 * kSecond_us + 1, 20, 9 * kSecond_us + 2}), Indices{2});
  EXPECT_EQ(stray({9 * kSecond_us, 20, 30, 9 * kSecond_us + 2}), (Indices{1, 2}));
}

TEST(StrayStamps, ALateEventIsLeftToTheValidator) {
  EXPECT_EQ(stray({10, 20, 15, 30, 40}), Indices{});
  EXPECT_EQ(stray({10, 20, 30, 5, 40}), Indices{});
  EXPECT_EQ(stray({10, 30, 20, 40}), Indices{}) << "as many are late as are ahead";
}

TEST(StrayStamps, AResetOfTheClockIsNone) {
  EXPECT_EQ(stray({9 * kSecond_us, 9 * kSecond_us + 1, 0, 1, 2, 3}), Indices{});
  EXPECT_EQ(stray({5 * kSecond_us, 0, 1, 2}), Indices{}) << "stamps of the run before";
  std::vector<std::int64_t> jump{0};  // forward, and back to where it was: too many to be stray
  for (std::size_t i = 0; i <= kMaxStray; ++i) jump.push_back(9 * kSecond_us);
  for (std::int64_t i = 1; i < 3000; ++i) jump.push_back(i);
  EXPECT_EQ(stray(jump), Indices{});
}

TEST(StrayStamps, WhatTheValidatorRefusesForAnotherReasonIsNotLookedAt) {
  auto events = at_times({10, 20, 900, 30, 40});
  events[2].x = 346;
  EXPECT_EQ(stray_stamps(Validator({.width = 346}), events), Indices{});
  EXPECT_EQ(stray_stamps(Validator({.width = 347}), events), Indices{2});
  EXPECT_EQ(stray({10, INT64_MAX, 20, 30}), Indices{});
}

TEST(StrayStamps, DisorderWithinTheToleranceIsNone) {
  EXPECT_EQ(stray({10, 50, 20, 30, 40}, {.reorder_tolerance = std::chrono::microseconds(30)}),
            Indices{});
  EXPECT_EQ(stray({10, 50, 20, 30, 40}, {.reorder_tolerance = std::chrono::microseconds(29)}),
            Indices{1});
}

TEST(CheckRecorded, DropsTheStrayOneAndNotThoseAfterIt) {
  Validator validator;
  const auto first = at_times({10, 20, 30});
  EXPECT_TRUE(check_recorded(validator, first).untouched);
  const Checked checked = check_recorded(validator, at_times({5 * kSecond_us, 40, 50, 25, 60}));
  EXPECT_EQ(checked.stray, 1U);
  EXPECT_EQ(checked.kept, at_times({40, 50, 60}));
  EXPECT_EQ(validator.rejected().nonmonotonic, 1U) << "25 is late";
  EXPECT_EQ(validator.received(), 7U);
  EXPECT_EQ(validator.clock_resets(), 0U);
}

TEST(CheckRecorded, KeepsAllOthersWhereTheyAreGood) {
  Validator validator;
  const Checked checked = check_recorded(validator, at_times({10, 500, 20, 30}));
  EXPECT_FALSE(checked.untouched);
  EXPECT_EQ(checked.kept, at_times({10, 20, 30}));
}

}  // namespace
}  // namespace asap::stray_stamps_test
