// Decimal: a number as text writes it, digits x 10^exponent, and its exact rounding to an integer.
//
// Times in text are decimal seconds: through double, some lines come out one microsecond off. Here
// the digits stay integers, so the result is round(value * 10^shift), half to even, for every value
// below 2^60. Any thread, no allocation, O(length).
#pragma once

#include <cstdint>

namespace asap::inline v0_1 {

struct Decimal {
  std::uint64_t digits = 0;
  int exponent = 0;
  bool negative = false;
  bool more = false;  // non-zero digits beyond the 64 bits follow
};

// Reads [+-]digits[.digits][e[+-]digits] at the start of [at, end). Returns where it ends, or
// nullptr where there is no number.
const char* read_decimal(const char* at, const char* end, Decimal& number) noexcept;

struct Rounded {
  std::int64_t value;  // larger ones stop at +-kHuge
  bool exact;          // nothing was rounded away

  static constexpr std::int64_t kHuge = std::int64_t{1} << 62;
};

// number * 10^shift, rounded half to even.
Rounded round_decimal(const Decimal& number, int shift) noexcept;

}  // namespace asap::inline v0_1
