#include "asap/formats/encoder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "asap/formats/atis.hpp"
#include "asap/formats/prophesee.hpp"
#include "asap/formats/text.hpp"
#include "core/random.hpp"
#include "support/allocation_counter.hpp"

namespace asap::encoder_test {
namespace {

using Bytes = std::vector<std::byte>;
using Events = std::vector<Event>;

constexpr unsigned kHeight = 720;

constexpr EncoderConfig config(Encoding encoding) {
  return {.encoding = encoding, .width = 1280, .height = kHeight};
}

constexpr Encoding kAll[] = {Encoding::evt3, Encoding::event_stream, Encoding::csv};

Bytes encode(Encoder& encoder, std::span<const Event> events, std::size_t room = 1 << 16) {
  Bytes all, bytes(room);
  while (!events.empty()) {
    const Progress done = encoder.encode(events, bytes);
    EXPECT_GT(done.bytes, 0u);
    if (done.bytes == 0) break;
    all.insert(all.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(done.bytes));
    events = events.subspan(done.events);
  }
  return all;
}

Bytes encode(Encoding encoding, std::span<const Event> events) {
  Encoder encoder(config(encoding));
  return encode(encoder, events);
}

// Many on one stamp, on one row, close together, and now and then seconds apart.
Events some_events(std::size_t count, std::int64_t first = 0) {
  const CounterRandom random(7);
  Events events;
  std::int64_t t = first;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t bits = random(i);
    if (bits % 3 == 0) t += static_cast<std::int64_t>((bits >> 8) % 300);
    if (bits % 1009 == 0) t += static_cast<std::int64_t>((bits >> 8) % 30'000'000);
    events.push_back({.x = static_cast<std::uint16_t>((bits >> 20) % 1280),
                      .y = static_cast<std::uint16_t>((bits >> 34) % (bits % 5 == 0 ? 720 : 3)),
                      .p = static_cast<std::int16_t>((bits >> 50) & 1),
                      .t = t});
  }
  return events;
}

Event event(unsigned x, unsigned y, std::int16_t p, std::int64_t t) {
  return {.x = static_cast<std::uint16_t>(x), .y = static_cast<std::uint16_t>(y), .p = p, .t = t};
}

// By our decoders, which decoder_test and the hashes of recordings hold.
Events read(Encoding encoding, const Bytes& bytes) {
  const auto all = [&](auto decoder) {
    Events events;
    decoder.decode(bytes, events);
    EXPECT_EQ(decoder.bad_records(), 0u);
    return events;
  };
  switch (encoding) {
    case Encoding::evt3:
      return all(Evt3Decoder());
    case Encoding::event_stream:
      return all(EventStreamDecoder({.version = 2, .height = kHeight}));
    case Encoding::csv:
      return all(TextDecoder({.time_exponent = 0}));
  }
  return {};
}

// ---- what comes out -------------------------------------------------------------------------

TEST(Encoder, ReadersGetTheSameEvents) {
  const Events events = some_events(20'000);
  ASSERT_GT(events.back().t, std::int64_t{1} << 25) << "EVT3 wraps";
  for (const Encoding encoding : kAll) {
    EXPECT_EQ(read(encoding, encode(encoding, events)), events) << static_cast<int>(encoding);
  }
}

TEST(Encoder, LongGapsAreBridged) {
  for (const std::int64_t gap : {126LL, 127LL, 128LL, 4095LL, 4096LL, (1LL << 22) - 1, 1LL << 22,
                                 (1LL << 24) + 5, 1LL << 31}) {
    for (const Encoding encoding : kAll) {
      const Events events{event(5, 6, 1, 1000), event(7, 6, 0, 1000 + gap)};
      EXPECT_EQ(read(encoding, encode(encoding, events)), events)
          << static_cast<int>(encoding) << " gap " << gap;
    }
  }
  constexpr std::int64_t kMinute_us = 60'000'000;
  for (const std::int64_t start : {0LL, 1LL << 31, 1LL << 32, 1LL << 36}) {
    for (const int minutes : {36, 72, 180}) {
      const Events events{event(5, 6, 1, start), event(7, 6, 0, start + minutes * kMinute_us)};
      EXPECT_EQ(read(Encoding::evt3, encode(Encoding::evt3, events)), events);
    }
  }
  const Events years{event(5, 6, 1, 0), event(7, 6, 0, 1'633'953'690'975'950)};
  EXPECT_EQ(read(Encoding::csv, encode(Encoding::csv, years)), years);
}

TEST(Encoder, TheLargestPixelsFit) {
  for (const Encoding encoding : kAll) {
    const unsigned largest = encoding == Encoding::evt3 ? 2047 : 65535;
    const Events events{event(largest, 0, 1, 9), event(0, largest, 0, 9)};
    EXPECT_EQ(read(encoding, encode(encoding, events)), events);
  }
}

TEST(Encoder, RoomMakesNoDifference) {
  const Events events = some_events(2'000);
  for (const Encoding encoding : kAll) {
    const Bytes whole = encode(encoding, events);
    for (std::size_t room = Encoder::kMaxPerEvent; room < Encoder::kMaxPerEvent + 20; ++room) {
      Encoder encoder(config(encoding));
      EXPECT_EQ(encode(encoder, events, room), whole) << room;
    }
    Encoder encoder(config(encoding));
    Bytes bytes(Encoder::kMaxPerEvent - 1);
    EXPECT_EQ(encoder.encode(events, bytes), Progress{});
    Bytes joined;
    for (std::size_t at = 0; at < events.size(); at += 7) {
      const std::size_t size = std::min<std::size_t>(7, events.size() - at);
      const Bytes part = encode(encoder, std::span(events).subspan(at, size));
      joined.insert(joined.end(), part.begin(), part.end());
    }
    EXPECT_EQ(joined, whole);
    encoder.reset(0);
    EXPECT_EQ(encode(encoder, events), whole);
  }
}

TEST(Encoder, CountsFromTheTimeOfAReset) {
  const Events events = some_events(2'000);
  for (const Encoding encoding : {Encoding::evt3, Encoding::event_stream}) {
    for (const std::int64_t origin_us : {std::int64_t{1} << 30, -(std::int64_t{1} << 30)}) {
      Events moved = events;
      for (Event& event : moved) event.t += origin_us;
      Encoder encoder(config(encoding));
      encoder.reset(origin_us);
      EXPECT_EQ(encode(encoder, moved), encode(encoding, events)) << origin_us;
    }
  }
}

TEST(Encoder, WhatIsRestatedCanBeReadAlone) {
  Encoder encoder(config(Encoding::evt3));
  const Events first{{1, 5, 1, 3'000'000}, {2, 5, 0, 3'000'001}}, second{{3, 5, 1, 3'000'001}};
  encode(encoder, first);
  encoder.restate();
  EXPECT_EQ(read(Encoding::evt3, encode(encoder, second)), second);
}

TEST(Encoder, HoldsTriggersInEvt3Alone) {
  const Trigger trigger{.t = 20'000'000, .id = 15, .value = 1};
  std::array<std::byte, 100> bytes;  // not room for all marks
  Encoder encoder(config(Encoding::evt3));
  Evt3Decoder decoder;
  std::array<Event, 1> none;
  std::array<Trigger, 2> read{};
  for (Progress done, seen; done.triggers == 0;) {
    done = encoder.encode(trigger, bytes);
    seen = decoder.decode(std::span(bytes).first(done.bytes), none, read);
    EXPECT_EQ(seen.triggers, done.triggers);
  }
  EXPECT_EQ(read[0], trigger);
  EXPECT_THROW(encoder.encode(Trigger{.t = 0, .id = 1, .value = 1}, bytes), std::invalid_argument);
  EXPECT_THROW(encoder.encode(Trigger{.t = 30'000'000, .id = 16, .value = 1}, bytes),
               std::invalid_argument);
  EXPECT_THROW(Encoder(config(Encoding::csv)).encode(trigger, bytes), std::invalid_argument);
}

TEST(Encoder, AllocatesNothing) {
  const Events events = some_events(2'000);
  for (const Encoding encoding : kAll) {
    Encoder encoder(config(encoding));
    Bytes bytes(1 << 20);
    const std::size_t before = test::allocations();
    encoder.encode(events, bytes);
    EXPECT_EQ(test::allocations(), before);
  }
}

// ---- what is refused ------------------------------------------------------------------------

std::string refusal(Encoding encoding, const Events& events) {
  try {
    encode(encoding, events);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(Encoder, RefusesAStampThatGoesBack) {
  for (const Encoding encoding : kAll) {
    Events events = some_events(100, 500);
    events[70].t = events[69].t - 3;
    EXPECT_EQ(refusal(encoding, events),
              "t = " + std::to_string(events[70].t) +
                  " (event 70): goes back by 3 us; sort the events, or drop this one");
  }
}

TEST(Encoder, NumbersTheEventsOfAllCalls) {
  Encoder encoder(config(Encoding::evt3));
  const Events events = some_events(10, 500);
  encode(encoder, events);
  const Events back{event(1, 2, 1, 0)};
  try {
    encode(encoder, back);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("t = 0 (event 10): goes back"), std::string::npos);
  }
}

TEST(Encoder, RefusesPixelsThatTheFormatCannotHold) {
  EXPECT_EQ(refusal(Encoding::evt3, {event(2048, 0, 1, 0)}),
            "x = 2048 (event 0): EVT3 holds pixels up to 2047");
  EXPECT_EQ(refusal(Encoding::evt3, {event(0, 0, 1, 0), event(0, 2048, 1, 0)}),
            "y = 2048 (event 1): EVT3 holds pixels up to 2047");
}

TEST(Encoder, RefusesTimesThatTheFormatCannotHold) {
  const std::string remedy =
      " cannot hold this time; count from the first event (relative), or split the recording";
  constexpr std::int64_t kUnix = 1'633'953'690'975'950;
  EXPECT_EQ(refusal(Encoding::evt3, {event(0, 0, 1, kUnix)}),
            "t = 1633953690975950 (event 0): EVT3" + remedy);
  EXPECT_EQ(refusal(Encoding::event_stream, {event(0, 0, 1, kUnix)}),
            "t = 1633953690975950 (event 0): Event Stream" + remedy);
  for (const Encoding encoding : kAll) {
    EXPECT_EQ(refusal(encoding, {event(0, 0, 1, -1)}).empty(), encoding == Encoding::csv);
  }
}

TEST(Encoder, AnEventStreamNeedsItsSensor) {
  EXPECT_THROW(Encoder({.encoding = Encoding::event_stream, .height = 5}), std::invalid_argument);
  EXPECT_THROW(Encoder({.encoding = Encoding::event_stream, .width = 5}), std::invalid_argument);
  EXPECT_THROW(Encoder({.width = -1}), std::invalid_argument);
  EXPECT_THROW(Encoder({.height = 65'536}), std::invalid_argument);
}

// ---- headers --------------------------------------------------------------------------------

TEST(Encoder, HeadersStateTheSensor) {
  const std::string header = Encoder(config(Encoding::evt3)).header();
  const auto found = read_raw_header(std::as_bytes(std::span(header)));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->width, 1280);
  EXPECT_EQ(found->height, 720);
  EXPECT_EQ(found->size, header.size());
  const std::string es = Encoder(config(Encoding::event_stream)).header();
  EXPECT_EQ(es, std::string("Event Stream\2\0\0\1\0\5\xd0\2", 20));
  EXPECT_EQ(Encoder({.encoding = Encoding::csv}).header(), "t [us],x,y,p\n");
}

}  // namespace
}  // namespace asap::encoder_test
