#include "formats/decimal.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
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
