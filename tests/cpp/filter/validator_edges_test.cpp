// The check of a block treats all fields at once. Here each field is at its edges while the others
// are at theirs, at several places of a block: the block passes in place exactly if it is good.
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "asap/filter/validator.hpp"

namespace asap::validator_edges_test {
namespace {

using Events = std::vector<Event>;

constexpr std::int64_t kNow = 1000;
constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();

bool passes_in_place(Validator& validator, const Events& events) {
  std::size_t in_place = 0;
  validator.check(events, [&](EventSpan run) {
    if (run.data() == events.data()) in_place = run.size();
  });
  return in_place == events.size();
}

Events edges() {
  Events events;
  for (const int x : {0, 345, 346, 65535}) {
    for (const int y : {0, 259, 260, 65535}) {
      for (const int p : {0, 1, 2, -1, -32768}) {
        for (const std::int64_t t : {kNow, kNow - 1, kNow + 1, kMin, kMin + kNow, kMin + kNow + 1,
                                     -Validator::kMaxRawStamp_us, kMax}) {
          events.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                            static_cast<std::int16_t>(p), t});
        }
      }
    }
  }
  return events;
}

bool is_good(const Event& event) {
  return event.x <= 345 && event.y <= 259 && (event.p == 0 || event.p == 1) &&
         (event.t == kNow || event.t == kNow + 1);
}

TEST(ValidatorEdges, PassesInPlaceExactlyWhatIsGood) {
  constexpr std::size_t kBlock = 7;
  for (const Event& edge : edges()) {
    for (std::size_t place = 0; place < kBlock; ++place) {
      Events block(kBlock, {345, 259, 1, kNow});
      block[place] = edge;
      for (std::size_t i = place; i < kBlock && edge.t == kNow + 1; ++i) block[i].t = edge.t;
      Validator validator({.width = 346, .height = 260});
      ASSERT_TRUE(passes_in_place(validator, {{0, 0, 0, kNow}}));
      EXPECT_EQ(passes_in_place(validator, block), is_good(edge))
          << "event " << place << ": " << edge.x << " " << edge.y << " " << edge.p << " " << edge.t;
    }
  }
}

TEST(ValidatorEdges, ASilenceOfAnyLengthPassesInPlace) {
  constexpr std::int64_t kMinute_us = 60'000'000;
  for (const std::int64_t start : {0LL, 1LL << 31, 1LL << 32, 1'700'000'000'000'000LL}) {
    for (const std::int64_t silence : {kMinute_us / 60, 36 * kMinute_us, std::int64_t{1} << 32,
                                       72 * kMinute_us, 180 * kMinute_us, 43'200 * kMinute_us}) {
      Validator validator({.width = 346, .height = 260});
      const std::int64_t after = start + silence;
      EXPECT_TRUE(passes_in_place(validator, {{1, 2, 0, start}, {3, 4, 1, after}}));
      EXPECT_TRUE(passes_in_place(validator, {{1, 2, 0, after + silence}}));
    }
  }
}

TEST(ValidatorEdges, NoSequenceOfStampsLeadsBackUnseen) {
  for (const std::int64_t far : {kMin, kMin + kNow, kMax, kMax - kNow, kMax / 2, kMin / 2}) {
    const std::int64_t limit = Validator::kMaxRawStamp_us;
    for (const std::int64_t last : {kNow, kNow + 1, kNow - 1, -limit, limit, limit + 1}) {
      Validator validator;
      ASSERT_TRUE(passes_in_place(validator, {{0, 0, 0, kNow}}));
      EXPECT_FALSE(passes_in_place(validator, {{0, 0, 0, far}, {0, 0, 0, last}})) << far;
      const bool goes_on = last >= kNow && last <= limit;
      EXPECT_EQ(passes_in_place(validator, {{0, 0, 0, last}}), goes_on) << last;
    }
  }
}

}  // namespace
}  // namespace asap::validator_edges_test
