#include "asap/formats/prophesee.hpp"

#include <bit>

#include "formats/decoding.hpp"

namespace asap::evt21_test {
namespace {

using namespace decoding;
using Words = std::vector<std::uint64_t>;

std::uint64_t high(std::uint64_t value) { return 8ull << 60 | value << 32; }

std::uint64_t cd(std::uint64_t p, std::uint64_t low, std::uint64_t x, std::uint64_t y,
                 std::uint32_t mask) {
  return p << 60 | low << 54 | x << 43 | y << 32 | mask;
}

std::uint64_t trigger(std::uint64_t low, std::uint64_t id, std::uint64_t value) {
  return 10ull << 60 | low << 54 | id << 40 | value << 32;
}

Decoded decode_words(const Words& words) {
  return decode(Evt21Decoder({.little_endian = true, .first_offset = 100}), bytes_of(words));
}

TEST(Evt21Decoder, DecodesEveryField) {
  const Decoded decoded = decode_words(
      {high(1), cd(1, 5, 32, 479, 0x80000003), cd(0, 63, 2016, 2047, 1), cd(1, 0, 0, 0, 0)});
  EXPECT_EQ(decoded.events,
            (Events{{32, 479, 1, 69}, {33, 479, 1, 69}, {63, 479, 1, 69}, {2016, 2047, 0, 127}}));
}

TEST(Evt21Decoder, LegacyWordsHaveTheirHalvesSwapped) {
  Words words{high(3), cd(1, 5, 64, 7, 0xf0f0), trigger(1, 2, 1)};
  const Decoded little = decode_words(words);
  for (auto& word : words) word = std::rotl(word, 32);
  EXPECT_EQ(decode(Evt21Decoder{}, bytes_of(words)), little);
  EXPECT_EQ(little.events.size(), 8u);
  EXPECT_EQ(little.triggers, (Triggers{{193, 2, 1}}));
}

TEST(Evt21Decoder, TimesUnwrap) {
  const Decoded decoded =
      decode_words({high(0xfffffff), cd(1, 0, 0, 0, 1), high(0xffffffe), cd(1, 0, 0, 0, 1), high(0),
                    cd(1, 0, 0, 0, 1), high(0), cd(1, 1, 0, 0, 1)});
  const std::int64_t range = std::int64_t{1} << 34;
  EXPECT_EQ(
      decoded.events,
      (Events{
          {0, 0, 1, range - 64}, {0, 0, 1, range - 128}, {0, 0, 1, range}, {0, 0, 1, range + 1}}));
}

TEST(Evt21Decoder, DropsEventsBeforeTheFirstTimeHighAndCountsThem) {
  const Decoded decoded = decode_words({cd(1, 1, 0, 1, 7), high(0), cd(1, 3, 0, 3, 1)});
  EXPECT_EQ(decoded.events, (Events{{0, 3, 1, 3}}));
  EXPECT_EQ(decoded.before_start, 3u);
}

TEST(Evt21Decoder, PassesOthersAndNotesUnknownTypes) {
  const Decoded decoded =
      decode_words({high(0), 14ull << 60, 15ull << 60, 2ull << 60, 13ull << 60, 11ull << 60});
  EXPECT_EQ(decoded.bad_records, 3u);
  EXPECT_EQ(decoded.noted, (Offsets{124, 132, 140}));
}

TEST(Evt21Decoder, StopsBeforeAWordWithoutRoomAndFillsUp) {
  const auto bytes = bytes_of(Words{high(0), cd(1, 0, 0, 0, 3), cd(1, 1, 0, 0, 7), high(1)});
  Evt21Decoder decoder({.little_endian = true});
  Events events(4);
  EXPECT_EQ(decoder.decode(bytes, std::span(events)), (Progress{.bytes = 16, .events = 2}));
  decoder.reset();
  events.resize(5);
  EXPECT_EQ(decoder.decode(bytes, std::span(events)), (Progress{.bytes = 32, .events = 5}));
}

}  // namespace
}  // namespace asap::evt21_test
