#include "asap/filter/validator.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/bit_log.hpp"
#include "core/random.hpp"
#include "packager/kept_mask.hpp"

namespace asap::validator_test {
namespace {

using namespace std::chrono_literals;

using Events = std::vector<Event>;
using Times = std::vector<std::int64_t>;

constexpr std::int64_t kSecond_us = 1'000'000;

Events check(Validator& validator, EventSpan events) {
  Events good;
  validator.check(events, [&](EventSpan run) { good.insert(good.end(), run.begin(), run.end()); });
  return good;
}

std::vector<std::int64_t> times(const Events& events) {
  std::vector<std::int64_t> t;
  for (const Event& event : events) t.push_back(event.t);
  return t;
}

Events at_times(const std::vector<std::int64_t>& t) {
  Events events;
  for (const std::int64_t stamp : t) events.push_back({1, 2, 1, stamp});
  return events;
}

Events good_events(std::size_t count) {
  Events events;
  for (std::size_t i = 0; i < count; ++i) {
    events.push_back({static_cast<std::uint16_t>(i % 346), static_cast<std::uint16_t>(i % 260),
                      static_cast<std::int16_t>(i % 2), static_cast<std::int64_t>(i / 3)});
  }
  return events;
}

std::string refusal(Validator& validator, EventSpan events) {
  try {
    check(validator, events);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Validator, PassesGoodEventsInPlaceAsOneRun) {
  const Events events = good_events(100'000);
  Validator validator({.width = 346, .height = 260});
  std::vector<EventSpan> runs;
  validator.check(events, [&](EventSpan run) { runs.push_back(run); });
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].data(), events.data());
  EXPECT_EQ(runs[0].size(), events.size());
  EXPECT_EQ(validator.received(), events.size());
  EXPECT_EQ(validator.rejected(), Rejections{});
  EXPECT_EQ(validator.repaired(), Repairs{});
}

TEST(Validator, OneThatDoubtsResetsWaitsUntilStampsStay) {
  Validator validator;
  validator.doubt_resets();
  const std::int64_t start = 10 * kSecond_us;
  EXPECT_EQ(times(check(validator, at_times({start, 5, 6, start + 1, 7}))),
            (Times{start, start + 1}));
  EXPECT_EQ(validator.clock_resets(), 0u);
  EXPECT_EQ(validator.rejected().nonmonotonic, 3u);
  // Event by event: the last of kStays in a row, the first of which came above.
  for (std::int64_t i = 1; i < std::int64_t{Validator::kStays} - 1; ++i) {
    EXPECT_TRUE(check(validator, at_times({7 + i})).empty());
  }
  EXPECT_EQ(times(check(validator, at_times({100}))), (Times{start + 2}));
  EXPECT_EQ(validator.clock_resets(), 1u);
  // In one call none is lost.
  Times again;
  for (std::int64_t i = 0; i < std::int64_t{Validator::kStays}; ++i)
    again.push_back(i - kSecond_us);
  EXPECT_EQ(check(validator, at_times(again)).size(), Validator::kStays);
  EXPECT_EQ(validator.clock_resets(), 2u);
}

TEST(Validator, AnEpochThatIsToldBeginsWhereverItsFirstStampLies) {
  Validator validator;
  validator.begin_epoch(77);  // nothing to go on with
  EXPECT_EQ(validator.clock_resets(), 0u);
  check(validator, at_times({5'000}));
  for (const std::int64_t first : {4'900, 5'000, 80'000'000}) {
    const std::int64_t last = validator.last_us();
    validator.begin_epoch(first);
    EXPECT_EQ(validator.clock_offset_us(), last + 1 - first);
    EXPECT_EQ(times(check(validator, at_times({first, first + 7, first + 3}))),
              (Times{last + 1, last + 8}));
  }
  EXPECT_EQ(validator.clock_resets(), 3u);
  EXPECT_EQ(validator.rejected(), (Rejections{.nonmonotonic = 3}));
}

TEST(Validator, StampsThatWouldOverflowAreBadRecords) {
  constexpr std::int64_t kLimit = Validator::kMaxRawStamp_us;
  Validator validator;
  const Events good =
      check(validator, at_times({std::numeric_limits<std::int64_t>::min(), -kLimit - 1, -kLimit, 0,
                                 kLimit + 1, kLimit, std::numeric_limits<std::int64_t>::max()}));
  EXPECT_EQ(times(good), (std::vector<std::int64_t>{-kLimit, 0, kLimit}));
  EXPECT_EQ(validator.rejected(), (Rejections{.bad_record = 4}));
}

TEST(Validator, TimeNeverPassesTheLimitByEpochs) {
  constexpr std::int64_t kLimit = Validator::kMaxStamp_us;
  constexpr std::int64_t kStamp = Validator::kMaxRawStamp_us;
  Validator validator;
  const std::int64_t rest = kLimit - kStamp - 1;
  EXPECT_EQ(times(check(validator, at_times({kStamp, 0, rest + 1, rest}))),
            (Times{kStamp, kStamp + 1, kLimit}));
  EXPECT_EQ(times(check(validator, at_times({0, 1}))), Times{});
  EXPECT_EQ(validator.rejected().bad_record, 3u);
  EXPECT_EQ(validator.clock_resets(), 1u);
}

TEST(Validator, TimeGoesOnAfterADamagedStamp) {
  constexpr std::int64_t kDay_us = 86'400 * kSecond_us;
  for (const std::int64_t damaged :
       {Validator::kMaxStamp_us, Validator::kMaxRawStamp_us, Validator::kMaxRawStamp_us - 1}) {
    Validator validator;
    check(validator, at_times({0, damaged}));
    EXPECT_EQ(check(validator, at_times({1, 2, 3, kDay_us, 365 * kDay_us})).size(), 5u) << damaged;
  }
}

TEST(Validator, RaiseSinksWhatCameBeforeAndNamesTheEvent) {
  Validator validator({.width = 346, .height = 260, .on_bad = OnBad::raise});
  Events events = good_events(1000);
  events[700].y = 260;
  Events good;
  try {
    validator.check(events,
                    [&](EventSpan run) { good.insert(good.end(), run.begin(), run.end()); });
    FAIL() << "nothing was thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("y = 260 (event 700): ")) << error.what();
  }
  EXPECT_EQ(good, Events(events.begin(), events.begin() + 700));
  EXPECT_EQ(validator.received(), 701u);
  EXPECT_EQ(validator.rejected(), (Rejections{.out_of_bounds = 1}));
}

TEST(Validator, RaiseCountsEventsOverAllCalls) {
  Validator validator({.on_bad = OnBad::raise});
  check(validator, at_times({1, 2, 3}));
  EXPECT_NE(refusal(validator, at_times({4, 3})).find("(event 4)"), std::string::npos);
}

TEST(Validator, WhatComesDuringTheWarmUpIsBeforeTheStart) {
  Validator validator({.warmup_discard = 100us});
  EXPECT_EQ(times(check(validator, at_times({50, 149, 150, 149, 151}))), (Times{150, 151}));
  EXPECT_EQ(validator.rejected().before_start, 2U);
  EXPECT_EQ(validator.rejected().nonmonotonic, 1U);
  EXPECT_EQ(validator.received(), 5U);
}

TEST(Validator, TheWarmUpEndsOnce) {
  Validator validator({.warmup_discard = 100us});
  EXPECT_EQ(times(check(validator, at_times({0, 100}))), (Times{100}));
  EXPECT_EQ(times(check(validator, at_times({101, 5 * kSecond_us, 0, 1}))),
            (Times{101, 5 * kSecond_us, 5 * kSecond_us + 1, 5 * kSecond_us + 2}));
  EXPECT_EQ(validator.clock_resets(), 1U);
}

TEST(Validator, TheWarmUpCountsFromTheResetOfTheClock) {
  Validator validator({.warmup_discard = 100us});
  const Events events = at_times({9 * kSecond_us, 9 * kSecond_us + 50, 3, 90, 103});
  EXPECT_EQ(times(check(validator, events)), (Times{103}));
  EXPECT_EQ(validator.rejected().before_start, 4U);
  EXPECT_EQ(validator.clock_resets(), 0U);
}

TEST(Validator, NothingIsRefusedDuringTheWarmUp) {
  Validator validator({.width = 4, .on_bad = OnBad::raise, .warmup_discard = 100us});
  const std::int64_t no_time = std::numeric_limits<std::int64_t>::max();
  const Events rest{{1, 1, 1, 50}, {9, 1, 1, 20}, {1, 1, 7, no_time}, {1, 1, 1, 149}};
  EXPECT_TRUE(check(validator, rest).empty());
  EXPECT_EQ(validator.rejected().before_start, 4U);
  EXPECT_EQ(refusal(validator, Events{{9, 1, 1, 150}}).substr(0, 5), "x = 9");
}

// Streams with every fault in them: the laws hold whatever the policy and however the stream is
// cut.

Events storm(std::uint64_t seed, std::size_t count) {
  const CounterRandom random(seed);
  const unsigned fault_every = 2 + static_cast<unsigned>(random(count) % 400);
  Events events;
  std::int64_t t = 10 * kSecond_us;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t bits = random(i);
    t += static_cast<std::int64_t>(bits % 4);
    Event event{static_cast<std::uint16_t>((bits >> 8) % 346),
                static_cast<std::uint16_t>((bits >> 20) % 260),
                static_cast<std::int16_t>((bits >> 32) % 2), t};
    if ((bits >> 33) % fault_every == 0) {
      switch ((bits >> 50) % 6) {
        case 0:
          event.t -= static_cast<std::int64_t>((bits >> 40) % 50);
          break;
        case 1:
          t = static_cast<std::int64_t>((bits >> 40) % 1000);
          break;
        case 2:
          event.x = static_cast<std::uint16_t>(bits >> 40);
          break;
        case 3:
          event.y = static_cast<std::uint16_t>(bits >> 40);
          break;
        case 4:
          event.p = static_cast<std::int16_t>(bits >> 40);
          break;
        default:
          event.t = static_cast<std::int64_t>(bits);
          break;
      }
    }
    events.push_back(event);
  }
  return events;
}

TEST(Validator, OutputIsOrderedAndTheLedgerExactInAnyStorm) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Events events = storm(seed, 3000);
    const ValidatorConfig config{.width = 346,
                                 .height = 260,
                                 .on_bad = seed % 2 == 0 ? OnBad::drop : OnBad::clamp,
                                 .reorder_tolerance = 20us * (seed % 3)};
    Validator whole(config);
    const Events good = check(whole, events);
    ASSERT_EQ(whole.received(), events.size()) << "seed " << seed;
    ASSERT_EQ(whole.received(), good.size() + whole.rejected().total()) << "seed " << seed;
    for (std::size_t i = 0; i < good.size(); ++i) {
      ASSERT_TRUE(i == 0 || good[i - 1].t <= good[i].t) << "seed " << seed << " event " << i;
      ASSERT_TRUE(good[i].x < 346 && good[i].y < 260 && (good[i].p == 0 || good[i].p == 1));
      ASSERT_TRUE(good[i].t <= Validator::kMaxStamp_us && good[i].t >= -Validator::kMaxStamp_us);
    }

    Validator pieces(config);
    Events joined;
    const CounterRandom cut(seed);
    for (std::size_t at = 0, i = 0; at < events.size(); ++i) {
      const std::size_t size = std::min<std::size_t>(cut(i) % 700, events.size() - at);
      const Events part = check(pieces, EventSpan(events).subspan(at, size));
      joined.insert(joined.end(), part.begin(), part.end());
      at += size;
    }
    ASSERT_EQ(joined, good) << "seed " << seed;
    ASSERT_EQ(pieces.rejected(), whole.rejected()) << "seed " << seed;
    ASSERT_EQ(pieces.repaired(), whole.repaired()) << "seed " << seed;

    KeptMask mask;
    Validator noting(config);
    mask.follow(noting);
    const BitLog& passed = mask.passed();
    Validator single(config);
    check(noting, events);
    ASSERT_EQ(passed.size(), events.size()) << "seed " << seed;
    for (std::size_t i = 0; i < events.size(); ++i) {
      const bool passes = check(single, EventSpan(events).subspan(i, 1)).size() == 1;
      ASSERT_EQ(passed[i], passes) << "seed " << seed << " event " << i;
    }
  }
}

}  // namespace
}  // namespace asap::validator_test
