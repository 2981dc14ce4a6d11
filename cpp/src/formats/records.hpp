// decode_records: the loop of every decoder whose records fit into 64 bits.
//
// A Format says what a record is; the loop cuts the bytes into records, whole ones straight from
// the input, and keeps the one that the input cuts in the caller's buffer. One thread, no
// allocation, O(bytes). A Format has:
//   kRecord          bytes of the longest record, at most 8
//   kBigEndian       the first byte of a record is the highest of `word`, else the lowest
//   size(word)       bytes of the record at the front of `word`; right even if later bytes are 0
//   is_event(word)   whether the record gives an event
//   take(word, to)   reads the record; writes an event, or what it likes, and returns 1 or 0
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "asap/core/event.hpp"
#include "asap/formats/progress.hpp"

namespace asap::records {

inline constexpr std::size_t kWord = sizeof(std::uint64_t);

// `size` bytes as a word, the rest zero.
template <bool kBigEndian>
std::uint64_t load(const std::byte* from, std::size_t size = kWord) noexcept {
  std::uint64_t word = 0;
  std::memcpy(&word, from, size);
  constexpr bool kNative = kBigEndian == (std::endian::native == std::endian::big);
  return kNative ? word : __builtin_bswap64(word);
}

// x in the low half of xy, y in the high one: two stores instead of four.
inline void store(Event* to, std::uint32_t xy, std::uint64_t p, std::int64_t t) noexcept {
  if constexpr (std::endian::native == std::endian::little) {
    const std::uint64_t front = xy | p << 32;
    std::memcpy(static_cast<void*>(to), &front, sizeof front);
    to->t = t;
  } else {
    *to = {static_cast<std::uint16_t>(xy), static_cast<std::uint16_t>(xy >> 16),
           static_cast<std::int16_t>(p), t};
  }
}

// The front of a record whose end has not come yet.
struct Cut {
  std::span<std::byte> bytes;  // room for a record
  std::size_t& size;           // bytes kept
};

template <class Format>
Progress decode_records(Format& format, Cut cut, std::span<const std::byte> bytes,
                        std::span<Event> events) noexcept {
  static_assert(Format::kRecord <= kWord);
  const std::byte* at = bytes.data();
  const std::byte* const end = at + bytes.size();
  Event* out = events.data();
  Event* const full = out + events.size();
  const auto progress = [&] {
    return Progress{static_cast<std::size_t>(at - bytes.data()),
                    static_cast<std::size_t>(out - events.data())};
  };
  const auto keep = [&](std::size_t size) {
    if (size > 0) std::memcpy(cut.bytes.data() + cut.size, at, size);
    cut.size += size;
    at += size;
  };

  if (cut.size > 0) {
    const std::size_t whole = format.size(load<Format::kBigEndian>(cut.bytes.data(), cut.size));
    const std::size_t missing = whole - cut.size;
    if (missing > bytes.size()) {
      keep(bytes.size());
      return progress();
    }
    std::array<std::byte, kWord> record{};
    std::memcpy(record.data(), cut.bytes.data(), cut.size);
    std::memcpy(record.data() + cut.size, at, missing);
    const std::uint64_t word = load<Format::kBigEndian>(record.data());
    if (out == full && format.is_event(word)) return progress();
    Event event;
    if (format.take(word, &event) > 0) *out++ = event;
    at += missing;
    cut.size = 0;
  }
  while (static_cast<std::size_t>(end - at) >= kWord && out != full) {
    const std::uint64_t word = load<Format::kBigEndian>(at);
    out += format.take(word, out);
    at += format.size(word);
  }
  // The last few bytes; and without room, what needs none.
  while (at != end) {
    const std::size_t left = static_cast<std::size_t>(end - at);
    const std::uint64_t word = load<Format::kBigEndian>(at, std::min(left, kWord));
    const std::size_t size = format.size(word);
    if (left < size) {
      keep(left);
      break;
    }
    if (out == full && format.is_event(word)) break;
    Event event;
    if (format.take(word, &event) > 0) *out++ = event;
    at += size;
  }
  return progress();
}

}  // namespace asap::records
