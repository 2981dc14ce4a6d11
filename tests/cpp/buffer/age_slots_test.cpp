#include "buffer/age_slots.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <thread>
#include <vector>

#include "asap/buffer/event_buffer.hpp"
#include "asap/core/random.hpp"
#include "asap/core/time.hpp"
#include "support/errors.hpp"
#include "support/streams.hpp"

namespace asap::age_slots_test {
namespace {

using test::at_times;
using test::evenly_spaced;
using test::Events;

constexpr std::int64_t kMicrosecond = 1000;
constexpr std::int64_t kMillisecond = 1'000'000;

std::int64_t to_ns(std::int64_t stamp_us) { return stamp_us * kMicrosecond; }

std::int64_t floor_of(std::int64_t time_ns, std::int64_t width_ns) {
  const std::int64_t rest = time_ns % width_ns;
  return time_ns - rest - (rest < 0 ? width_ns : 0);
}

// Slots beside the events themselves, of which [head, observed) wait.
class Rig {
 public:
  Rig(std::int64_t width_ns, Events events) : width_ns_(width_ns), events_(std::move(events)) {}

  void observe(std::size_t count) {
    slots_.observe(EventSpan(events_).subspan(observed_, count), observed_, to_ns);
    observed_ += count;
  }
  void consume(std::size_t count) { head_ += count; }

  std::size_t waiting() const { return observed_ - head_; }
  std::size_t left() const { return events_.size() - observed_; }
  std::int64_t newest_ns() const { return to_ns(events_[observed_ - 1].t); }

  std::size_t exact(std::int64_t time_ns) const {
    const auto count = std::count_if(events_.begin() + static_cast<std::ptrdiff_t>(head_),
                                     events_.begin() + static_cast<std::ptrdiff_t>(observed_),
                                     [=](const Event& event) { return to_ns(event.t) < time_ns; });
    return static_cast<std::size_t>(count);
  }
  std::size_t about(std::int64_t time_ns, std::int64_t now_ns) const {
    return slots_.before(time_ns, now_ns, head_, waiting());
  }
  std::size_t about(std::int64_t time_ns) const { return about(time_ns, newest_ns()); }
  void about_each(std::int64_t newest_ns, std::int64_t step_ns, std::int64_t now_ns,
                  std::vector<std::size_t>& counts) const {
    slots_.before_each(newest_ns, step_ns, now_ns, head_, waiting(), counts);
  }

  // Waiting events of the slot that holds this time.
  std::size_t beside(std::int64_t time_ns) const {
    const std::int64_t begin_ns = floor_of(time_ns, width_ns_);
    return exact(begin_ns + width_ns_) - exact(begin_ns);
  }

 private:
  std::int64_t width_ns_;
  Events events_;
  AgeSlots slots_{width_ns_};
  std::size_t observed_ = 0;
  std::size_t head_ = 0;
};

TEST(AgeSlots, InterpolateInsideASlot) {
  Rig rig(kMillisecond, evenly_spaced(5000, 1));
  rig.observe(5000);
  for (const std::int64_t us : {0, 1, 500, 999, 1000, 1001, 2500, 3999, 4000}) {
    EXPECT_EQ(rig.about(to_ns(us)), static_cast<std::size_t>(us)) << us;
  }
}

TEST(AgeSlots, TheNewestSlotEndsNow) {
  Rig rig(kMillisecond, evenly_spaced(5300, 1));
  rig.observe(5300);
  const std::int64_t now_ns = to_ns(5300);
  EXPECT_EQ(rig.about(to_ns(5100), now_ns), 5100u);
  EXPECT_EQ(rig.about(to_ns(5100), to_ns(5200)), 5150u);
  EXPECT_EQ(rig.about(to_ns(5200), to_ns(5200)), 5300u);
  EXPECT_EQ(rig.about(to_ns(5500), to_ns(9999)), 5150u) << "silence since: a slot is all there is";
  EXPECT_EQ(rig.about(to_ns(5999), to_ns(1)), 5300u) << "a clock that is behind does no harm";
}

TEST(AgeSlots, CountOnlyWhatWaits) {
  Rig rig(kMillisecond, evenly_spaced(5000, 1));
  rig.observe(5000);
  rig.consume(2300);
  EXPECT_EQ(rig.about(to_ns(1500)), 0u);
  EXPECT_EQ(rig.about(to_ns(2000)), 0u);
  EXPECT_EQ(rig.about(to_ns(3000)), 700u);
  EXPECT_EQ(rig.about(to_ns(4500)), 2200u);
  EXPECT_EQ(rig.about(to_ns(6000)), 2700u);
}

TEST(AgeSlots, OfNothingIsNothing) {
  const AgeSlots slots(kMillisecond);
  for (const std::int64_t time_ns : {kLongAgo, std::int64_t{0}, kNever}) {
    EXPECT_EQ(slots.before(time_ns, 0, 0, 0), 0u);
  }
}

TEST(AgeSlots, WhatIsOlderThanTheSlotsCountsAsTheirOldest) {
  Events events = evenly_spaced(1000, 1);
  for (const Event& late : evenly_spaced(1000, 1, 500'000)) events.push_back(late);
  Rig rig(kMillisecond, events);
  rig.observe(2000);
  const std::int64_t oldest_slot_ns = (500 - AgeSlots::kSlots + 1) * kMillisecond;
  EXPECT_EQ(rig.about(oldest_slot_ns - 1), 0u);
  EXPECT_EQ(rig.about(oldest_slot_ns), 1000u);
  EXPECT_EQ(rig.about(450 * kMillisecond), 1000u);
  EXPECT_EQ(rig.about(500 * kMillisecond + kMillisecond / 2), 1500u);
}

TEST(AgeSlots, KeepTheFirstIndexOfASlotThatComesInPieces) {
  Rig rig(kMillisecond, at_times({100, 200, 300, 1100, 1200, 1300, 2000}));
  for (int i = 0; i < 7; ++i) rig.observe(1);
  EXPECT_EQ(rig.about(to_ns(1000)), 3u);
  EXPECT_EQ(rig.about(to_ns(2000)), 6u);
}

// Counts at slot boundaries are exact; elsewhere they are wrong by the events of one slot at most;
// never more than what waits, and never fewer for a later time.
void agrees_with_counts(std::uint64_t seed, std::int64_t width_ns, std::int64_t first_us) {
  const CounterRandom random(seed);
  Rig rig(width_ns, test::random_stream(seed, 3000, first_us));
  std::uint64_t draws = 0;
  const auto draw = [&](std::uint64_t limit) { return random(draws++) % limit; };
  while (rig.left() > 0) {
    rig.observe(std::min<std::size_t>(1 + draw(draw(8) == 0 ? 700 : 20), rig.left()));
    rig.consume(draw(4) == 0 ? draw(rig.waiting() + 1) : draw(rig.waiting() / 4 + 1));
    const std::int64_t newest_ns = rig.newest_ns();
    const std::int64_t now_ns = newest_ns + static_cast<std::int64_t>(draw(2'000'000));
    const std::int64_t oldest_slot_ns =
        floor_of(newest_ns, width_ns) - (AgeSlots::kSlots - 1) * width_ns;
    std::vector<std::int64_t> times_ns{oldest_slot_ns - 1, newest_ns, now_ns, kLongAgo, kNever};
    for (int i = 0; i < 30; ++i) {
      times_ns.push_back(oldest_slot_ns + static_cast<std::int64_t>(draw(static_cast<std::uint64_t>(
                                              (AgeSlots::kSlots + 2) * width_ns))));
      times_ns.push_back(floor_of(times_ns.back(), width_ns));
    }
    std::sort(times_ns.begin(), times_ns.end());
    std::size_t before = 0;
    for (const std::int64_t time_ns : times_ns) {
      const std::size_t about = rig.about(time_ns, now_ns);
      ASSERT_LE(about, rig.waiting());
      ASSERT_GE(about, before) << "it decreases";
      before = about;
      if (time_ns < oldest_slot_ns || time_ns == kNever) continue;
      const std::size_t exact = rig.exact(time_ns);
      const std::size_t error = std::max(about, exact) - std::min(about, exact);
      ASSERT_LE(error, rig.beside(time_ns)) << "at " << time_ns << ", newest " << newest_ns;
      if (floor_of(time_ns, width_ns) == time_ns) {
        ASSERT_EQ(about, exact) << "at " << time_ns;
      }
    }
    std::vector<std::size_t> counts(32);
    const auto step_ns = static_cast<std::int64_t>(draw(static_cast<std::uint64_t>(6 * width_ns)));
    rig.about_each(now_ns, step_ns, now_ns, counts);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const std::int64_t time_ns = now_ns - static_cast<std::int64_t>(i) * step_ns;
      ASSERT_EQ(counts[i], rig.about(time_ns, now_ns)) << "at " << time_ns;
    }
  }
}

TEST(AgeSlots, AgreeWithCounts) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    for (const std::int64_t width_ns : {1'000, 15'625, 156'250, 2'000'003}) {
      for (const std::int64_t first_us : {0, -70'000, 1'000'000'007}) {
        SCOPED_TRACE(testing::Message()
                     << "seed " << seed << ", " << width_ns << " ns from " << first_us);
        agrees_with_counts(seed, width_ns, first_us);
        if (HasFailure()) return;
      }
    }
  }
}

TEST(AgeSlots, BearTheEndsOfTime) {
  constexpr std::int64_t kEnd_us = 9'200'000'000'000'000;
  Rig rig(kMillisecond, at_times({-kEnd_us, -kEnd_us, 0, kEnd_us}));
  rig.observe(2);
  EXPECT_EQ(rig.about(0), 2u);
  rig.observe(1);
  EXPECT_EQ(rig.about(0), 2u);
  rig.observe(1);
  EXPECT_EQ(rig.about(to_ns(kEnd_us)), 3u);
  EXPECT_EQ(rig.about(kLongAgo), 0u);
  EXPECT_EQ(rig.about(kNever), 4u);
}

// A producer that is far ahead, with silences longer than all slots.
TEST(AgeSlots, TwoThreadsNeverSeeMoreThanWhatWaits) {
  constexpr std::size_t kEvents = 200'000;
  constexpr std::int64_t kWidth_ns = 5'000;
  const Events events = test::random_stream(5, kEvents);
  EventBuffer buffer(1024);
  AgeSlots slots(kWidth_ns);
  std::atomic<std::int64_t> newest_us{0};
  std::thread producer([&] {
    for (std::size_t at = 0; at < kEvents;) {
      const std::uint64_t first = buffer.tail();
      const EventSpan chunk =
          EventSpan(events).subspan(at, std::min<std::size_t>(50, kEvents - at));
      const std::size_t taken = buffer.push(chunk);
      slots.observe(chunk.first(taken), first, to_ns);
      if (taken > 0) newest_us.store(chunk[taken - 1].t, std::memory_order_relaxed);
      at += chunk.size();
    }
    buffer.close();
  });
  const CounterRandom random(6);
  std::uint64_t asked = 0;
  for (bool ended = false; !ended;) {
    ended = buffer.closed();
    const std::size_t count = buffer.peek().size();
    const std::int64_t now_ns = to_ns(newest_us.load(std::memory_order_relaxed));
    for (int i = 0; i < 20; ++i) {
      const std::int64_t age_ns = static_cast<std::int64_t>(random(asked++) % 2'000'000) - 500'000;
      ASSERT_LE(slots.before(now_ns - age_ns, now_ns, buffer.head(), count), count);
    }
    buffer.consume(std::min<std::size_t>(count, random(asked++) % 200));
  }
  producer.join();
  EXPECT_GT(asked, 0u);
}

TEST(AgeSlots, RefuseAWidthOfNothing) {
  EXPECT_EQ(test::error_of([] { AgeSlots slots(0); }), "width_ns = 0: must be at least 1 ns");
}

}  // namespace
}  // namespace asap::age_slots_test
