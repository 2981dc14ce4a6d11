#include "asap/formats/text.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string_view>

#include "asap/core/check.hpp"
#include "formats/decimal.hpp"

namespace asap {

namespace {

constexpr std::string_view kLetters = "txyp-";
constexpr std::int64_t kMaxAddress = std::numeric_limits<std::uint16_t>::max();

bool is_separator(char c) noexcept {
  return c == ' ' || c == ',' || c == '\t' || c == ';' || c == '\r';
}

const char* skip_separators(const char* at, const char* end) noexcept {
  while (at != end && is_separator(*at)) ++at;
  return at;
}

const char* skip_field(const char* at, const char* end) noexcept {
  while (at != end && !is_separator(*at)) ++at;
  return at;
}

// The value's sign survives: 0.5 is ON.
std::int16_t to_polarity(const Decimal& number) noexcept {
  if (number.digits == 0) return 0;
  const std::int64_t value =
      std::clamp<std::int64_t>(round_decimal(number, 0).value, -32768, 32767);
  if (value != 0) return static_cast<std::int16_t>(value);
  return number.negative ? -1 : 1;
}

}  // namespace

TextDecoder::TextDecoder(const TextConfig& config)
    : time_exponent_(config.time_exponent),
      clamp_(config.clamp),
      line_offset_(config.first_offset) {
  const auto count = [&](char letter) { return std::ranges::count(config.order, letter); };
  const bool known = config.order.find_first_not_of(kLetters) == std::string::npos;
  const bool complete = count('t') == 1 && count('x') == 1 && count('y') == 1 && count('p') <= 1;
  if (!known || !complete || config.order.size() > kMaxColumns) {
    throw_bad_value("order", "'" + config.order + "'",
                    "name the columns with t, x, y and p, each once (p may be absent), such as "
                    "'txyp' or 'yxt'");
  }
  require(config.time_exponent >= -9 && config.time_exponent <= 9, "time_exponent",
          config.time_exponent, "use 6 for seconds, 3 for ms, 0 for us, -3 for ns");
  for (const char letter : config.order) {
    columns_[column_count_++] = static_cast<Column>(kLetters.find(letter));
  }
}

void TextDecoder::decode(std::span<const char> bytes, std::vector<Event>& events) {
  const char* at = bytes.data();
  const char* const end = at + bytes.size();
  while (at != end) {
    const auto* newline =
        static_cast<const char*>(std::memchr(at, '\n', static_cast<std::size_t>(end - at)));
    if (newline == nullptr) return keep_unfinished(at, end);
    if (unfinished_length_ == 0) {
      take(at, newline, events);
      line_offset_ += static_cast<std::uint64_t>(newline - at) + 1;
    } else {
      keep_unfinished(at, newline);
      finish(events);
      ++line_offset_;
    }
    at = newline + 1;
  }
}

bool TextDecoder::finish(std::vector<Event>& events) {
  const char* const line = unfinished_.data();
  const Line result = take(line, line + unfinished_size_, events);
  line_offset_ += unfinished_length_;
  unfinished_size_ = unfinished_length_ = 0;
  return result == Line::event || result == Line::empty;
}

void TextDecoder::keep_unfinished(const char* begin, const char* end) noexcept {
  const auto length = static_cast<std::size_t>(end - begin);
  const std::size_t kept = std::min(length, unfinished_.size() - unfinished_size_);
  std::memcpy(unfinished_.data() + unfinished_size_, begin, kept);
  unfinished_size_ += kept;
  unfinished_length_ += length;
}

TextDecoder::Line TextDecoder::take(const char* begin, const char* end,
                                    std::vector<Event>& events) {
  Event event{.x = 0, .y = 0, .p = 1, .t = 0};
  const Line line = parse(begin, end, event);
  if (line == Line::event) {
    events.push_back(event);
    return line;
  }
  if (line == Line::empty) return line;
  bad_records_ += line == Line::bad_record;
  out_of_bounds_ += line == Line::out_of_bounds;
  if (noted_count_ < kNoted) noted_[noted_count_++] = line_offset_;
  return line;
}

TextDecoder::Line TextDecoder::parse(const char* at, const char* end, Event& event) noexcept {
  // The part beyond the limit is ignored here too, as an unfinished line has lost it.
  const bool too_long = static_cast<std::size_t>(end - at) > kMaxLine;
  if (too_long) end = at + kMaxLine + 1;
  at = skip_separators(at, end);
  if (at != end && (*at == '#' || *at == '%')) return Line::empty;
  if (too_long) return Line::bad_record;
  if (at == end) return Line::empty;

  bool inside = true;
  const auto address = [&](const Rounded& number) {
    const std::int64_t nearest = std::clamp<std::int64_t>(number.value, 0, kMaxAddress);
    inside &= nearest == number.value;
    return static_cast<std::uint16_t>(nearest);
  };
  for (std::size_t i = 0; i < column_count_; ++i) {
    const Column column = columns_[i];
    if (at == end) return Line::bad_record;
    if (column == Column::skipped) {
      at = skip_separators(skip_field(at, end), end);
      continue;
    }
    Decimal number;
    at = read_decimal(at, end, number);
    if (at == nullptr || (at != end && !is_separator(*at))) return Line::bad_record;
    at = skip_separators(at, end);
    if (column == Column::t) {
      event.t = round_decimal(number, time_exponent_).value;
    } else if (column == Column::p) {
      event.p = to_polarity(number);
    } else {
      const Rounded rounded = round_decimal(number, 0);
      if (!rounded.exact) return Line::bad_record;
      (column == Column::x ? event.x : event.y) = address(rounded);
    }
  }
  if (at != end) return Line::bad_record;
  if (inside) return Line::event;
  if (!clamp_) return Line::out_of_bounds;
  ++clamped_positions_;
  return Line::event;
}

}  // namespace asap
