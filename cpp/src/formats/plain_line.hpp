// PlainLine: the numbers of a line of text in its common form, without a branch per digit.
//
// Common: unsigned numbers without exponents (the polarity may have a minus sign), one or two
// separators between them, none around them, and a newline within kWindow characters. All other
// lines are not plain: read_decimal() is for them. One comparison finds where the digits of the
// whole line end; a multiplication joins up to eight of them (D. Lemire, "Quickly parsing eight
// digits", 2018). For little-endian machines.
// Any thread, no allocation, O(fields).
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "formats/decimal.hpp"
#include "formats/words.hpp"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace asap::inline v0_1 {

inline bool is_separator(char c) noexcept {
  constexpr std::uint64_t kSeparators = [] {
    std::uint64_t set = 0;
    for (const char separator : std::string_view(" ,\t;\r")) set |= std::uint64_t{1} << separator;
    return set;
  }();
  const auto code = static_cast<unsigned char>(c);
  return code < 64 && ((kSeparators >> code) & 1) != 0;
}

class PlainLine {
 public:
  static constexpr std::size_t kWindow = 32;
  // Characters that must follow the line's first: numbers are loaded beyond the window.
  static constexpr std::ptrdiff_t kRoom = kWindow + 16;

  explicit PlainLine(const char* line) noexcept : line_(line), others_(others_among(line)) {}

  // The most common line: t, x, y and p are whole, p has one digit, and one and the same character
  // stands between them. Returns where the next line begins; nullptr for all other lines.
  static const char* read_whole_txyp(const char* line, Event& event) noexcept {
    std::uint64_t others = others_among(line);
    const auto next = [&]() noexcept {
      const auto at = static_cast<std::uint32_t>(std::countr_zero(others | kBehindWindow));
      others &= others - 1;
      return at;
    };
    const std::uint32_t t_end = next(), x_end = next(), y_end = next(), p_end = next();
    const std::uint32_t x = x_end - t_end - 1, y = y_end - x_end - 1;
    const char separator = line[t_end];
    const bool plain = (t_end - 1 < 16) & (x - 1 < kMaxSmallDigits) & (y - 1 < kMaxSmallDigits) &
                       (p_end - y_end == 2) & is_separator(separator) & (line[x_end] == separator) &
                       (line[y_end] == separator) & (line[p_end] == '\n');
    if (!plain) return nullptr;
    write_event(&event, join_four(line + t_end + 1, x), join_four(line + x_end + 1, y),
                static_cast<std::uint64_t>(line[y_end + 1] - '0'),
                static_cast<std::int64_t>(append_digits(0, line, t_end)));
    return line + p_end + 1;
  }

  // False once something was not plain; the values read are then without meaning.
  bool plain() const noexcept { return plain_; }

  // The next number times 10^exponent.
  std::int64_t time(int exponent) noexcept {
    const char* at = line_ + at_;
    std::uint32_t digits = next_digits();
    if (digits - 1 >= 16) return refuse();
    std::uint64_t value = append_digits(0, at, digits);
    if (line_[at_] == '.') {
      at = line_ + ++at_;
      const std::uint32_t fraction = next_digits();
      if (fraction > 16) return refuse();
      digits += fraction;
      value = append_digits(value, at, fraction);
      exponent -= static_cast<int>(fraction);
    }
    if (digits > kMaxTimeDigits) return refuse();
    if (exponent == 0) return static_cast<std::int64_t>(value);
    return round_decimal({.digits = value}, exponent).value;
  }

  // The next number, a position or a polarity.
  std::uint32_t small() noexcept {
    const char* const at = line_ + at_;
    const std::uint32_t digits = next_digits();
    plain_ &= digits - 1 < kMaxSmallDigits;
    return join_four(at, digits);
  }

  // Whether a minus sign is next.
  bool sign() noexcept {
    const auto sign = static_cast<std::uint32_t>(line_[at_] == '-');
    at_ += sign;
    others_ &= others_ - sign;
    return sign != 0;
  }

  void separator() noexcept {
    plain_ &= is_separator(line_[at_++]);
    if (!is_separator(line_[at_])) return;
    ++at_;
    others_ &= others_ - 1;
  }

  // Where the next line begins.
  const char* end() noexcept {
    at_ += line_[at_] == '\r';
    plain_ &= line_[at_] == '\n';
    return line_ + at_ + 1;
  }

 private:
  static constexpr std::uint64_t kBehindWindow = std::uint64_t{1} << kWindow;
  static constexpr std::uint32_t kMaxSmallDigits = 4;  // 16 bits hold them, with a sign too
  static constexpr std::uint32_t kMaxTimeDigits = 18;  // below Rounded::kHuge
  static constexpr std::array<std::uint64_t, 9> kPowersOfTen{
      1, 10, 100, 1'000, 10'000, 100'000, 1'000'000, 10'000'000, 100'000'000};

  template <class Word>
  static Word load(const char* at) noexcept {
    Word word;
    std::memcpy(&word, at, sizeof word);
    return word;
  }

  // Bit i: character i of the window is no digit.
  static std::uint32_t others_among(const char* at) noexcept {
#if defined(__SSE2__)
    const auto digits = [](const char* half) {
      const __m128i word = _mm_loadu_si128(reinterpret_cast<const __m128i*>(half));
      const __m128i large = _mm_add_epi8(word, _mm_set1_epi8(static_cast<char>(128 - '0')));
      const __m128i below = _mm_cmplt_epi8(large, _mm_set1_epi8(static_cast<char>(10 - 128)));
      return static_cast<std::uint32_t>(_mm_movemask_epi8(below));
    };
    return ~(digits(at) | digits(at + kWindow / 2) << (kWindow / 2));
#else
    std::uint32_t others = 0;
    for (std::uint32_t i = 0; i < kWindow; i += 8) {
      const std::uint64_t word = load<std::uint64_t>(at + i) ^ 0x3030303030303030;
      const std::uint64_t large = ((word & 0x7F7F7F7F7F7F7F7F) + 0x7676767676767676) | word;
      const std::uint64_t bits = ((large & 0x8080808080808080) >> 7) * 0x0102040810204080;
      others |= static_cast<std::uint32_t>(bits >> 56) << i;
    }
    return others;
#endif
  }

  // The number that `count` digits make, at most four.
  static std::uint32_t join_four(const char* at, std::uint32_t count) noexcept {
    std::uint32_t word = load<std::uint32_t>(at) ^ 0x30303030;
    word <<= (32 - 8 * count) & 31;
    word = (word * 10 + (word >> 8)) & 0x00FF00FF;
    return (word * 0x00640001) >> 16;
  }

  // The same of one to eight.
  static std::uint64_t join_eight(const char* at, std::uint32_t count) noexcept {
    std::uint64_t word = load<std::uint64_t>(at) ^ 0x3030303030303030;
    word <<= (64 - 8 * count) & 63;
    word = word * 10 + (word >> 8);
    const std::uint64_t high = (word & 0x000000FF000000FF) * 0x000F424000000064;
    const std::uint64_t low = ((word >> 16) & 0x000000FF000000FF) * 0x0000271000000001;
    return static_cast<std::uint32_t>((high + low) >> 32);
  }

  // Appends at most 16 digits to those of `value`.
  static std::uint64_t append_digits(std::uint64_t value, const char* at,
                                     std::uint32_t count) noexcept {
    if (count > 8) {
      value = value * kPowersOfTen[8] + join_eight(at, 8);
      at += 8;
      count -= 8;
    }
    return count == 0 ? value : value * kPowersOfTen[count] + join_eight(at, count);
  }

  std::int64_t refuse() noexcept {
    plain_ = false;
    return 0;
  }

  // Moves behind the digits; returns how many there are.
  std::uint32_t next_digits() noexcept {
    const auto end = static_cast<std::uint32_t>(std::countr_zero(others_ | kBehindWindow));
    plain_ &= others_ != 0;
    others_ &= others_ - 1;
    return end - std::exchange(at_, end);
  }

  const char* line_;
  std::uint32_t others_;  // those from at_ on
  std::uint32_t at_ = 0;
  bool plain_ = true;
};

}  // namespace asap::inline v0_1
