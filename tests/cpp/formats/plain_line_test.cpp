#include "formats/plain_line.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "asap/core/random.hpp"
#include "formats/decimal.hpp"

namespace asap::plain_line_test {
namespace {

struct Read {
  std::int64_t t;
  std::uint32_t x;
  bool negative;
  std::uint32_t p;
  std::size_t size;  // of the line
  bool plain;
};

Read read(std::string text, int exponent = 0) {
  text.append(PlainLine::kRoom, '#');
  PlainLine line(text.data());
  Read found{};
  found.t = line.time(exponent);
  line.separator();
  found.x = line.small();
  line.separator();
  found.negative = line.sign();
  found.p = line.small();
  found.size = static_cast<std::size_t>(line.end() - text.data());
  found.plain = line.plain();
  return found;
}

TEST(PlainLine, ReadsItsNumbers) {
  const Read found = read("1633953690975950,345,-1\r\n");
  EXPECT_TRUE(found.plain);
  EXPECT_EQ(found.t, 1'633'953'690'975'950);
  EXPECT_EQ(found.x, 345u);
  EXPECT_TRUE(found.negative);
  EXPECT_EQ(found.p, 1u);
  EXPECT_EQ(found.size, 25u);
}

TEST(PlainLine, TwoSeparatorsMayStandTogether) {
  const Read found = read("12, 7\t;0\n");
  EXPECT_TRUE(found.plain);
  EXPECT_EQ(found.t, 12);
  EXPECT_EQ(found.x, 7u);
  EXPECT_EQ(found.p, 0u);
}

TEST(PlainLine, RefusesWhatIsNotPlain) {
  for (const char* text :
       {"1 2\n", "1 2 3 4\n", " 1 2 3\n", "1   2 3\n", "1 2 3 \n", "1 -2 3\n", "-1 2 3\n",
        "1e3 2 3\n", "1 2.0 3\n", "1 12345 3\n", "1x2 3\n", "12345678901234567 2 3\n",
        "12345678.12345678901 2 3\n", "1234567890123456 1234 123456789\n",
        "1 2 3                                  \n", "1 2 3", "", "\n", "# 1 2 3\n"}) {
    EXPECT_FALSE(read(text).plain) << text;
  }
}

std::size_t whole_txyp(std::string text, Event& event) {
  text.append(PlainLine::kRoom, '#');
  const char* const next = PlainLine::read_whole_txyp(text.data(), event);
  return next == nullptr ? 0 : static_cast<std::size_t>(next - text.data());
}

TEST(PlainLine, ReadsWholeNumbersWithOneSeparator) {
  Event event{};
  EXPECT_EQ(whole_txyp("1633953690975950,1279,719,1\n", event), 28u);
  EXPECT_EQ(event, (Event{.x = 1279, .y = 719, .p = 1, .t = 1'633'953'690'975'950}));
  EXPECT_EQ(whole_txyp("7 0 0012 0\n1 2 3", event), 11u);
  EXPECT_EQ(event, (Event{.x = 0, .y = 12, .p = 0, .t = 7}));
  EXPECT_EQ(whole_txyp("1234567890123456\t1234\t12345678\t1\n", event), 0u);
  EXPECT_EQ(whole_txyp("1234567890123456;1234;00123;1\n", event), 0u);
  EXPECT_EQ(whole_txyp("1234567890123456;001234;0123;1\n", event), 0u);
  EXPECT_EQ(whole_txyp("1234567890123456;1234;1234;5678\n", event), 0u);
}

TEST(PlainLine, LeavesOtherLinesThanThese) {
  Event event{};
  for (const char* text : {"1,2,3\n",
                           "1,2,3,1,5\n",
                           "1,2,3,10\n",
                           "1,2,3,\n",
                           "1,2,,1\n",
                           "1,,3,1\n",
                           ",2,3,1\n",
                           "1,2,3 1\n",
                           "1 2,3,1\n",
                           "1,2 3,1\n",
                           "1x2x3x1\n",
                           "1,2,3,-1\n",
                           "-1,2,3,1\n",
                           "1,2,3,1",
                           "1.5,2,3,1\n",
                           "1,2,3,1\r\n",
                           "1,12345,3,1\n",
                           "1,2,12345,1\n",
                           "12345678901234567,2,3,1\n",
                           " 1,2,3,1\n",
                           "1,2,3,1 \n",
                           "1, 2,3,1\n",
                           "",
                           "\n",
                           "x"}) {
    EXPECT_EQ(whole_txyp(text, event), 0u) << text;
  }
}

TEST(PlainLine, TimesAreThoseOfReadDecimal) {
  for (std::uint64_t seed = 0; seed < 20'000; ++seed) {
    const CounterRandom random(seed);
    std::string number;
    for (std::uint64_t i = 0; i < 1 + random(0) % 9; ++i)
      number += "0123456789"[random(i + 2) % 10];
    if (random(1) % 3 != 0) {
      number += '.';
      for (std::uint64_t i = 0; i < random(20) % 10; ++i) {
        number += "0123456789"[random(i + 21) % 10];
      }
    }
    const int exponent = static_cast<int>(random(40) % 10);
    const Read found = read(number + ",5,1\n", exponent);
    Decimal decimal;
    read_decimal(number.data(), number.data() + number.size(), decimal);
    EXPECT_TRUE(found.plain) << number;
    EXPECT_EQ(found.t, round_decimal(decimal, exponent).value) << number << " e" << exponent;
  }
}

TEST(PlainLine, KnowsTheSeparators) {
  const std::string_view separators = " ,\t;\r";
  for (int c = 0; c < 256; ++c) {
    const char character = static_cast<char>(c);
    EXPECT_EQ(is_separator(character), separators.find(character) != separators.npos) << c;
  }
}

}  // namespace
}  // namespace asap::plain_line_test
