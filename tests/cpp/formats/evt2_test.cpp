#include "asap/formats/prophesee.hpp"

#include "formats/decoding.hpp"

namespace asap::evt2_test {
namespace {

using namespace decoding;
using Words = std::vector<std::uint32_t>;

std::uint32_t high(std::uint32_t value) { return 8u << 28 | value; }

std::uint32_t cd(std::uint32_t p, std::uint32_t low, std::uint32_t x, std::uint32_t y) {
  return p << 28 | low << 22 | x << 11 | y;
}

std::uint32_t trigger(std::uint32_t low, std::uint32_t id, std::uint32_t value) {
  return 10u << 28 | low << 22 | id << 8 | value;
}

Decoded decode_words(const Words& words) {
  return decode(Evt2Decoder({.first_offset = 100}), bytes_of(words));
}

TEST(Evt2Decoder, DecodesEveryField) {
  const Decoded decoded =
      decode_words({high(1), cd(1, 5, 639, 479), cd(0, 63, 2047, 2047), cd(1, 0, 0, 0)});
  EXPECT_EQ(decoded.events, (Events{{639, 479, 1, 69}, {2047, 2047, 0, 127}, {0, 0, 1, 64}}));
  EXPECT_EQ(decoded.bad_records, 0u);
}

TEST(Evt2Decoder, RepeatedTimeHighChangesNothing) {
  const Decoded decoded = decode_words({high(7), high(7), cd(1, 1, 2, 3), high(7), cd(1, 2, 2, 3)});
  EXPECT_EQ(decoded.events, (Events{{2, 3, 1, 449}, {2, 3, 1, 450}}));
}

TEST(Evt2Decoder, SmallFallOfTimeHighGoesBackAndALargeOneUnwraps) {
  const Decoded decoded =
      decode_words({high(0xfffffff), cd(1, 0, 0, 0), high(0xffffffe), cd(1, 0, 0, 0), high(0),
                    cd(1, 0, 0, 0), high(1), cd(1, 0, 0, 0)});
  const std::int64_t range = std::int64_t{1} << 34;
  ASSERT_EQ(decoded.events.size(), 4u);
  EXPECT_EQ(decoded.events[0].t, range - 64);
  EXPECT_EQ(decoded.events[1].t, range - 128);
  EXPECT_EQ(decoded.events[2].t, range);
  EXPECT_EQ(decoded.events[3].t, range + 64);
}

TEST(Evt2Decoder, DropsEventsBeforeTheFirstTimeHighAndCountsThem) {
  const Decoded decoded = decode_words({cd(1, 1, 1, 1), cd(0, 2, 2, 2), high(0), cd(1, 3, 3, 3)});
  EXPECT_EQ(decoded.events, (Events{{3, 3, 1, 3}}));
  EXPECT_EQ(decoded.before_start, 2u);
}

TEST(Evt2Decoder, HandsTriggersOut) {
  const Decoded decoded =
      decode_words({high(1), trigger(3, 6, 1), cd(1, 3, 1, 1), trigger(4, 31, 0)});
  EXPECT_EQ(decoded.triggers, (Triggers{{67, 6, 1}, {68, 31, 0}}));
  EXPECT_EQ(decoded.events.size(), 1u);
}

TEST(Evt2Decoder, CountsTriggersWithoutASpan) {
  const auto bytes = bytes_of(Words{high(1), trigger(3, 6, 1), trigger(4, 6, 0), cd(1, 0, 1, 1)});
  Evt2Decoder decoder;
  Events events(1);
  EXPECT_EQ(decoder.decode(bytes, std::span(events)), (Progress{.bytes = 16, .events = 1}));
  EXPECT_EQ(decoder.triggers(), 2u);
}

TEST(Evt2Decoder, PassesOthersAndNotesUnknownTypes) {
  const Decoded decoded = decode_words({high(0), 14u << 28 | 5, 15u << 28 | 7, 2u << 28, 9u << 28});
  EXPECT_EQ(decoded.bad_records, 2u);
  EXPECT_EQ(decoded.noted, (Offsets{112, 116}));
}

TEST(Evt2Decoder, WordsWithoutEventsNeedNoRoom) {
  const auto bytes = bytes_of(Words{high(0), cd(1, 0, 1, 1), high(1), high(2)});
  Evt2Decoder decoder;
  Events events(1);
  EXPECT_EQ(decoder.decode(bytes, std::span(events)), (Progress{.bytes = 16, .events = 1}));
}

TEST(Evt2Decoder, SaysHowMuchOfAWordIsThere) {
  auto bytes = bytes_of(Words{high(0), cd(1, 0, 1, 1)});
  bytes.resize(7);
  EXPECT_EQ(decode(Evt2Decoder{}, bytes).unfinished, 3u);
  EXPECT_TRUE(decode(Evt2Decoder{}, bytes).events.empty());
}

TEST(Evt2Decoder, ResetForgetsEverything) {
  const auto bytes = bytes_of(Words{high(9), 2u << 28, cd(1, 0, 1, 1), trigger(0, 0, 0)});
  Evt2Decoder decoder;
  Events events(4);
  EXPECT_EQ(decoder.decode(std::span(bytes).first(15), std::span(events)).events, 1u);
  decoder.reset();
  EXPECT_EQ(decoder.unfinished() + decoder.bad_records() + decoder.triggers(), 0u);
  EXPECT_EQ(decoder.decode(std::span(bytes).subspan(8), std::span(events)).events, 0u);
  EXPECT_EQ(decoder.before_start(), 1u);
}

TEST(Evt2Decoder, CutsAndRoomMakeNoDifference) {
  const CounterRandom random(7);
  std::uint64_t at = 0;
  Words words;
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t bits = random(at++);
    const auto low = static_cast<std::uint32_t>(bits);
    const std::uint64_t kind = bits >> 60;
    words.push_back(kind < 11 ? low & 0x1fffffff : kind < 14 ? high(low >> 6) : low);
  }
  expect_cuts_and_room_make_no_difference(Evt2Decoder{}, bytes_of(words));
}

}  // namespace
}  // namespace asap::evt2_test
