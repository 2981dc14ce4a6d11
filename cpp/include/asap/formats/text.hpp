// TextDecoder: events from lines of numbers, "t x y p" or any other arrangement, as they arrive.
//
// One thread. Feed it bytes cut anywhere; an unfinished line waits in a fixed buffer for its end.
// Columns are separated by blanks, tabs, commas or semicolons; empty lines and lines that begin
// with '#' or '%' are skipped. A line that is not an event is counted with its byte offset, never
// thrown. O(bytes); allocates only in a vector that it fills. Polarity passes as it is written,
// within 16 bits, and timestamps as they come: order, sensor size and polarity are the Validator's.
//
//   TextDecoder decoder;
//   decoder.decode(bytes, events);
//   decoder.finish(events);  // the last line may have no end
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "asap/core/event.hpp"
#include "asap/formats/decoder.hpp"

namespace asap::inline v0_1 {

struct TextConfig {
  std::string order = "txyp";  // a letter per column: t, x and y once, p at most once; '-' skips
  int time_exponent = 6;       // times are in 10^time_exponent us: 6 seconds, 0 us, -3 ns
  bool clamp = false;          // positions beyond 16 bits move to the edge
  std::uint64_t first_offset = 0;  // offset in the file of the first byte that is fed
};

class TextDecoder {
 public:
  static constexpr std::size_t kMaxLine = 1024;  // bytes; a longer line is no event
  static constexpr std::size_t kMaxColumns = 16;

  explicit TextDecoder(const TextConfig& config = {});

  // Decodes lines from the front of `bytes` into `events` until one of them ends. A line gives at
  // most one event.
  [[nodiscard]] Progress decode(std::span<const std::byte> bytes, std::span<Event> events) noexcept;

  // Appends the events of all lines that end in `bytes`.
  void decode(std::span<const std::byte> bytes, std::vector<Event>& events);

  // The end of the input: decodes a last line that has no newline. Returns false if that line is
  // bad, which means that the file was cut.
  bool finish(std::vector<Event>& events);

  // Room that the events of so many bytes never fill, so that all bytes are consumed: a column has
  // a character and a separator, and one line may have begun before.
  std::size_t room_for(std::size_t bytes) const noexcept { return bytes / (2 * column_count_) + 2; }

  // Lines with data = events + bad_records() + out_of_bounds()
  std::uint64_t bad_records() const noexcept { return undecoded_.count() - out_of_bounds_; }
  std::uint64_t out_of_bounds() const noexcept { return out_of_bounds_; }  // beyond 16 bits
  std::uint64_t clamped_positions() const noexcept { return clamped_positions_; }

  // Byte offsets of the first lines that were not decoded.
  std::span<const std::uint64_t> noted() const noexcept { return undecoded_.noted(); }

 private:
  enum class Column : std::uint8_t { t, x, y, p, skipped };
  enum class Line : std::uint8_t { event, empty, bad_record, out_of_bounds };

  const char* plain_lines(const char* at, const char* end, std::span<Event> events,
                          std::size_t& written) const noexcept;
  Line take(const char* begin, const char* end, Event& event) noexcept;
  Line take_unfinished(Event& event) noexcept;
  Line parse(const char* at, const char* end, Event& event) noexcept;
  void keep_unfinished(const char* begin, const char* end) noexcept;

  std::array<Column, kMaxColumns> columns_{};
  std::size_t column_count_ = 0;
  bool plain_ = true;     // no column is skipped
  bool is_txyp_ = false;  // the order that is worth a loop of its own
  int time_exponent_;
  bool clamp_;
  std::uint64_t line_offset_;
  std::uint64_t out_of_bounds_ = 0;
  std::uint64_t clamped_positions_ = 0;
  BadRecords undecoded_;
  std::array<char, kMaxLine + 1> unfinished_{};
  std::size_t unfinished_size_ = 0;    // bytes kept
  std::size_t unfinished_length_ = 0;  // bytes seen, kept or not
};

}  // namespace asap::inline v0_1
