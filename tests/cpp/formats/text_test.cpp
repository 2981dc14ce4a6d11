#include "asap/formats/text.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/random.hpp"

namespace asap::text_test {
namespace {

using Events = std::vector<Event>;
using Offsets = std::vector<std::uint64_t>;

struct Decoded {
  Events events;
  std::uint64_t bad_records = 0;
  std::uint64_t out_of_bounds = 0;
  Offsets noted;
  bool ended_well = false;

  friend bool operator==(const Decoded&, const Decoded&) = default;
};

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

Decoded collect(TextDecoder& decoder, Events events) {
  const bool ended_well = decoder.finish(events);
  return {.events = std::move(events),
          .bad_records = decoder.bad_records(),
          .out_of_bounds = decoder.out_of_bounds(),
          .noted = {decoder.noted().begin(), decoder.noted().end()},
          .ended_well = ended_well};
}

Decoded decode(std::string_view text, const TextConfig& config = {}) {
  TextDecoder decoder(config);
  Events events;
  decoder.decode(bytes_of(text), events);
  return collect(decoder, std::move(events));
}

TEST(TextDecoder, DecodesSecondsByDefault) {
  const Decoded decoded = decode("0.003811000 96 133 0\n1.5 4 160 1\n");
  EXPECT_EQ(decoded.events, (Events{{96, 133, 0, 3811}, {4, 160, 1, 1'500'000}}));
  EXPECT_EQ(decoded.bad_records, 0u);
  EXPECT_TRUE(decoded.ended_well);
}

TEST(TextDecoder, DecodesEveryUnit) {
  const auto time = [](int exponent) {
    return decode("1500 1 2 1\n", {.time_exponent = exponent}).events.at(0).t;
  };
  EXPECT_EQ(time(6), 1'500'000'000);
  EXPECT_EQ(time(3), 1'500'000);
  EXPECT_EQ(time(0), 1500);
  EXPECT_EQ(time(-3), 2);
}

TEST(TextDecoder, TakesTheColumnsInAnyOrder) {
  const Events expected{{4, 5, 1, 6}};
  EXPECT_EQ(decode("5,4,6", {.order = "yxt", .time_exponent = 0}).events, expected);
  EXPECT_EQ(decode("1,4,5,6", {.order = "pxyt", .time_exponent = 0}).events, expected);
  EXPECT_EQ(decode("name 6 77 4 5 1", {.order = "-t-xyp", .time_exponent = 0}).events, expected);
}

TEST(TextDecoder, TakesEverySeparatorAndLineEnd) {
  const Events expected{{4, 5, 1, 6}};
  for (const std::string_view line : {"6 4 5 1\n", "6,4,5,1\r\n", "6, 4, 5, 1\n", "6\t4\t5\t1",
                                      "  6;4;5;1  \n", "6,4,5,1,\n", "\n\n6 4 5 1\n\n"}) {
    EXPECT_EQ(decode(line, {.time_exponent = 0}).events, expected) << line;
  }
}

TEST(TextDecoder, SkipsCommentsAndEmptyLines) {
  const Decoded decoded =
      decode("# t x y p\n\n  % 1 2 3 4\n \t\r\n1 2 3 1\n", {.time_exponent = 0});
  EXPECT_EQ(decoded.events, (Events{{2, 3, 1, 1}}));
  EXPECT_EQ(decoded.bad_records, 0u);
}

TEST(TextDecoder, TakesNumbersAsNumpyWritesThem) {
  const Decoded decoded =
      decode("1.000000000000000000e+06 2.180000000000000000e+02 1.500000000000000000e+01 1e0\n",
             {.time_exponent = 0});
  EXPECT_EQ(decoded.events, (Events{{218, 15, 1, 1'000'000}}));
}

TEST(TextDecoder, TakesPolarityAsPandasWritesABool) {
  const Decoded decoded = decode("1 2 3 True\n1 2 3 False\n1 2 3 true\n1 2 3 false\n");
  ASSERT_EQ(decoded.events.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(decoded.events[i].p, i % 2 == 0 ? 1 : 0);
  EXPECT_EQ(decode("1 True 3 1\n1 2 3 Truer\n1 2 3 Tru\n").bad_records, 3U);
}

TEST(TextDecoder, KeepsTheSignOfPolarity) {
  const auto polarity = [](std::string_view p) {
    return decode("1 2 3 " + std::string(p)).events.at(0).p;
  };
  EXPECT_EQ(polarity("-1"), -1);
  EXPECT_EQ(polarity("0"), 0);
  EXPECT_EQ(polarity("+1"), 1);
  EXPECT_EQ(polarity("3"), 3);
  EXPECT_EQ(polarity("0.25"), 1);
  EXPECT_EQ(polarity("-0.25"), -1);
  EXPECT_EQ(polarity("70000"), 32767);
  EXPECT_EQ(polarity("-70000"), -32768);
}

TEST(TextDecoder, CountsLinesThatAreNoEvents) {
  const std::string_view good = "1 2 3 1\n";
  for (const std::string_view bad :
       {"t x y p\n", "1 2 3\n", "1 2 3 1 1\n", "1 2.5 3 1\n", "1 2 3 nan\n", "1 2 3 1x\n",
        "1-2 3 1\n", "0x1 2 3 1\n", "1x2x3x1\n", "1 2 3 \x01\n"}) {
    for (const int exponent : {6, 0}) {  // whole microseconds go a way of their own
      std::string text = std::string(good) + std::string(bad);
      for (int i = 0; i < 20; ++i) text += good;  // which needs room behind the line
      const Decoded decoded = decode(text, {.time_exponent = exponent});
      EXPECT_EQ(decoded.events.size(), 21u) << bad;
      EXPECT_EQ(decoded.bad_records, 1u) << bad;
      EXPECT_EQ(decoded.noted, (Offsets{8})) << bad;
    }
  }
}

TEST(TextDecoder, CountsPositionsThatDoNotFit) {
  const Decoded decoded = decode("1 -1 3 1\n1 65535 3 1\n1 2 65536 1\n1 1e30 2 1\n");
  EXPECT_EQ(decoded.events, (Events{{65535, 3, 1, 1'000'000}}));
  EXPECT_EQ(decoded.out_of_bounds, 3u);
  EXPECT_EQ(decoded.bad_records, 0u);
  EXPECT_EQ(decoded.noted, (Offsets{0, 21, 33}));
}

TEST(TextDecoder, ClampsPositionsOnRequest) {
  TextDecoder decoder({.clamp = true});
  Events events;
  decoder.decode(bytes_of(std::string_view("1 -1 70000 1\n")), events);
  EXPECT_EQ(events, (Events{{0, 65535, 1, 1'000'000}}));
  EXPECT_EQ(decoder.clamped_positions(), 1u);
  EXPECT_EQ(decoder.out_of_bounds(), 0u);
}

TEST(TextDecoder, StampsBeyondMeasureAreLeftToTheValidator) {
  EXPECT_GT(decode("1e300 2 3 1\n").events.at(0).t, std::int64_t{1} << 52);
}

TEST(TextDecoder, TakesALastLineWithoutNewline) {
  EXPECT_EQ(decode("1 2 3 1\n2 2 3 1").events.size(), 2u);
}

TEST(TextDecoder, SaysThatTheLastLineWasCut) {
  const Decoded decoded = decode("1 2 3 1\n2 2", {.first_offset = 100});
  EXPECT_FALSE(decoded.ended_well);
  EXPECT_EQ(decoded.noted, (Offsets{108}));
}

TEST(TextDecoder, NotesTheFirstOffsetsOnly) {
  std::string text;
  for (int i = 0; i < 100; ++i) text += "no\n";
  const Decoded decoded = decode(text);
  EXPECT_EQ(decoded.bad_records, 100u);
  ASSERT_EQ(decoded.noted.size(), BadRecords::kNoted);
  EXPECT_EQ(decoded.noted.back(), 45u);
}

TEST(TextDecoder, ALineWithoutEndIsOneBadRecordInBoundedMemory) {
  const std::string endless(100'000, '1');
  const Decoded decoded = decode(endless + "\n1 2 3 1\n");
  EXPECT_EQ(decoded.bad_records, 1u);
  EXPECT_EQ(decoded.events.size(), 1u);
  EXPECT_EQ(decode("1 2 3 1" + std::string(100'000, ' ') + "x\n").bad_records, 1u);
}

TEST(TextDecoder, RefusesAnOrderThatIsNone) {
  for (const char* order :
       {"", "txy p", "txyy", "txypp", "xyp", "ttxy", "txyq", "txyp-------------"}) {
    try {
      const TextDecoder decoder({.order = order});
      FAIL() << order;
    } catch (const std::invalid_argument& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("order = '")) << error.what();
    }
  }
}

// Everything that a decoder may meet, in random arrangement.
std::string storm(std::uint64_t seed) {
  const std::string_view pieces[] = {
      "1", "2.5", "-3", "70000", " ", ",", "\n", "\r\n", "#", "1 2 3 1\n", "9.000001 34 56 0\n",
      "e", "."};
  const CounterRandom random(seed);
  std::string text;
  for (std::uint64_t i = 0; i < 120; ++i) text += pieces[random(i) % std::size(pieces)];
  if (seed % 3 == 0) text.insert(text.size() / 2, std::string(1000 + random(999) % 50, '7'));
  if (seed % 7 == 0) text.insert(text.size() / 3, std::string(1000 + random(998) % 50, ' '));
  return text;
}

TEST(TextDecoder, IsResumableAtAnyByte) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const std::string text = storm(seed);
    const Decoded whole = decode(text);
    const CounterRandom random(seed);
    for (std::size_t largest : {std::size_t{1}, std::size_t{7}, std::size_t{600}}) {
      TextDecoder decoder;
      Events events;
      for (std::size_t at = 0; at < text.size();) {
        const std::size_t size = std::min<std::size_t>(1 + random(at) % largest, text.size() - at);
        decoder.decode(bytes_of(std::string_view(text).substr(at, size)), events);
        at += size;
      }
      ASSERT_EQ(collect(decoder, std::move(events)), whole) << "seed " << seed << " " << largest;
    }
  }
}

// A line whose first byte comes alone takes the long way; it must not matter.
Decoded decode_the_long_way(std::string_view text, const TextConfig& config) {
  TextDecoder decoder(config);
  Events events;
  while (!text.empty()) {
    const std::size_t rest = std::min(text.find('\n'), text.size() - 1);
    decoder.decode(bytes_of(text.substr(0, 1)), events);
    decoder.decode(bytes_of(text.substr(1, rest)), events);
    text.remove_prefix(rest + 1);
  }
  return collect(decoder, std::move(events));
}

std::string digits(std::uint64_t bits, std::size_t max) {
  std::string text(bits % (max + 1), '0');
  for (char& digit : text) digit = static_cast<char>('0' + (bits >>= 3) % 10);
  return text;
}

// Mostly plain lines, each with a chance of everything that plain lines have not.
std::string nearly_plain(const CounterRandom& random, std::uint64_t line) {
  constexpr std::string_view kSeparators[] = {" ",  ",",   ", ", "\t", ";",
                                              ",,", "   ", "\r", "x",  ""};
  constexpr std::string_view kEnds[] = {"\n", "\n", "\r\n", " \n", "\r\r\n", ",\n", "\x80\n"};
  std::uint64_t at = line * 32;
  const auto one_in = [&](std::uint64_t n) { return random(at++) % n == 0; };
  const std::string_view separator = kSeparators[random(at++) % (one_in(4) ? 10 : 2)];
  std::string text = one_in(50) ? " " : "";
  for (int column = 0; column < 4; ++column) {
    if (column > 0) text += separator;
    if (one_in(12)) text += one_in(3) ? "+" : "-";
    text += digits(random(at++), one_in(4) ? 21 : column == 0 ? 10 : 4);
    if (one_in(column == 0 ? 2 : 30))
      text.append(".").append(digits(random(at++), one_in(4) ? 20 : 9));
    if (one_in(60)) text += "e2";
  }
  return text.append(kEnds[random(at++) % (one_in(4) ? std::size(kEnds) : 1)]);
}

TEST(TextDecoder, PlainLinesComeOutAsAllOthersDo) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const CounterRandom random(seed);
    std::string text;
    for (std::uint64_t line = 0; line < 100; ++line) text += nearly_plain(random, line);
    for (const char* order : {"txyp", "pyxt", "xtyp", "txy"}) {
      const TextConfig config{.order = order, .time_exponent = static_cast<int>(seed % 19) - 9};
      const Decoded found = decode(text, config);
      ASSERT_EQ(found, decode_the_long_way(text, config)) << "seed " << seed << " " << order;
    }
  }
}

}  // namespace
}  // namespace asap::text_test
