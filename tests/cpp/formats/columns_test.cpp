#include "formats/columns.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

#include "core/random.hpp"

namespace asap::columns_test {
namespace {

template <class Value>
constexpr Number number() {
  if constexpr (std::is_same_v<Value, double>) return Number::f64;
  constexpr bool is_signed = std::is_signed_v<Value>;
  switch (sizeof(Value)) {
    case 1:
      return is_signed ? Number::i8 : Number::u8;
    case 2:
      return is_signed ? Number::i16 : Number::u16;
    case 4:
      return is_signed ? Number::i32 : Number::u32;
    default:
      return is_signed ? Number::i64 : Number::u64;
  }
}

// Values `stride` bytes apart, the first one on an odd address.
template <class Value>
class Strided {
 public:
  explicit Strided(const std::vector<Value>& values, std::size_t stride = sizeof(Value))
      : bytes_(values.size() * stride + 9), stride_(stride) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      std::memcpy(&bytes_[1 + i * stride], &values[i], sizeof(Value));
    }
  }
  NumberColumn column() const {
    return {&bytes_[1], static_cast<std::ptrdiff_t>(stride_), number<Value>()};
  }

 private:
  std::vector<std::byte> bytes_;
  std::size_t stride_;
};

std::vector<int> small_numbers(std::size_t count, int below) {
  const CounterRandom random(7);
  std::vector<int> values(count);
  for (std::size_t i = 0; i < count; ++i) {
    values[i] = static_cast<int>(random(i) % static_cast<std::uint64_t>(below));
  }
  return values;
}

template <class Value>
void every_column_as(std::size_t count, std::size_t stride) {
  const std::vector<int> numbers = small_numbers(count, 100);
  const Strided<Value> column({numbers.begin(), numbers.end()}, stride);
  const NumberColumn source = column.column();
  std::vector<Event> events(count);
  ASSERT_TRUE(gather({.t = source, .x = source, .y = source, .p = source}, events));
  for (std::size_t i = 0; i < count; ++i) {
    const Event expected{static_cast<std::uint16_t>(numbers[i]),
                         static_cast<std::uint16_t>(numbers[i]), numbers[i] > 0, numbers[i]};
    ASSERT_EQ(events[i], expected) << i;
  }
}

TEST(Columns, TakeEveryWidthStrideAndLength) {
  for (const std::size_t count : {0U, 1U, 511U, 512U, 513U, 2000U}) {
    for (const std::size_t padding : {0U, 5U}) {
      every_column_as<std::uint8_t>(count, 1 + padding);
      every_column_as<std::uint16_t>(count, 2 + padding);
      every_column_as<std::uint32_t>(count, 4 + padding);
      every_column_as<std::uint64_t>(count, 8 + padding);
      every_column_as<std::int8_t>(count, 1 + padding);
      every_column_as<std::int16_t>(count, 2 + padding);
      every_column_as<std::int32_t>(count, 4 + padding);
      every_column_as<std::int64_t>(count, 8 + padding);
      every_column_as<double>(count, 8 + padding);
    }
  }
}

// Fields of one structure go another way than columns that lie apart: both see the same.
template <class Time, class Address, class Polarity>
void fields_are_as_columns(std::size_t stride, bool normalise) {
  constexpr std::size_t kCount = 700, kWays = 4;
  const CounterRandom random(3);
  for (std::size_t bad = 0; bad < kWays; ++bad) {
    std::vector<Time> t;
    std::vector<Address> x, y;
    std::vector<Polarity> p;
    for (std::uint64_t i = 0; i < kCount; ++i) {
      const std::uint64_t bits = random(i);
      t.push_back(static_cast<Time>(bits >> 8));
      x.push_back(static_cast<Address>(bits >> 49));
      y.push_back(static_cast<Address>(bits >> 33 & 0x7fff));
      p.push_back(static_cast<Polarity>(bits & (bits % 7 == 0 ? 0xff : 1)));
    }
    if (bad == 1) t[500] = static_cast<Time>(std::int64_t{1} << 63);
    if (bad == 2) x[0] = static_cast<Address>(-1);
    if (bad == 3) y.back() = static_cast<Address>(-1);
    std::vector<std::byte> fields(kCount * stride);
    const auto place = [&](const auto& values, std::size_t at, Number type) {
      for (std::size_t i = 0; i < kCount; ++i) {
        std::memcpy(&fields[i * stride + at], &values[i], sizeof values[i]);
      }
      return NumberColumn{&fields[at], static_cast<std::ptrdiff_t>(stride), type};
    };
    const EventColumns together{.t = place(t, 0, number<Time>()),
                                .x = place(x, 8, number<Address>()),
                                .y = place(y, 10, number<Address>()),
                                .p = place(p, 12, number<Polarity>()),
                                .normalise = normalise};
    const Strided<Time> ts(t);
    const Strided<Address> xs(x), ys(y);
    const Strided<Polarity> ps(p);
    const EventColumns apart{.t = ts.column(),
                             .x = xs.column(),
                             .y = ys.column(),
                             .p = ps.column(),
                             .normalise = normalise};
    std::vector<Event> events(kCount), expected(kCount);
    const bool good = gather(apart, expected);
    EXPECT_EQ(gather(together, events), good) << bad;
    EXPECT_EQ(good, bad == 0 || (bad > 1 && std::is_unsigned_v<Address>)) << bad;
    if (good) {
      EXPECT_EQ(events, expected);
    }
  }
}

TEST(Columns, FieldsOfAStructureAreReadAlike) {
  for (const bool normalise : {false, true}) {
    fields_are_as_columns<std::int64_t, std::uint16_t, std::uint8_t>(13, normalise);
    fields_are_as_columns<std::int64_t, std::uint16_t, std::int8_t>(13, normalise);
    fields_are_as_columns<std::int64_t, std::uint16_t, std::int16_t>(16, normalise);
    fields_are_as_columns<std::int64_t, std::int16_t, std::uint8_t>(16, normalise);
    fields_are_as_columns<std::int64_t, std::int16_t, std::int8_t>(16, normalise);
    fields_are_as_columns<std::int64_t, std::int16_t, std::int16_t>(14, normalise);
    fields_are_as_columns<std::uint64_t, std::uint16_t, std::uint8_t>(13, normalise);
    fields_are_as_columns<std::uint64_t, std::uint16_t, std::int8_t>(16, normalise);
    fields_are_as_columns<std::uint64_t, std::uint16_t, std::int16_t>(16, normalise);
  }
}

// A value as time, as address and as polarity of one event, the others zero.
template <class Value>
std::optional<Event> one(char role, Value value, double us_per_unit = 1.0, bool normalise = true) {
  const Strided<Value> column({value});
  const Strided<std::uint8_t> zero({0});
  EventColumns columns{.t = zero.column(),
                       .x = zero.column(),
                       .y = zero.column(),
                       .p = zero.column(),
                       .us_per_unit = us_per_unit,
                       .normalise = normalise};
  (role == 't'   ? columns.t
   : role == 'x' ? columns.x
   : role == 'y' ? columns.y
                 : *columns.p) = column.column();
  std::array<Event, 1> event;
  if (!gather(columns, event)) return std::nullopt;
  return event[0];
}

TEST(Columns, RefuseAnAddressThatIsNone) {
  for (const char role : {'x', 'y'}) {
    EXPECT_TRUE(one<std::int32_t>(role, 65535));
    EXPECT_FALSE(one<std::int32_t>(role, 65536));
    EXPECT_FALSE(one<std::int8_t>(role, -1));
    EXPECT_FALSE(one<std::int64_t>(role, -1));
    EXPECT_FALSE(one<std::int64_t>(role, std::int64_t{1} << 40));
    EXPECT_FALSE(one<std::uint64_t>(role, std::uint64_t{1} << 63));
    EXPECT_TRUE(one(role, 65535.0));
    for (const double bad : {65536.0, -1.0, 0.5, 1e300, -1e300, std::nan(""),
                             std::numeric_limits<double>::infinity()}) {
      EXPECT_FALSE(one(role, bad)) << bad;
    }
  }
  EXPECT_EQ(one('x', 65535.0)->x, 65535);
  EXPECT_EQ(one('y', 7.0)->y, 7);
}

TEST(Columns, RefuseATimeThatIsNone) {
  constexpr std::uint64_t kTop = std::uint64_t{1} << 63;
  EXPECT_EQ(one('t', kTop - 1)->t, std::numeric_limits<std::int64_t>::max());
  EXPECT_FALSE(one('t', kTop));
  EXPECT_EQ(one<std::int64_t>('t', -5)->t, -5);
  EXPECT_FALSE(one('t', std::numeric_limits<std::int64_t>::min()));
  EXPECT_FALSE(one('t', std::nan("")));
  EXPECT_FALSE(one('t', 0x1p62));
  EXPECT_FALSE(one('t', 0x1p62 / 1e6, 1e6));
  EXPECT_TRUE(one('t', 4e12, 1e6));
}

TEST(Columns, RoundFloatingTimesHalfToEven) {
  EXPECT_EQ(one('t', 0.5)->t, 0);
  EXPECT_EQ(one('t', 1.5)->t, 2);
  EXPECT_EQ(one('t', -2.5)->t, -2);
  EXPECT_EQ(one('t', 0x1p51 + 0.5)->t, std::int64_t{1} << 51);
  EXPECT_EQ(one('t', 0x1p51 + 1.5)->t, (std::int64_t{1} << 51) + 2);
  EXPECT_EQ(one('t', 1504645177.4209850, 1e6)->t, 1504645177420985);
  EXPECT_EQ(one('t', 2500.0, 1e-3)->t, 2);
}

TEST(Columns, NormaliseThePolarityOrMarkIt) {
  for (const auto& [value, plain, marked] :
       {std::array{0, 0, 0}, {1, 1, 1}, {-1, 0, -1}, {2, 1, 2}, {127, 1, 2}, {-128, 0, -1}}) {
    EXPECT_EQ(one('p', static_cast<std::int8_t>(value))->p, plain) << value;
    EXPECT_EQ(one('p', static_cast<std::int8_t>(value), 1.0, false)->p, marked) << value;
    EXPECT_EQ(one('p', static_cast<double>(value), 1.0, false)->p, marked) << value;
  }
  EXPECT_EQ(one('p', 0.5)->p, 1);
  EXPECT_EQ(one('p', 0.5, 1.0, false)->p, 2);
  EXPECT_FALSE(one('p', std::nan("")));
}

}  // namespace
}  // namespace asap::columns_test
