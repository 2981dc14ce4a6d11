#include "asap/formats/prophesee.hpp"

#include "formats/decoding.hpp"

namespace asap::evt3_test {
namespace {

using namespace decoding;
using Words = std::vector<std::uint16_t>;

std::uint16_t word(unsigned type, unsigned value) {
  return static_cast<std::uint16_t>(type << 12 | value);
}
std::uint16_t addr_y(unsigned y) { return word(0, y); }
std::uint16_t addr_x(unsigned p, unsigned x) { return word(2, p << 11 | x); }
std::uint16_t base(unsigned p, unsigned x) { return word(3, p << 11 | x); }
std::uint16_t vect12(unsigned mask) { return word(4, mask); }
std::uint16_t vect8(unsigned mask) { return word(5, mask); }
std::uint16_t low(unsigned t) { return word(6, t); }
std::uint16_t high(unsigned t) { return word(8, t); }
std::uint16_t trigger(unsigned id, unsigned value) { return word(10, id << 8 | value); }

Decoded decode_words(const Words& words) {
  return decode(Evt3Decoder({.first_offset = 100}), bytes_of(words));
}

std::vector<std::int64_t> times_of(const Words& words) {
  std::vector<std::int64_t> times;
  for (const Event& event : decode_words(words).events) times.push_back(event.t);
  return times;
}

using Times = std::vector<std::int64_t>;

TEST(Evt3Decoder, DecodesEveryField) {
  const Decoded decoded = decode_words({high(1), low(5), addr_y(719), addr_x(1, 1279), addr_x(0, 0),
                                        addr_y(0x800 | 3), low(6), addr_x(1, 2047)});
  EXPECT_EQ(decoded.events, (Events{{1279, 719, 1, 4101}, {0, 719, 0, 4101}, {2047, 3, 1, 4102}}));
}

TEST(Evt3Decoder, VectorsMoveTheBaseEvenIfTheyAreEmpty) {
  const Decoded decoded = decode_words({high(0), low(9), addr_y(4), base(1, 100), vect12(0x801),
                                        vect12(0), vect8(0xf82), base(0, 7), vect8(1), vect8(1)});
  EXPECT_EQ(decoded.events, (Events{{100, 4, 1, 9},
                                    {111, 4, 1, 9},
                                    {125, 4, 1, 9},
                                    {131, 4, 1, 9},
                                    {7, 4, 0, 9},
                                    {15, 4, 0, 9}}));
}

TEST(Evt3Decoder, RepeatedTimeHighChangesNothingAndTimeLowMayStepBack) {
  EXPECT_EQ(times_of({addr_y(1), high(2861), low(811), addr_x(1, 1), high(2861), addr_x(1, 1),
                      low(800), addr_x(1, 1)}),
            (Times{2861 * 4096 + 811, 2861 * 4096 + 811, 2861 * 4096 + 800}));
  EXPECT_EQ(times_of({high(1), low(5), high(1), addr_y(1), addr_x(1, 1)}), (Times{4101}));
}

TEST(Evt3Decoder, AnotherTimeHighSetsTimeLowToZero) {
  EXPECT_EQ(times_of({addr_y(1), high(1), low(4095), addr_x(1, 1), high(2), addr_x(1, 1), low(3),
                      addr_x(1, 1)}),
            (Times{8191, 8192, 8195}));
}

TEST(Evt3Decoder, SmallFallOfTimeHighGoesBackAndALargeOneUnwraps) {
  const std::int64_t range = 1 << 24;
  EXPECT_EQ(
      times_of({addr_y(1), high(4095), addr_x(1, 1), high(4094), low(7), addr_x(1, 1), high(0),
                addr_x(1, 1), high(4095), addr_x(1, 1), high(1), low(2), addr_x(1, 1)}),
      (Times{range - 4096, range - 8192 + 7, range, range - 4096, range + 4098}));
}

TEST(Evt3Decoder, DropsWhatHasNoTimeNoRowOrNoBaseAndCountsIt) {
  const Decoded decoded =
      decode_words({addr_y(1), addr_x(1, 1), vect8(3), high(0), vect12(7), addr_x(1, 2)});
  EXPECT_EQ(decoded.events, (Events{{2, 1, 1, 0}}));
  EXPECT_EQ(decoded.before_start, 6u);
  EXPECT_EQ(decode_words({high(0), addr_x(1, 1), addr_y(1), addr_x(1, 2)}).before_start, 1u);
}

TEST(Evt3Decoder, BehindAGapDropsWhatItCannotPlaceAndTimeGoesOn) {
  Evt3Decoder decoder;
  Decoded before, after;
  feed(decoder,
       bytes_of(Words{high(4000), low(5), addr_y(1), base(1, 100), addr_x(1, 1),  //
                      high(10), addr_x(1, 2)}),
       4096, before);
  decoder.resume();
  feed(decoder,
       bytes_of(Words{addr_x(1, 3), addr_y(7), addr_x(1, 4), vect8(3), high(10), low(9), vect8(1),
                      addr_x(1, 5)}),
       4096, after);
  const std::int64_t wrapped = (1 << 24) + 10 * 4096;
  EXPECT_EQ(before.events.back(), (Event{2, 1, 1, wrapped}));
  EXPECT_EQ(after.events, (Events{{5, 7, 1, wrapped + 9}}));
  EXPECT_EQ(decoder.before_start(), 5u);
}

TEST(Evt3Decoder, ATimeHighAloneIsNoTimeAfterAGap) {
  Evt3Decoder decoder;
  Decoded before, after;
  feed(decoder, bytes_of(Words{high(1), low(5), addr_y(1), addr_x(1, 1)}), 4096, before);
  decoder.resume();
  feed(decoder, bytes_of(Words{high(1), addr_y(1), addr_x(1, 2), high(2), addr_x(1, 3)}), 4096,
       after);
  EXPECT_EQ(after.events, (Events{{3, 1, 1, 2 * 4096}}));
  EXPECT_EQ(decoder.before_start(), 1u);
}

TEST(Evt3Decoder, PaddingIsNoBadRecord) {
  const Decoded decoded =
      decode_words({high(1), word(9, 0x999), addr_y(1), word(9, 0x999), addr_x(1, 1)});
  EXPECT_EQ(decoded.bad_records, 0u);
  EXPECT_EQ(decoded.events, (Events{{1, 1, 1, 4096}}));
}

TEST(Evt3Decoder, HandsTriggersOut) {
  const Decoded decoded = decode_words({trigger(1, 1), high(1), low(3), trigger(6, 1), low(4),
                                        addr_y(0), addr_x(1, 1), trigger(15, 0)});
  EXPECT_EQ(decoded.triggers, (Triggers{{4099, 6, 1}, {4100, 15, 0}}));
}

TEST(Evt3Decoder, PassesOthersAndNotesUnknownTypes) {
  const Decoded decoded =
      decode_words({high(0), addr_y(0), word(7, 1), word(14, 0x14), word(15, 5), word(1, 0),
                    word(9, 0), word(11, 0), word(12, 0), word(13, 0)});
  EXPECT_EQ(decoded.bad_records, 5u);
  EXPECT_EQ(decoded.noted, (Offsets{110, 112, 114, 116, 118}));
}

TEST(Evt3Decoder, StopsBeforeAVectorWithoutRoomAndFillsUp) {
  const auto bytes = bytes_of(
      Words{high(0), addr_y(1), addr_x(1, 1), base(1, 0), vect8(7), vect12(0), low(1), addr_y(3)});
  Evt3Decoder decoder;
  Events events(3);
  EXPECT_EQ(decoder.decode(bytes, std::span(events)), (Progress{.bytes = 8, .events = 1}));
  decoder.reset();
  events.resize(4);
  EXPECT_EQ(decoder.decode(bytes, std::span(events)), (Progress{.bytes = 16, .events = 4}));
}

TEST(Evt3Decoder, BaseNeverLeavesSixteenBits) {
  Words words{high(0), addr_y(1), base(1, 2047)};
  words.insert(words.end(), 6000, vect12(0));
  words.push_back(vect12(0x800));
  const Decoded decoded = decode_words(words);
  ASSERT_EQ(decoded.events.size(), 1u);
  EXPECT_EQ(decoded.events[0], (Event{(2047 + 72000 + 11) & 0xffff, 1, 1, 0}));
}

// Words of all types, most of them often; no vector of more than 11 events.
Words some_words() {
  const CounterRandom random(7);
  Words words{high(1), addr_y(3)};
  static constexpr unsigned kTypes[] = {0, 0, 2, 2, 2, 2, 3, 3, 4, 5, 6, 6, 6, 8, 10, 16};
  for (std::uint64_t i = 0; i < 2000; ++i) {
    const auto bits = static_cast<unsigned>(random(i) & 0xffff);
    const unsigned type = kTypes[random(i + 10'000) % 16];
    words.push_back(type == 16 ? static_cast<std::uint16_t>(bits) : word(type, bits & 0xfff));
    if (words.back() >> 12 == 4) words.back() &= 0xf7ff;
  }
  return words;
}

TEST(Evt3Decoder, TheFastPathGivesWhatThePlainDecoderGives) {
  constexpr std::size_t kNoFastPath = Evt3Decoder::kMaxPerRecord - 1;  // room for events
  const Bytes bytes = bytes_of(some_words());
  const Decoded plain = decode(Evt3Decoder{}, bytes, bytes.size(), kNoFastPath);
  EXPECT_GT(plain.events.size(), 500u);
  EXPECT_EQ(decode(Evt3Decoder{}, bytes), plain);
}

}  // namespace
}  // namespace asap::evt3_test
