#include "formats/columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace asap {

namespace {

constexpr std::size_t kColumnBlock = 512;
constexpr std::int64_t kMostAddress = 65535;

// One value at a time: true where an event can hold it, which is then in `out`. No branches, so
// that loops over neighbouring values are vectorised.
struct ToAddress {
  using Out = std::uint16_t;
  template <class Value>
  bool operator()(Value value, Out& out) const noexcept {
    if constexpr (std::is_floating_point_v<Value>) {
      const bool inside = value >= 0 && value <= kMostAddress;
      out = static_cast<Out>(static_cast<std::int32_t>(inside ? value : 0));
      return inside && out == value;
    } else {
      out = static_cast<Out>(value);
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

}  // namespace

bool gather(const EventColumns& columns, std::span<Event> events) noexcept {
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
    Event* out = events.data() + first;
    std::memset(static_cast<void*>(out), 0, count * sizeof(Event));
    for (std::size_t i = 0; i < count; ++i) {
      out[i].x = x[i];
      out[i].y = y[i];
      out[i].p = p[i];
      out[i].t = t[i];
    }
  }
  return true;
}

}  // namespace asap
