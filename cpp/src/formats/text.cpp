#include "asap/formats/text.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <string_view>

#include "core/check.hpp"
#include "formats/decimal.hpp"
#include "formats/plain_line.hpp"

namespace asap::inline v0_1 {

namespace {

constexpr std::string_view kLetters = "txyp-";
constexpr std::size_t kBlock = 256;  // events that a vector takes at once
constexpr std::int64_t kMaxAddress = std::numeric_limits<std::uint16_t>::max();

const char* skip_separators(const char* at, const char* end) noexcept {
  while (at != end && is_separator(*at)) ++at;
  return at;
}

const char* skip_field(const char* at, const char* end) noexcept {
  while (at != end && !is_separator(*at)) ++at;
  return at;
}

constexpr std::size_t kX = 1, kY = 2, kP = 3;  // places in kLetters

// The value's sign survives: 0.5 is ON.
std::int16_t to_polarity(const Decimal& number) noexcept {
  if (number.digits == 0) return 0;
  const std::int64_t value =
      std::clamp<std::int64_t>(round_decimal(number, 0).value, -32768, 32767);
  if (value != 0) return static_cast<std::int16_t>(value);
  return number.negative ? -1 : 1;
}

// Polarity as pandas writes a bool; null if the field is no such word.
const char* read_truth(const char* at, const char* end, std::int16_t& p) noexcept {
  const char* const after = skip_field(at, end);
  const std::string_view word(at, static_cast<std::size_t>(after - at));
  const bool is_true = word == "True" || word == "true";
  if (!is_true && word != "False" && word != "false") return nullptr;
  p = is_true;
  return after;
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
  is_txyp_ = config.order == "txyp";
  plain_ = std::endian::native == std::endian::little && count('-') == 0;
}

Progress TextDecoder::decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept {
  const auto* const begin = reinterpret_cast<const char*>(bytes.data());
  const char* at = begin;
  const char* const end = at + bytes.size();
  std::size_t written = 0;
  while (at != end) {
    if (plain_ && unfinished_length_ == 0) {
      const char* const line = at;
      at = plain_lines(at, end, events, written);
      line_offset_ += static_cast<std::uint64_t>(at - line);
      if (at == end) break;
    }
    const auto* newline =
        static_cast<const char*>(std::memchr(at, '\n', static_cast<std::size_t>(end - at)));
    if (newline == nullptr) {
      keep_unfinished(at, end);
      at = end;
      break;
    }
    if (written == events.size()) break;
    if (unfinished_length_ == 0) {
      written += take(at, newline, events[written]) == Line::event;
      line_offset_ += static_cast<std::uint64_t>(newline - at) + 1;
    } else {
      keep_unfinished(at, newline);
      written += take_unfinished(events[written]) == Line::event;
      ++line_offset_;
    }
    at = newline + 1;
  }
  return {.bytes = static_cast<std::size_t>(at - begin), .events = written};
}

void TextDecoder::decode(std::span<const std::byte> bytes, std::vector<Event>& events) {
  std::array<Event, kBlock> block;  // on the stack: a vector would be zeroed first
  while (!bytes.empty()) {
    const Progress progress = decode(bytes, std::span(block));
    events.insert(events.end(), block.begin(),
                  block.begin() + static_cast<std::ptrdiff_t>(progress.events));
    bytes = bytes.subspan(progress.bytes);
  }
}

bool TextDecoder::finish(std::vector<Event>& events) {
  Event event;
  const Line result = take_unfinished(event);
  if (result == Line::event) events.push_back(event);
  return result == Line::event || result == Line::empty;
}

TextDecoder::Line TextDecoder::take_unfinished(Event& event) noexcept {
  const char* const line = unfinished_.data();
  const Line result = take(line, line + unfinished_size_, event);
  line_offset_ += unfinished_length_;
  unfinished_size_ = unfinished_length_ = 0;
  return result;
}

void TextDecoder::keep_unfinished(const char* begin, const char* end) noexcept {
  const auto length = static_cast<std::size_t>(end - begin);
  const std::size_t kept = std::min(length, unfinished_.size() - unfinished_size_);
  std::memcpy(unfinished_.data() + unfinished_size_, begin, kept);
  unfinished_size_ += kept;
  unfinished_length_ += length;
}

TextDecoder::Line TextDecoder::take(const char* begin, const char* end, Event& event) noexcept {
  Event found{.x = 0, .y = 0, .p = 1, .t = 0};
  const Line line = parse(begin, end, found);
  if (line == Line::event) event = found;
  if (line == Line::event || line == Line::empty) return line;
  out_of_bounds_ += line == Line::out_of_bounds;
  undecoded_.add(line_offset_);
  return line;
}

// Stops at the first line that is not plain, which parse() then reads.
const char* TextDecoder::plain_lines(const char* at, const char* end, std::span<Event> events,
                                     std::size_t& written) const noexcept {
  const auto lines = [&](auto read) noexcept {
    Event* to = events.data() + written;
    const Event* const full = events.data() + events.size();
    while (to != full && end - at >= PlainLine::kRoom) {
      const char* const next = read(at, *to);
      if (next == nullptr) break;
      ++to;
      at = next;
    }
    written = static_cast<std::size_t>(to - events.data());
    return at;
  };
  const auto read_fields = [this](const char* from, Event& event,
                                  const auto& columns) noexcept -> const char* {
    PlainLine line(from);
    std::int64_t t = 0;
    std::array<std::uint32_t, 4> small{0, 0, 0, 1};  // placed as in kLetters
    bool negative = false;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (i > 0) line.separator();
      if (columns[i] == Column::t) {
        t = line.time(time_exponent_);
      } else {
        if (columns[i] == Column::p) negative = line.sign();
        small[static_cast<std::size_t>(columns[i])] = line.small();
      }
    }
    const char* const next = line.end();
    if (!line.plain()) return nullptr;
    const auto p = static_cast<std::int32_t>(small[kP]);
    event = {.x = static_cast<std::uint16_t>(small[kX]),
             .y = static_cast<std::uint16_t>(small[kY]),
             .p = static_cast<std::int16_t>(negative ? -p : p),
             .t = t};
    return next;
  };
  if (!is_txyp_) {
    const std::span columns(columns_.data(), column_count_);
    return lines(
        [&](const char* line, Event& event) noexcept { return read_fields(line, event, columns); });
  }
  return lines([&](const char* line, Event& event) noexcept {  // columns known: a loop unrolled
    static constexpr std::array kColumns{Column::t, Column::x, Column::y, Column::p};
    const char* next = nullptr;
    if (time_exponent_ == 0) next = PlainLine::read_whole_txyp(line, event);
    return next != nullptr ? next : read_fields(line, event, kColumns);
  });
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
    inside &= number.exact && nearest == number.value;
    return static_cast<std::uint16_t>(nearest);
  };
  for (std::size_t i = 0; i < column_count_; ++i) {
    const Column column = columns_[i];
    if (at == end) return Line::bad_record;
    if (column == Column::skipped) {
      at = skip_separators(skip_field(at, end), end);
      continue;
    }
    if (column == Column::p) {
      if (const char* const after = read_truth(at, end, event.p)) {
        at = skip_separators(after, end);
        continue;
      }
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
      if (!rounded.exact && !clamp_) return Line::bad_record;
      (column == Column::x ? event.x : event.y) = address(rounded);
    }
  }
  if (at != end) return Line::bad_record;
  if (inside) return Line::event;
  if (!clamp_) return Line::out_of_bounds;
  ++clamped_positions_;
  return Line::event;
}

}  // namespace asap::inline v0_1
