#include "packager/thinner.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "support/streams.hpp"

namespace asap::thinner_test {
namespace {

using test::evenly_spaced;
using test::Events;
using test::number_of;
using test::numbers_of;

constexpr std::size_t kCapacity = 1024;

// Of n events those whose number is a multiple of it pass.
FrontFilter every(std::uint64_t nth) {
  return [nth](EventSpan events, Event* out) {
    std::size_t passed = 0;
    for (const Event& event : events) {
      if (number_of(event) % nth == 0) out[passed++] = event;
    }
    return passed;
  };
}

// A ring with waiting events from index `first` on, and a thinner over it.
struct Rig {
  explicit Rig(FrontFilter before = {}, std::uint64_t first = 0, std::uint64_t seed = 7,
               std::size_t max_copied = kCapacity)
      : buffer(kCapacity, first), thinner(times, kCapacity, seed, std::move(before), max_copied) {}

  void push(EventSpan events) { buffer.push(events); }
  void begin() { thinner.begin(buffer.peek(), buffer.head()); }

  EventBuffer buffer;
  AgeSlots ages{1000};
  EventTimes times{ages};
  Thinner thinner;
};

std::vector<std::uint64_t> multiples(std::uint64_t of, std::uint64_t below) {
  std::vector<std::uint64_t> numbers;
  for (std::uint64_t number = 0; number < below; number += of) numbers.push_back(number);
  return numbers;
}

TEST(Thinner, HandsOutASliceOfTheRingWhereAllIsKept) {
  Rig rig;
  rig.push(evenly_spaced(100, 10));
  rig.begin();
  const Event* const slots = rig.buffer.peek().first.data();
  EXPECT_EQ(rig.thinner.decide(0, 40, {}).data(), slots);
  EXPECT_EQ(rig.thinner.decide(40, 100, {}).data(), slots + 40);
  EXPECT_EQ(numbers_of(rig.thinner.events()), multiples(1, 100));
  EXPECT_EQ(rig.thinner.filtered(), 0u);
}

TEST(Thinner, CopiesWhereTheRingWraps) {
  Rig rig({}, kCapacity - 30);
  rig.push(evenly_spaced(100, 10));
  rig.begin();
  EXPECT_EQ(numbers_of(rig.thinner.decide(0, 20, {})), multiples(1, 20));  // still a slice
  rig.thinner.decide(20, 100, {});
  EXPECT_EQ(numbers_of(rig.thinner.events()), multiples(1, 100)) << "with what was a slice";
}

TEST(Thinner, CutsChangeNothing) {
  Rig whole({}, kCapacity - 333);
  Rig parts({}, kCapacity - 333);
  for (Rig* rig : {&whole, &parts}) {
    rig->push(evenly_spaced(1000, 10));
    rig->begin();
  }
  whole.thinner.decide(0, 1000, {.keep = 0.3});
  for (const auto& [begin, end] : {std::pair{0, 1}, {1, 332}, {332, 334}, {334, 1000}}) {
    parts.thinner.decide(static_cast<std::size_t>(begin), static_cast<std::size_t>(end),
                         {.keep = 0.3});
  }
  EXPECT_EQ(numbers_of(parts.thinner.events()), numbers_of(whole.thinner.events()));
  EXPECT_NEAR(static_cast<double>(whole.thinner.events().size()), 300, 60);
}

TEST(Thinner, ExactlyKeepsTheNumber) {
  for (const double keep : {0.0, 0.001, 0.1, 0.5, 0.999}) {
    Rig rig;
    rig.push(evenly_spaced(64, 10));
    rig.begin();
    const std::size_t wanted = static_cast<std::size_t>(keep * 64 + 1e-6);
    EXPECT_EQ(rig.thinner.decide(0, 64, {.keep = keep, .exactly = true}).size(), wanted);
  }
}

// ---- at most 100 copied events

Rig bounded(std::uint64_t first = 0, FrontFilter before = {}) {
  return Rig(std::move(before), first, 7, 100);
}

TEST(ThinnerBounded, ASliceIsNotACopy) {
  Rig rig = bounded();
  rig.push(evenly_spaced(500, 10));
  rig.begin();
  EXPECT_EQ(rig.thinner.decide(0, 300, {}).size(), 300u);
  EXPECT_EQ(rig.thinner.decide(300, 500, {}).size(), 200u);
  EXPECT_EQ(rig.thinner.decided(), 500u);
}

TEST(ThinnerBounded, ASliceThatCannotBeCopiedEndsWithTheRing) {
  Rig rig = bounded(kCapacity - 300);
  rig.push(evenly_spaced(500, 10));
  rig.begin();
  const Event* const slots = rig.buffer.peek().first.data();
  rig.thinner.decide(0, 280, {});
  rig.thinner.decide(280, 320, {});
  EXPECT_EQ(rig.thinner.events().data(), slots);
  EXPECT_EQ(numbers_of(rig.thinner.events()), multiples(1, 300));
  EXPECT_EQ(rig.thinner.decided(), 300u);
}

TEST(ThinnerBounded, WhatFitsIsCopiedAcrossTheEnd) {
  Rig rig = bounded(kCapacity - 50);
  rig.push(evenly_spaced(500, 10));
  rig.begin();
  EXPECT_EQ(rig.thinner.decide(0, 100, {}).size(), 100u);
  EXPECT_EQ(rig.thinner.decided(), 100u);
}

TEST(ThinnerBounded, EndsWhereItIsFullAndTheRestChangesNothing) {
  Rig whole;
  Rig rig = bounded();
  for (Rig* each : {&whole, &rig}) each->push(evenly_spaced(500, 10));
  whole.begin();
  whole.thinner.decide(0, 500, {.keep = 0.5});
  std::vector<std::uint64_t> kept;
  std::size_t packages = 0;
  for (std::size_t left = 500; left > 0; left -= rig.thinner.decided(), ++packages) {
    rig.begin();
    rig.thinner.decide(0, left, {.keep = 0.5});
    const std::vector<std::uint64_t> numbers = numbers_of(rig.thinner.events());
    ASSERT_LE(numbers.size(), 100u);
    ASSERT_TRUE(numbers.size() == 100 || rig.thinner.decided() == left);
    kept.insert(kept.end(), numbers.begin(), numbers.end());
    rig.buffer.consume(rig.thinner.decided());
  }
  EXPECT_EQ(kept, numbers_of(whole.thinner.events()));
  EXPECT_EQ(packages, 3u);
}

TEST(ThinnerBounded, ASliceThatCouldNotBeCopiedStays) {
  Rig rig = bounded();
  rig.push(evenly_spaced(500, 10));
  rig.begin();
  rig.thinner.decide(0, 40, {});
  rig.thinner.decide(40, 100, {.keep = 0.5});
  EXPECT_EQ(rig.thinner.decided(), 100u) << "a copy";
  rig.begin();
  EXPECT_EQ(rig.thinner.decided(), 0u);
  rig.thinner.decide(0, 80, {});
  EXPECT_TRUE(rig.thinner.decide(80, 160, {.keep = 0.5}).empty());
  EXPECT_EQ(rig.thinner.decided(), 80u);
  EXPECT_EQ(rig.thinner.events().size(), 80u);
}

TEST(ThinnerBounded, AFilterInFrontGetsNoMoreThanItCanPass) {
  Rig rig = bounded(0, every(4));
  rig.push(evenly_spaced(500, 10));
  rig.begin();
  rig.thinner.decide(0, 60, {});
  EXPECT_EQ(rig.thinner.decided(), 60u);
  rig.thinner.decide(60, 500, {});
  EXPECT_EQ(rig.thinner.decided(), 145u);  // 85 places are left
  EXPECT_EQ(numbers_of(rig.thinner.events()), multiples(4, 145));
  EXPECT_EQ(rig.thinner.filtered(), 145u - 37);
}

TEST(ThinnerBounded, NotesWhenTheKeptOnesCame) {
  EventBuffer buffer(kCapacity);
  ArrivalTimes arrivals(1);
  EventTimes times(arrivals);
  Thinner thinner(times, kCapacity, 7, {}, 100);
  for (int push = 0; push < 20; ++push) {
    arrivals.note(buffer.tail(), 1000 * push);
    buffer.push(evenly_spaced(25, 1));
  }
  thinner.begin(buffer.peek(), 0);
  thinner.decide(0, 500, {.keep = 0.5});
  ASSERT_EQ(thinner.events().size(), 100u);
  EXPECT_EQ(thinner.arrivals().runs().back().end, 100u);
  EXPECT_EQ(thinner.arrivals().runs().back().time_ns,
            static_cast<std::int64_t>((thinner.decided() - 1) / 25) * 1000);
}

TEST(ThinnerBehindAFilter, KeepsAllThatPass) {
  Rig rig(every(4), kCapacity - 30);
  rig.push(evenly_spaced(100, 10));
  rig.begin();
  rig.thinner.decide(0, 37, {});
  rig.thinner.decide(37, 100, {});
  EXPECT_EQ(numbers_of(rig.thinner.events()), multiples(4, 100));
  EXPECT_EQ(rig.thinner.filtered(), 75u);
}

TEST(ThinnerBehindAFilter, TheShareIsOfTheRawEvents) {
  Rig rig(every(4));
  rig.push(evenly_spaced(1000, 10));
  rig.begin();
  EXPECT_EQ(rig.thinner.decide(0, 400, {.keep = 0.5}).size(), 100u) << "no more than pass";
  EXPECT_EQ(rig.thinner.decide(400, 800, {.keep = 0.1, .exactly = true}).size(), 40u);
  const std::size_t by_chance = rig.thinner.decide(800, 1000, {.keep = 0.125}).size();
  EXPECT_NEAR(static_cast<double>(by_chance), 25, 15);  // half of the 50 that pass
  EXPECT_EQ(rig.thinner.filtered(), 750u);
}

TEST(ThinnerBehindAFilter, NumbersOfTheGammaFilterAreOfWhatPassed) {
  Rig behind(every(4));
  Rig alone;
  Events passing;
  for (const Event& event : evenly_spaced(1000, 10)) {
    if (number_of(event) % 4 == 0) passing.push_back(event);
  }
  behind.push(evenly_spaced(1000, 10));
  alone.push(passing);
  behind.begin();
  alone.begin();
  behind.thinner.decide(0, 1000, {.keep = 0.1});
  alone.thinner.decide(0, 250, {.keep = 0.4});
  EXPECT_EQ(numbers_of(behind.thinner.events()), numbers_of(alone.thinner.events()));
}

TEST(ThinnerBehindAFilter, NotesWhenTheKeptOnesCame) {
  EventBuffer buffer(kCapacity);
  ArrivalTimes arrivals(1);
  const EventTimes times(arrivals);
  Thinner thinner(times, kCapacity, 7, every(10));
  for (int push = 0; push < 5; ++push) {
    arrivals.note(buffer.tail(), 1000 * push);
    Events events = evenly_spaced(25, 10);
    for (Event& event : events) event.x = static_cast<std::uint16_t>(event.x + 25 * push);
    buffer.push(events);
  }
  thinner.begin(buffer.peek(), buffer.head());
  thinner.decide(0, 125, {});
  const auto& runs = thinner.arrivals().runs();
  std::size_t at = 0;
  for (const KeptTimes::Run& run : runs) {
    for (; at < run.end; ++at) {
      EXPECT_EQ(run.time_ns,
                static_cast<std::int64_t>(number_of(thinner.events()[at]) / 25) * 1000);
    }
  }
  EXPECT_EQ(at, 13u);
}

TEST(ThinnerBehindAFilter, AFilterThatSaysMoreThanThereIsIsNotBelieved) {
  Rig rig([](EventSpan events, Event* out) {
    std::copy(events.begin(), events.end(), out);
    return events.size() + 5;
  });
  rig.push(evenly_spaced(10, 10));
  rig.begin();
  EXPECT_EQ(rig.thinner.decide(0, 10, {}).size(), 10u);
  EXPECT_EQ(rig.thinner.filtered(), 0u);
}

TEST(ThinnerBehindAFilter, ItsExceptionPasses) {
  Rig rig([](EventSpan, Event*) -> std::size_t { throw std::runtime_error("mine"); });
  rig.push(evenly_spaced(10, 10));
  rig.begin();
  EXPECT_THROW(rig.thinner.decide(0, 10, {}), std::runtime_error);
  EXPECT_EQ(rig.buffer.size(), 10u);
}

}  // namespace
}  // namespace asap::thinner_test
