#include "formats/decimal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "core/random.hpp"

namespace asap::decimal_test {
namespace {

Rounded round_text(std::string_view text, int shift = 0) {
  Decimal number;
  const char* end = read_decimal(text.data(), text.data() + text.size(), number);
  EXPECT_EQ(end, text.data() + text.size()) << text;
  return round_decimal(number, shift);
}

TEST(Decimal, ReadsEveryWayToWriteANumber) {
  EXPECT_EQ(round_text("0").value, 0);
  EXPECT_EQ(round_text("42").value, 42);
  EXPECT_EQ(round_text("-42").value, -42);
  EXPECT_EQ(round_text("+7.").value, 7);
  EXPECT_EQ(round_text(".5", 1).value, 5);
  EXPECT_EQ(round_text("2.180000000000000000e+02").value, 218);
  EXPECT_EQ(round_text("1e3").value, 1000);
  EXPECT_EQ(round_text("12000E-3").value, 12);
  EXPECT_EQ(round_text("0000000000000000000000000000001").value, 1);
  EXPECT_EQ(round_text("0.0000000000000000000000000000010", 30).value, 1);
}

TEST(Decimal, StopsWhereTheNumberStops) {
  const std::string_view text = "12.5 9";
  Decimal number;
  EXPECT_EQ(read_decimal(text.data(), text.data() + text.size(), number), text.data() + 4);
}

TEST(Decimal, RefusesWhatIsNoNumber) {
  for (const std::string_view text :
       {"", "-", ".", "+.", "x", "nan", "inf", "e5", "1e", "1e+", "--1"}) {
    Decimal number;
    EXPECT_EQ(read_decimal(text.data(), text.data() + text.size(), number), nullptr) << text;
  }
}

TEST(Decimal, NeverReadsPastTheEnd) {
  const std::string_view text = "1.25e7";
  const std::int64_t parts[] = {1, 1, 1, 1};  // "1", "1.", "1.2", "1.25"
  for (std::size_t length = 1; length <= 4; ++length) {
    EXPECT_EQ(round_text(text.substr(0, length)).value, parts[length - 1]);
  }
}

TEST(Decimal, RoundsHalfToEven) {
  EXPECT_EQ(round_text("0.5").value, 0);
  EXPECT_EQ(round_text("1.5").value, 2);
  EXPECT_EQ(round_text("2.5").value, 2);
  EXPECT_EQ(round_text("-1.5").value, -2);
  EXPECT_EQ(round_text("2.51").value, 3);
  EXPECT_EQ(round_text("2.49").value, 2);
  EXPECT_EQ(round_text("2.500000000000000000000000000000001").value, 3);
  EXPECT_EQ(round_text("0.00000000000000000000000000001").value, 0);
}

TEST(Decimal, SaysWhetherItRounded) {
  EXPECT_TRUE(round_text("12.000").exact);
  EXPECT_TRUE(round_text("1.25", 2).exact);
  EXPECT_FALSE(round_text("12.001").exact);
  EXPECT_FALSE(round_text("1e-30").exact);
}

TEST(Decimal, StopsAtHuge) {
  EXPECT_EQ(round_text("1e300").value, Rounded::kHuge);
  EXPECT_EQ(round_text("-99999999999999999999").value, -Rounded::kHuge);
  EXPECT_EQ(round_text("18446744073709551629").value, Rounded::kHuge);
  EXPECT_EQ(round_text("4611686018427387905").value, Rounded::kHuge);
  EXPECT_EQ(round_text("4611686018427387903").value, Rounded::kHuge - 1);
}

// Where double is too coarse: Unix seconds with nine digits, a tie at the last microsecond.
TEST(Decimal, IsExactWhereDoubleIsNot) {
  EXPECT_EQ(round_text("1633953690.975950500", 6).value, 1633953690975950);
  EXPECT_EQ(round_text("1633953690.975951500", 6).value, 1633953690975952);
  EXPECT_EQ(round_text("1633953690.975950501", 6).value, 1633953690975951);
}

TEST(Decimal, EveryMicrosecondComesBack) {
  const CounterRandom random(3);
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    const auto t_us = static_cast<std::int64_t>(random(i) >> (12 + i % 40));
    char text[48];
    std::snprintf(text, sizeof text, "%lld.%06lld", static_cast<long long>(t_us / 1'000'000),
                  static_cast<long long>(t_us % 1'000'000));
    ASSERT_EQ(round_text(text, 6).value, t_us) << text;
  }
}

TEST(Decimal, AgreesWithDoubleAwayFromTies) {
  const CounterRandom random(4);
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    const double seconds = random.uniform(i) * 1000.0;
    char text[48];
    std::snprintf(text, sizeof text, i % 2 == 0 ? "%.9f" : "%.18e", seconds);
    const double expected = std::stod(text) * 1e6;
    if (std::abs(expected - std::floor(expected) - 0.5) < 1e-3) continue;
    ASSERT_EQ(round_text(text, 6).value, std::llround(expected)) << text;
  }
}

}  // namespace
}  // namespace asap::decimal_test
