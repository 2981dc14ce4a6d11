#include "formats/columns.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace asap::inline v0_1 {

namespace {

constexpr std::size_t kColumnBlock = 512;
constexpr std::int64_t kMaxColumnAddress = 65535;

// One value at a time: true where an event can hold it, which is then in `out`. No branches, so
// that loops over neighbouring values are vectorised.
struct ToAddress {
  using Out = std::uint16_t;
  template <class Value>
  bool operator()(Value value, Out& out) const noexcept {
    if constexpr (std::is_floating_point_v<Value>) {
      const bool inside = value >= 0 && value <= kMaxColumnAddress;
      out = static_cast<Out>(static_cast<std::int32_t>(inside ? value : 0));
      return inside && out == value;
    } else {
      out = static_cast<Out>(value);
      if constexpr (sizeof(Value) <= sizeof(Out)) return value >= 0;  // cheaper
      return out == value;
    }
  }
};

struct ToPolarity {
  using Out = std::int16_t;
  bool normalise;
  template <class Value>
  bool operator()(Value value, Out& out) const noexcept {
    const bool on = value > 0;
    const bool odd = !normalise && value != static_cast<Value>(on);
    out = static_cast<Out>(on + (odd ? (on ? 1 : -1) : 0));
    return value == value;  // not NaN
  }
};

struct ToMicroseconds {
  using Out = std::int64_t;
  double us_per_unit;
  template <class Value>
  bool operator()(Value value, Out& out) const noexcept {
    if constexpr (std::is_floating_point_v<Value>) {
      const bool in_reach = std::abs(value) < 0x1p62 / us_per_unit;
      const double us = in_reach ? value * us_per_unit : 0.0;
      constexpr double kRounds = 0x1.8p52;  // added and taken away: half to even below 2^51
      const double rounded = std::abs(us) < 0x1p51 ? us + kRounds - kRounds : std::nearbyint(us);
      out = static_cast<Out>(rounded);
      return in_reach;
    } else {
      out = static_cast<Out>(value);
      if constexpr (std::is_same_v<Value, std::uint64_t>) return out >= 0;
      return out != std::numeric_limits<Out>::min();
    }
  }
};

template <class Value, class Convert>
bool convert_as(const NumberColumn& column, std::size_t first, std::size_t count, Convert convert,
                typename Convert::Out* out) noexcept {
  const std::byte* from = column.first + static_cast<std::ptrdiff_t>(first) * column.stride;
  const auto loop = [&](std::ptrdiff_t stride) {
    bool good = true;
    for (std::size_t i = 0; i < count; ++i) {
      Value value;
      std::memcpy(&value, from + static_cast<std::ptrdiff_t>(i) * stride, sizeof value);
      good &= convert(value, out[i]);
    }
    return good;
  };
  constexpr auto kSize = static_cast<std::ptrdiff_t>(sizeof(Value));
  return column.stride == kSize ? loop(kSize) : loop(column.stride);
}

template <class Convert>
bool convert_column(const NumberColumn& column, std::size_t first, std::size_t count, Convert to,
                    typename Convert::Out* out) noexcept {
  switch (column.type) {
    case Number::u8:
      return convert_as<std::uint8_t>(column, first, count, to, out);
    case Number::u16:
      return convert_as<std::uint16_t>(column, first, count, to, out);
    case Number::u32:
      return convert_as<std::uint32_t>(column, first, count, to, out);
    case Number::u64:
      return convert_as<std::uint64_t>(column, first, count, to, out);
    case Number::i8:
      return convert_as<std::int8_t>(column, first, count, to, out);
    case Number::i16:
      return convert_as<std::int16_t>(column, first, count, to, out);
    case Number::i32:
      return convert_as<std::int32_t>(column, first, count, to, out);
    case Number::i64:
      return convert_as<std::int64_t>(column, first, count, to, out);
    case Number::f64:
      return convert_as<double>(column, first, count, to, out);
  }
  return false;
}

// x, y, p and padding of an event: two stores per event are twice as fast as five.
constexpr std::uint64_t first_word(std::uint16_t x, std::uint16_t y, std::int16_t p) noexcept {
  constexpr bool kLittle = std::endian::native == std::endian::little;
  return std::uint64_t{x} << (kLittle ? 0 : 48) | std::uint64_t{y} << (kLittle ? 16 : 32) |
         std::uint64_t{static_cast<std::uint16_t>(p)} << (kLittle ? 32 : 16);
}

// Fields of one structure, of the widths that most libraries give them: one pass without blocks is
// faster where no column is in one piece.
template <class Time, class Address, class Polarity>
bool gather_records(const EventColumns& columns, std::span<Event> events) noexcept {
  const std::byte *t = columns.t.first, *x = columns.x.first, *y = columns.y.first,
                  *p = columns.p->first;
  const std::ptrdiff_t stride = columns.t.stride;
  const auto next = [stride](auto& value, const std::byte*& at) {
    std::memcpy(&value, at, sizeof value);
    at += stride;
  };
  const ToMicroseconds to_us{columns.us_per_unit};
  const ToPolarity to_polarity{columns.normalise};
  bool good = true;
  for (Event& event : events) {
    Time time;
    Address left, top;
    Polarity on;
    next(time, t), next(left, x), next(top, y), next(on, p);
    Event to;
    good &= to_us(time, to.t);
    good &= ToAddress{}(left, to.x);
    good &= ToAddress{}(top, to.y);
    good &= to_polarity(on, to.p);
    const std::array words{first_word(to.x, to.y, to.p), static_cast<std::uint64_t>(to.t)};
    std::memcpy(&event, words.data(), sizeof words);
  }
  return good;
}

using Loop = bool (*)(const EventColumns&, std::span<Event>) noexcept;

template <class Time, class Address>
Loop loop_of(Number polarity) noexcept {
  switch (polarity) {
    case Number::u8:
      return &gather_records<Time, Address, std::uint8_t>;
    case Number::i8:
      return &gather_records<Time, Address, std::int8_t>;
    case Number::i16:
      return &gather_records<Time, Address, std::int16_t>;
    default:
      return nullptr;
  }
}

// None for columns of another kind.
Loop loop_of(const EventColumns& columns) noexcept {
  const auto& [t, x, y, p, us_per_unit, normalise] = columns;
  const bool are_fields = p && x.stride == t.stride && y.stride == t.stride &&
                          p->stride == t.stride && x.type == y.type;
  if (!are_fields) return nullptr;
  if (t.type == Number::i64 && x.type == Number::u16) {
    return loop_of<std::int64_t, std::uint16_t>(p->type);
  }
  if (t.type == Number::i64 && x.type == Number::i16) {
    return loop_of<std::int64_t, std::int16_t>(p->type);
  }
  if (t.type == Number::u64 && x.type == Number::u16) {
    return loop_of<std::uint64_t, std::uint16_t>(p->type);
  }
  return nullptr;
}

}  // namespace

bool gather(const EventColumns& columns, std::span<Event> events) noexcept {
  if (const Loop loop = loop_of(columns)) return loop(columns, events);
  std::array<std::int64_t, kColumnBlock> t;
  std::array<std::uint16_t, kColumnBlock> x;
  std::array<std::uint16_t, kColumnBlock> y;
  std::array<std::int16_t, kColumnBlock> p;
  p.fill(1);
  for (std::size_t first = 0; first < events.size(); first += kColumnBlock) {
    const std::size_t count = std::min(kColumnBlock, events.size() - first);
    const bool good =
        convert_column(columns.t, first, count, ToMicroseconds{columns.us_per_unit}, t.data()) &&
        convert_column(columns.x, first, count, ToAddress{}, x.data()) &&
        convert_column(columns.y, first, count, ToAddress{}, y.data()) &&
        (!columns.p ||
         convert_column(*columns.p, first, count, ToPolarity{columns.normalise}, p.data()));
    if (!good) return false;
    for (std::size_t i = 0; i < count; ++i) {
      const std::array words{first_word(x[i], y[i], p[i]), static_cast<std::uint64_t>(t[i])};
      std::memcpy(&events[first + i], words.data(), sizeof words);
    }
  }
  return true;
}

}  // namespace asap::inline v0_1
