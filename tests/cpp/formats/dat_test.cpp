#include "asap/formats/prophesee.hpp"

#include <stdexcept>
#include <string>

#include "formats/decoding.hpp"

namespace asap::dat_test {
namespace {

using namespace decoding;
using Words = std::vector<std::uint32_t>;

std::uint32_t version2(std::uint32_t x, std::uint32_t y, std::uint32_t p) {
  return p << 28 | y << 14 | x;
}

std::uint32_t version1(std::uint32_t x, std::uint32_t y, std::uint32_t p) {
  return p << 17 | y << 9 | x;
}

Bytes file_of(std::string header, const Words& words) {
  Bytes bytes;
  for (const char c : header) bytes.push_back(static_cast<std::byte>(c));
  const Bytes events = bytes_of(words);
  bytes.insert(bytes.end(), events.begin(), events.end());
  return bytes;
}

TEST(DatDecoder, DecodesVersion2) {
  const Decoded decoded =
      decode(DatDecoder{}, bytes_of(Words{7, version2(1279, 719, 1), 8, version2(16383, 16383, 0),
                                          9, version2(0, 0, 15)}));
  EXPECT_EQ(decoded.events, (Events{{1279, 719, 1, 7}, {16383, 16383, 0, 8}, {0, 0, 15, 9}}));
}

TEST(DatDecoder, DecodesVersion1) {
  const Decoded decoded =
      decode(DatDecoder({.version = 1}),
             bytes_of(Words{7, version1(303, 239, 1), 8, version1(511, 255, 0)}));
  EXPECT_EQ(decoded.events, (Events{{303, 239, 1, 7}, {511, 255, 0, 8}}));
}

TEST(DatDecoder, TimesUnwrapAndSmallStepsBackStay) {
  const Decoded decoded =
      decode(DatDecoder{}, bytes_of(Words{0xffffffff, 0, 0xfffffff0, 0, 3, 0, 2, 0, 0x80000000, 0,
                                          0xffffffff, 0, 0, 0, 0xfffffffe, 0, 1, 0}));
  const std::int64_t range = std::int64_t{1} << 32;
  std::vector<std::int64_t> times;
  for (const Event& event : decoded.events) times.push_back(event.t);
  EXPECT_EQ(times, (std::vector<std::int64_t>{range - 1, range - 16, range + 3, range + 2,
                                              range + range / 2, 2 * range - 1, 2 * range,
                                              2 * range - 2, 2 * range + 1}));
}

TEST(DatDecoder, RefusesAnotherVersion) {
  EXPECT_THROW(DatDecoder({.version = 3}), std::invalid_argument);
}

TEST(DatHeader, SaysWhatTheEventsAre) {
  const std::string text =
      "% Data file containing CD events.\n% Version 2\n% Width 304\n% Height 240\n";
  const auto header = read_dat_header(file_of(text + "\x0c\x08", {1, 2}));
  ASSERT_TRUE(header);
  EXPECT_EQ(header->size, text.size() + 2);
  EXPECT_EQ(header->type, 12);
  EXPECT_EQ(header->event_size, 8);
  EXPECT_EQ(header->version, 2);
  EXPECT_EQ(header->width, 304);
  EXPECT_EQ(header->height, 240);
}

TEST(DatHeader, EventsDecideWhereTheVersionIsNotStated) {
  const std::string start = "% Date 2014\n" + std::string("\0\x08", 2);
  const auto version = [&](std::uint32_t address) {
    return read_dat_header(file_of(start, {5, 0, 6, address, 7, 0}))->version;
  };
  EXPECT_EQ(version(version1(511, 255, 1)), 1);
  EXPECT_EQ(version(version2(3, 16, 0)), 2);
  EXPECT_EQ(version(version2(3, 1, 1)), 2);
  EXPECT_EQ(version(0), 2);
}

TEST(DatHeader, IsNothingElse) {
  EXPECT_FALSE(read_dat_header({}));
  EXPECT_FALSE(read_dat_header(file_of("% evt 3.0\n\x0c\x08", {1, 2})));
  EXPECT_FALSE(read_dat_header(file_of("% a comment\n1 2 3 4\n", {})));
  EXPECT_FALSE(read_dat_header(file_of("% Data file containing CD events.\n\x0c", {})));
  EXPECT_FALSE(read_dat_header(file_of("% Data file containing CD events.\n% Ver", {})));
  EXPECT_FALSE(read_dat_header(file_of("\x0c\x08", {1, 2})));
}

}  // namespace
}  // namespace asap::dat_test
