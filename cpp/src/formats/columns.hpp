// Four columns of numbers, of any width, stride and alignment, gathered into events: the way in for
// structured arrays of other layouts and for files that store columns. Fields are matched by the
// caller, never by position.
//
// Any thread. O(n), no allocation: blocks that fit into the first cache are converted column by
// column, then interleaved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "asap/core/event.hpp"

namespace asap::inline v0_1 {

enum class Number : std::uint8_t { u8, u16, u32, u64, i8, i16, i32, i64, f64 };

// Values in native byte order, `stride` bytes apart, aligned or not.
struct NumberColumn {
  const std::byte* first = nullptr;
  std::ptrdiff_t stride = 0;
  Number type = Number::u8;
};

struct EventColumns {
  NumberColumn t;
  NumberColumn x;
  NumberColumn y;
  std::optional<NumberColumn> p = std::nullopt;  // none: every event is ON
  // Floating times are multiplied by it and rounded to us, half to even; integers are us.
  double us_per_unit = 1.0;
  // A polarity other than 0 and 1 becomes 0 or 1, or -1 or 2, for a validator to count.
  bool normalise = true;
};

// Fills `events` from the fronts of the columns, padding with zeros. False if a value is none that
// an event can hold; the contents of `events` are unspecified then.
[[nodiscard]] bool gather(const EventColumns& columns, std::span<Event> events) noexcept;

}  // namespace asap::inline v0_1
