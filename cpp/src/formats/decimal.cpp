#include "formats/decimal.hpp"

#include <array>
#include <limits>

namespace asap::inline v0_1 {

namespace {

constexpr std::uint64_t kRoomForOneMore = (std::numeric_limits<std::uint64_t>::max() - 9) / 10;
constexpr int kMaxExponent = 9999;  // far beyond every number that fits

constexpr auto kPowersOfTen = [] {
  std::array<std::uint64_t, 20> powers{1};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = powers[i - 1] * 10;
  return powers;
}();

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

// Returns where the digits end. Those that do not fit into 64 bits are dropped and counted.
const char* read_digits(const char* at, const char* end, Decimal& number, int& dropped) noexcept {
  for (; at != end && is_digit(*at); ++at) {
    const auto digit = static_cast<std::uint64_t>(*at - '0');
    if (number.digits <= kRoomForOneMore) {
      number.digits = number.digits * 10 + digit;
    } else {
      number.more |= digit != 0;
      ++dropped;
    }
  }
  return at;
}

const char* read_exponent(const char* at, const char* end, int& exponent) noexcept {
  const bool negative = at != end && *at == '-';
  if (at != end && (*at == '-' || *at == '+')) ++at;
  if (at == end || !is_digit(*at)) return nullptr;
  int value = 0;
  for (; at != end && is_digit(*at); ++at) {
    if (value < kMaxExponent) value = value * 10 + (*at - '0');
  }
  exponent += negative ? -value : value;
  return at;
}

}  // namespace

const char* read_decimal(const char* at, const char* end, Decimal& number) noexcept {
  number = {};
  if (at != end && (*at == '-' || *at == '+')) number.negative = *at++ == '-';

  int dropped = 0;
  const char* const whole = at;
  at = read_digits(at, end, number, dropped);
  auto digits = at - whole;
  number.exponent = dropped;
  if (at != end && *at == '.') {
    dropped = 0;
    const char* const fraction = ++at;
    at = read_digits(at, end, number, dropped);
    digits += at - fraction;
    number.exponent -= static_cast<int>(at - fraction) - dropped;
  }
  if (digits == 0) return nullptr;
  if (at != end && (*at == 'e' || *at == 'E')) at = read_exponent(at + 1, end, number.exponent);
  return at;
}

Rounded round_decimal(const Decimal& number, int shift) noexcept {
  constexpr auto kHuge = static_cast<std::uint64_t>(Rounded::kHuge);
  const auto signed_value = [&](std::uint64_t value) {
    const auto magnitude = static_cast<std::int64_t>(value < kHuge ? value : kHuge);
    return number.negative ? -magnitude : magnitude;
  };
  const int exponent = number.exponent + shift;
  const std::uint64_t digits = number.digits;
  if (digits == 0) return {.value = 0, .exact = !number.more};

  if (exponent >= 0) {
    const bool fits = exponent < static_cast<int>(kPowersOfTen.size()) &&
                      digits <= kHuge / kPowersOfTen[static_cast<std::size_t>(exponent)];
    const std::uint64_t value =
        fits ? digits * kPowersOfTen[static_cast<std::size_t>(exponent)] : kHuge;
    return {.value = signed_value(value), .exact = !number.more};
  }
  if (-exponent >= static_cast<int>(kPowersOfTen.size())) return {.value = 0, .exact = false};

  const std::uint64_t divisor = kPowersOfTen[static_cast<std::size_t>(-exponent)];
  const std::uint64_t quotient = digits / divisor;
  const std::uint64_t rest = digits % divisor;
  const std::uint64_t to_next = divisor - rest;
  const bool tie = rest == to_next && !number.more;
  const bool up = tie ? (quotient & 1) != 0 : rest >= to_next;
  return {.value = signed_value(quotient + up), .exact = rest == 0 && !number.more};
}

}  // namespace asap::inline v0_1
