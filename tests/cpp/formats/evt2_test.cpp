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

TEST(Evt2Decoder, SmallFallOfTimeHighGoesBackAndALargeOneUnwraps) {
  const Decoded decoded =
      decode_words({high(0xfffffff), cd(1, 0, 0, 0), high(0xffffffe), cd(1, 0, 0, 0), high(0),
                    cd(1, 0, 0, 0), high(1), cd(1, 0, 0, 0), high(0xfffffff), cd(1, 0, 0, 0)});
  const std::int64_t range = std::int64_t{1} << 34;
  ASSERT_EQ(decoded.events.size(), 5u);
  EXPECT_EQ(decoded.events[0].t, range - 64);
  EXPECT_EQ(decoded.events[1].t, range - 128);
  EXPECT_EQ(decoded.events[2].t, range);
  EXPECT_EQ(decoded.events[3].t, range + 64);
  EXPECT_EQ(decoded.events[4].t, range - 64);
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

}  // namespace
}  // namespace asap::evt2_test
