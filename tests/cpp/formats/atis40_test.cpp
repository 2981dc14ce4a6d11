#include "asap/formats/atis.hpp"

#include <gtest/gtest.h>

#include "formats/decoding.hpp"

namespace asap::atis40_test {
namespace {

using namespace decoding;

void append_record(Bytes& bytes, unsigned x, unsigned y, unsigned p, unsigned t) {
  append_big(bytes, std::uint64_t{x} << 32 | y << 24 | p << 23 | t, 5);
}

std::pair<Bytes, Events> random_stream(std::size_t count) {
  const CounterRandom random(40);
  Bytes bytes;
  Events events;
  std::int64_t marked_us = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t bits = random(i);
    const auto x = static_cast<unsigned>(bits & 0xff);
    const auto y = bits >> 60 == 0 ? 240 : static_cast<unsigned>((bits >> 8 & 0xff) % 240);
    const auto p = static_cast<unsigned>(bits >> 16 & 1);
    const auto t = static_cast<unsigned>(bits >> 17 & 0x7f'ffff);
    append_record(bytes, x, y, p, t);
    if (y == 240) {
      marked_us += 8192;
    } else {
      events.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                        static_cast<std::int16_t>(p), t + marked_us});
    }
  }
  return {bytes, events};
}

TEST(Atis40Decoder, DecodesEveryField) {
  Bytes bytes;
  append_record(bytes, 255, 239, 1, 0x7f'ffff);
  append_record(bytes, 3, 4, 0, 0);
  EXPECT_EQ(events_of(Atis40Decoder(), bytes), (Events{{255, 239, 1, 8'388'607}, {3, 4, 0, 0}}));
}

TEST(Atis40Decoder, AddsWhatRow240Marks) {
  Bytes bytes;
  append_record(bytes, 1, 2, 1, 8000);
  append_record(bytes, 9, 240, 1, 77);
  append_record(bytes, 9, 240, 0, 0);
  append_record(bytes, 3, 4, 0, 5);
  EXPECT_EQ(events_of(Atis40Decoder(), bytes), (Events{{1, 2, 1, 8000}, {3, 4, 0, 16'389}}));
  EXPECT_EQ(events_of(Atis40Decoder({.marks = false}), bytes),
            (Events{{1, 2, 1, 8000}, {9, 240, 1, 77}, {9, 240, 0, 0}, {3, 4, 0, 5}}));
}

TEST(Atis40Decoder, IsTheSameHoweverTheBytesAreCut) {
  const auto [bytes, truth] = random_stream(900);
  EXPECT_EQ(events_of(Atis40Decoder(), bytes), truth);
  expect_cuts_and_room_make_no_difference(Atis40Decoder(), bytes);
  expect_truncation_gives_a_prefix(Atis40Decoder(), bytes);
  expect_no_allocation(Atis40Decoder(), bytes);
}

}  // namespace
}  // namespace asap::atis40_test
